from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import binomtest

from scaloft_fi.results.scoring.ratio import Ratio, wilson

shares = st.integers(1, 500).flatmap(lambda whole: st.tuples(st.integers(0, whole), st.just(whole)))


@given(shares)
def test_wilsons_interval_is_within_0_and_1_and_contains_the_estimate(share: tuple[int, int]) -> None:
    low, high = wilson(*share)
    assert 0 <= low <= share[0] / share[1] <= high <= 1


@given(shares)
def test_wilsons_interval_is_the_one_scipy_computes(share: tuple[int, int]) -> None:
    theirs = binomtest(*share).proportion_ci(0.95, method="wilson")
    assert wilson(*share) == pytest.approx((theirs.low, theirs.high), abs=1e-12)


@pytest.mark.parametrize(("part", "whole"), [(-1, 3), (4, 3), (0, 0)])
def test_what_is_no_share_has_no_interval(part: int, whole: int) -> None:
    with pytest.raises(ValueError, match="is no share"):
        wilson(part, whole)


def test_zero_of_zero_is_not_a_number() -> None:
    ratio = Ratio(0, 0)
    assert (ratio.value, ratio.interval, str(ratio)) == (None, None, "0/0 = n/a")


def test_a_ratio_prints_part_whole_percent_and_interval() -> None:
    assert str(Ratio(10, 19)) == "10/19 = 53 % [32, 73]"
    assert Ratio(10, 19).plain == "10/19 = 53 %"


def test_a_part_larger_than_its_whole_is_refused() -> None:
    with pytest.raises(ValueError, match="4 of 3"):
        Ratio(4, 3)


def test_the_exact_interval_is_wider_than_wilsons_and_missing_for_nothing() -> None:
    low, high = Ratio(10, 10).exact or (0, 0)
    assert (round(low, 2), high, Ratio(0, 0).exact) == (0.69, 1, None)
