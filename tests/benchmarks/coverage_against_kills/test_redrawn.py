from __future__ import annotations

from collections import Counter
from itertools import product

import numpy as np
import pytest

from experiments.coverage_against_kills.redrawn import MOST_SUBSETS, RESAMPLES, SeedSet, redrawn, resamples, seed_draws

ALIVE, FIRST, SECOND, BOTH = [False, False], [True, False], [False, True], [True, True]


@pytest.mark.parametrize("n", [1, 2, 3, 5])
def test_seeds_come_out_as_often_as_in_all_draws_with_replacement(n: int) -> None:
    seeds = [10 * number for number in range(n)]
    counted = Counter(tuple(sorted(set(drawn))) for drawn in product(seeds, repeat=n))
    assert {drawn: chance * n**n for drawn, chance in seed_draws(seeds)} == pytest.approx(counted)


def test_of_many_seeds_a_fixed_sample_of_the_sets_is_judged() -> None:
    drawn = seed_draws(range(10))
    assert len(drawn) <= MOST_SUBSETS
    assert sum(chance for _, chance in drawn) == pytest.approx(1)
    # of n draws n (1 - (1 - 1/n)^n) come out
    assert sum(chance * len(seeds) for seeds, chance in drawn) == pytest.approx(10 * (1 - 0.9**10), abs=0.5)
    assert drawn == seed_draws(range(10))
    assert len(seed_draws(range(6))) == 63


def test_mutants_are_resampled_within_their_parameter() -> None:
    weights = resamples(["a", "b", "a", "a"])
    assert (weights[:, [0, 2, 3]].sum(axis=1) == 3).all()
    assert (weights[:, 1] == 1).all()
    assert (weights == resamples(["a", "b", "a", "a"])).all()


def test_the_campaign_flown_comes_first_and_counts_equal_kill_sets_once() -> None:
    kills = np.array([FIRST, FIRST, ALIVE, BOTH])
    found = redrawn(["a", "a", "b", "b"], kills, ())
    assert (found.kill_sets[found.place] == kills).all()
    assert found.mutants[0] @ found.kill_sets.any(axis=1) == 3
    assert found.distinct[0].sum() == 2
    assert (found.mutants[1:].sum(axis=1) == 4).all()
    assert (found.distinct[1:].sum(axis=1) == 2).all()
    assert len(found.mutants) == len(found.distinct) == 1 + RESAMPLES


def test_a_redrawn_campaign_has_the_kills_of_the_seeds_that_came_out() -> None:
    one, other = np.array([FIRST, ALIVE]), np.array([FIRST, SECOND])
    sets = [SeedSet((0,), 0.25, one), SeedSet((1,), 0.25, other), SeedSet((0, 1), 0.5, one)]
    found = redrawn(["a", "b"], one, sets)
    killed = found.mutants @ found.kill_sets
    assert killed[0].tolist() == [1, 0]
    assert set(map(tuple, killed[1:].tolist())) == {(1, 0), (1, 1)}
    assert killed[1:, 1].mean() == pytest.approx(0.25, abs=0.04)
    drawn = found.distinct[1:].sum(axis=1)
    assert ((drawn == 2) == (killed[1:, 1] == 1)).all()


def test_seed_sets_without_a_kill_have_no_kill_set() -> None:
    found = redrawn(["a"], np.array([FIRST]), [SeedSet((0,), 1.0, np.array([ALIVE]))])
    assert found.distinct[0].sum() == 1
    assert not found.distinct[1:].any()
