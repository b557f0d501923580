"""Replication: one exact test a pair, Holm over all of them, steady and fit pools alone."""

from __future__ import annotations

from dataclasses import replace

import pytest
from builders import outcome
from finding import found
from hypothesis import given
from hypothesis import strategies as st

from scaloft_fi.analysis.seeking import POOL, SEEDS, Replica, replicas
from scaloft_fi.analysis.stratified import Stratum, p_value

LATE, LESS = "LATE-human@3s", "LATE-human@1s"
HERE, THERE = "T0O0W0D0H1", "T0O0W0D0H0"
FINDS = (found(LATE, HERE), found(LESS, THERE))


def mutant(name: str, situation: str, violating: int):
    flown = [outcome(name, situation, seed, violated={"SR2": 7.0} if seed < violating else {}) for seed in range(SEEDS)]
    return [replace(one, seed=100_000 + one.seed) for one in flown]


def baseline(situation: str, red: int = 0, requirement: str = "SR2"):
    return [
        outcome("baseline", situation, seed, violated={requirement: 7.0} if seed < red else {}) for seed in range(POOL)
    ]


def told(violating: tuple[int, int], pools=None, **more) -> tuple[Replica, ...]:
    flown = {
        (FINDS[0].name, LATE): mutant(LATE, HERE, violating[0]),
        (FINDS[1].name, LESS): mutant(LESS, THERE, violating[1]),
    }
    return replicas(FINDS, flown, pools or {HERE: baseline(HERE), THERE: baseline(THERE)}, 100_000, 0.01, **more)


@given(st.integers(0, SEEDS), st.integers(0, SEEDS))
def test_p_is_that_of_the_one_requirement_adjusted_over_all_pairs(first, second):
    raw = [p_value([Stratum(violated, SEEDS, 0, POOL, POOL // 10)]) for violated in (first, second)]
    least = min(1.0, 2 * min(raw))
    assert sorted(one.again.p for one in told((first, second))) == pytest.approx(sorted((least, max(least, max(raw)))))


def test_a_pair_holds_where_its_p_is_at_most_alpha():
    one, other = told((10, 1))
    assert (one.holds, one.why, one.again.violated, one.again.flights) == (True, "", 10, SEEDS)
    assert (one.again.held, one.again.baselines, one.again.mission, one.again.seed) == (POOL, POOL, POOL, 100_000)
    assert not other.holds
    assert "above alpha=0.01" in other.why


@pytest.mark.parametrize(("requirement", "word"), [("SR2", "SR2 steadily"), ("OP1", "its mission")])
def test_a_pool_that_is_not_steady_or_does_not_do_its_mission_shows_nothing(requirement, word):
    pools = {HERE: baseline(HERE, 6, requirement), THERE: baseline(THERE)}
    one, other = told((10, 10), pools)
    assert (one.holds, one.again.p) == (False, 1.0)
    assert word in one.why
    assert other.holds
    anyhow, _ = told((10, 10), pools, anyhow=True)
    assert anyhow.holds is (requirement == "OP1")


def test_a_fault_that_changes_no_sample_shows_nothing():
    still = [replace(one, altered=0) for one in mutant(LATE, HERE, 10)]
    (one,) = replicas(FINDS[:1], {(FINDS[0].name, LATE): still}, {HERE: baseline(HERE)}, 0, 0.01)
    assert (one.holds, one.again.p) == (False, 1.0)
