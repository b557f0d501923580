from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import binom, binomtest, fisher_exact

from scaloft_fi.results.scoring.exact import at_most, clopper_pearson, fisher

shares = st.integers(1, 300).flatmap(lambda whole: st.tuples(st.integers(0, whole), st.just(whole)))


@given(shares, shares)
def test_fishers_test_is_the_one_scipy_computes(mutant: tuple[int, int], baseline: tuple[int, int]) -> None:
    (k, n), (b, n0) = mutant, baseline
    theirs = fisher_exact([[k, n - k], [b, n0 - b]], alternative="greater")[1]
    assert float(fisher(k, n, b, n0)) == pytest.approx(theirs, rel=1e-7, abs=1e-300)


@pytest.mark.parametrize(
    ("b", "needed"),
    [(0, {2: 2, 3: 3, 5: 3, 10: 4}), (1, {3: 3, 5: 3, 10: 5}), (3, {3: 3, 5: 4, 10: 6})],
)
def test_a_family_of_32_needs_few_violations_beside_a_pool_of_50(b: int, needed: dict[int, int]) -> None:
    for n, k in needed.items():
        assert fisher(k, n, b, 50) <= 0.05 / 32 < fisher(k - 1, n, b, 50)


@pytest.mark.parametrize(("n", "needed"), [(5, None), (6, 6), (10, 7), (20, 9)])
def test_with_equal_numbers_of_flights_many_more_are_needed(n: int, needed: int | None) -> None:
    rejected = [k for k in range(n + 1) if fisher(k, n, 0, n) <= 0.05 / 32]
    assert min(rejected, default=None) == needed


@pytest.mark.parametrize(
    ("p0", "p1", "powers"),
    [
        (0, 0.5, {5: 0.19, 10: 0.83, 15: 0.98, 20: 0.99}),
        (0, 0.3, {5: 0.03, 10: 0.35, 15: 0.70, 20: 0.76}),
        (0.1, 0.5, {5: 0.12, 10: 0.47, 15: 0.67, 20: 0.84}),
        (0.3, 0.9, {5: 0.37, 10: 0.82, 15: 0.95, 20: 0.99}),
    ],
)
def test_the_power_at_5_percent_is_the_published_one(p0: float, p1: float, powers: dict[int, float]) -> None:
    for n, power in powers.items():
        chance = sum(
            binom.pmf(k, n, p1) * binom.pmf(b, n, p0)
            for k in range(n + 1)
            for b in range(n + 1)
            if fisher(k, n, b, n) <= 0.05
        )
        assert chance == pytest.approx(power, abs=0.0101)


@pytest.mark.parametrize(("k", "n", "b", "n0"), [(4, 3, 0, 1), (-1, 3, 0, 1), (0, 3, 2, 1)])
def test_what_is_no_table_is_refused(k: int, n: int, b: int, n0: int) -> None:
    with pytest.raises(ValueError, match="is no table"):
        fisher(k, n, b, n0)


@given(shares)
def test_the_binomial_tail_is_the_one_scipy_computes(share: tuple[int, int]) -> None:
    assert float(at_most(*share)) == pytest.approx(binomtest(*share, 0.5, "less").pvalue, rel=1e-9)


@given(shares)
def test_clopper_and_pearsons_interval_is_the_one_scipy_computes(share: tuple[int, int]) -> None:
    theirs = binomtest(*share).proportion_ci(0.95, method="exact")
    assert clopper_pearson(*share) == pytest.approx((theirs.low, theirs.high), abs=1e-10)


@pytest.mark.parametrize(("n", "bound"), [(5, 0.45), (10, 0.26), (20, 0.14), (60, 0.05)])
def test_no_kill_in_n_bounds_the_share_as_published(n: int, bound: float) -> None:
    assert clopper_pearson(0, n, confidence=0.9)[1] == pytest.approx(bound, abs=0.005)


@pytest.mark.parametrize(("part", "whole"), [(-1, 3), (4, 3), (0, 0)])
def test_what_is_no_share_has_no_exact_interval(part: int, whole: int) -> None:
    with pytest.raises(ValueError, match="is no share"):
        clopper_pearson(part, whole)
