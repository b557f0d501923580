from __future__ import annotations

from itertools import combinations, permutations, product

import numpy as np
import pytest
from grids import FIVE, keys_of
from hypothesis import given
from hypothesis import strategies as st

from experiments.coverage_against_kills.chance import (
    apfd,
    firsts,
    in_orders,
    in_subsets,
    with_replacement,
    without_replacement,
)
from experiments.coverage_against_kills.trial import Trial


def small() -> st.SearchStrategy[np.ndarray]:
    """(things, situations) of up to 5 situations."""
    rows = st.integers(2, 5).flatmap(
        lambda n: st.lists(st.lists(st.booleans(), min_size=n, max_size=n), min_size=1, max_size=4)
    )
    return rows.map(np.array)


@given(small())
def test_a_random_suite_meets_what_counting_all_suites_gives(found: np.ndarray) -> None:
    n = found.shape[1]
    chances = without_replacement(n)[found.sum(axis=1)]
    for k in range(1, n + 1):
        counted = np.mean([found[:, suite].any(axis=1) for suite in combinations(range(n), k)], axis=0)
        assert np.allclose(chances[:, k - 1], counted)


@given(small())
def test_random_draws_meet_what_counting_all_draws_gives(found: np.ndarray) -> None:
    n = found.shape[1]
    chances = with_replacement(n)[found.sum(axis=1)]
    for k in range(1, min(n, 4) + 1):
        counted = np.mean([found[:, draws].any(axis=1) for draws in product(range(n), repeat=k)], axis=0)
        assert np.allclose(chances[:, k - 1], counted)


@given(small())
def test_all_orders_together_are_random_order(found: np.ndarray) -> None:
    n = found.shape[1]
    every = np.array(list(permutations(range(n))))
    assert np.allclose(in_orders(found, every), without_replacement(n)[found.sum(axis=1)])


@given(small())
def test_all_suites_together_are_random_order(found: np.ndarray) -> None:
    n = found.shape[1]
    for size in range(1, n + 1):
        suites = np.array(list(combinations(range(n), size)))
        assert np.allclose(in_subsets(found, suites), without_replacement(n)[found.sum(axis=1), :size])


def test_the_first_to_meet_is_counted_from_0_and_never_is_the_number_of_situations() -> None:
    found = np.array([[False, True, True], [False, False, False]])
    assert firsts(found, np.array([[0, 2, 1]])).tolist() == [[1, 3]]


# expected t-way coverage of k random situations of 2^5, published to three digits
TABLE = {
    4: (0.949, 0.705, 0.431, 0.238, 0.125),
    6: (0.991, 0.851, 0.584, 0.345, 0.188),
    10: (1.0, 0.970, 0.797, 0.534, 0.312),
    16: (1.0, 0.999, 0.949, 0.758, 0.500),
    24: (1.0, 1.0, 0.998, 0.944, 0.750),
}


@pytest.mark.parametrize("k", TABLE)
def test_expected_coverage_of_the_reference_grid_is_as_published(k: int) -> None:
    trial = Trial(FIVE, tuple(keys_of(FIVE)), (), (), np.zeros((0, 32), bool))
    for strength, wanted in enumerate(TABLE[k], start=1):
        found, possible = trial.combinations(strength)
        expected = without_replacement(32)[found.sum(axis=1), k - 1].sum() / possible
        assert expected == pytest.approx(wanted, abs=6e-4)


@pytest.mark.parametrize(("t", "wanted"), [(1, 0.955), (2, 0.901), (3, 0.809), (4, 0.672), (5, 0.500)])
def test_the_expected_apfd_of_a_block_of_t_axes_is_as_published(t: int, wanted: float) -> None:
    assert apfd(without_replacement(32)[[2 ** (5 - t)]]) == pytest.approx(wanted, abs=6e-4)


@given(small(), st.randoms())
def test_apfd_is_its_definition_and_leaves_out_what_no_situation_kills(found: np.ndarray, rng) -> None:
    n = found.shape[1]
    order = list(range(n))
    rng.shuffle(order)
    places = np.argsort(order)[None, :]
    first = [min(place for place, s in enumerate(order, start=1) if row[s]) for row in found if row.any()]
    wanted = 1 - sum(first) / (n * len(first)) + 1 / (2 * n) if first else None
    assert apfd(in_orders(found, places)) == (None if wanted is None else pytest.approx(wanted))
