from __future__ import annotations

import random
from itertools import product
from math import comb

import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import fisher_exact

from scaloft_fi.analysis.detection import Stratum, p_value


@st.composite
def strata(draw: st.DrawFn) -> Stratum:
    n, m = draw(st.integers(1, 4)), draw(st.integers(1, 12))
    return Stratum(draw(st.integers(0, n)), n, draw(st.integers(0, m)), m)


def by_enumeration(listed: list[Stratum]) -> float:
    """Every way in which the violations may fall on subject and pool, weighed by how often it occurs."""

    def gain(k: int, b: int, m: int) -> int:
        return k if 10 * b <= m else 0

    observed = sum(gain(k, b, m) for k, _, b, m, _ in listed)
    ways = [
        [
            (gain(i, k + b - i, m), comb(n, i) * comb(m, k + b - i) / comb(n + m, k + b))
            for i in range(min(n, k + b) + 1)
        ]
        for k, n, b, m, _ in listed
    ]
    total = 0.0
    for chosen in product(*ways):
        chance = 1.0
        for _, weight in chosen:
            chance *= weight
        total += chance * (sum(one for one, _ in chosen) >= observed)
    return total


@given(st.lists(strata(), max_size=4))
def test_p_is_the_share_of_all_tables_with_at_least_the_observed_sum(listed: list[Stratum]):
    assert p_value(listed) == pytest.approx(by_enumeration(listed), rel=1e-9)


@given(st.integers(1, 10), st.integers(0, 10), st.integers(10, 60))
def test_of_one_situation_with_a_green_pool_it_is_fishers_exact_test(n: int, k: int, m: int):
    k = min(k, n)
    expected = fisher_exact([[k, n - k], [0, m]], alternative="greater").pvalue
    assert p_value([Stratum(k, n, 0, m)]) == pytest.approx(expected, rel=1e-9)


@given(st.lists(strata(), max_size=6), st.randoms())
def test_the_order_of_the_situations_changes_nothing(listed: list[Stratum], chance: random.Random):
    assert p_value(chance.sample(listed, len(listed))) == p_value(listed)


@given(st.lists(strata(), max_size=4), st.integers(1, 5), st.integers(1, 50))
def test_a_situation_without_a_violation_changes_nothing(listed: list[Stratum], n: int, m: int):
    assert p_value([*listed, Stratum(0, n, 0, m)]) == p_value(listed)


def test_a_red_pool_and_a_lucky_one_contribute_nothing():
    # nine of ten baselines violate, and the tenth does not: three of three flights of the mutant prove nothing
    assert p_value([Stratum(3, 3, 9, 10)]) == 1.0
    assert p_value([Stratum(3, 3, 2, 10)]) == 1.0
    assert p_value([Stratum(3, 3, 1, 10)]) < 0.02


def test_one_seed_needs_three_situations_and_three_seeds_need_one():
    assert 2 * p_value([Stratum(1, 1, 0, 10)] * 2) == pytest.approx(0.0165, abs=5e-5)
    assert 2 * p_value([Stratum(1, 1, 0, 10)] * 3) < 0.01
    assert 2 * p_value([Stratum(3, 3, 0, 10)]) == pytest.approx(0.0070, abs=5e-5)


@pytest.mark.parametrize("wrong", [Stratum(2, 1, 0, 10), Stratum(-1, 1, 0, 10), Stratum(0, 1, 11, 10)])
def test_what_is_no_count_is_refused(wrong: Stratum):
    with pytest.raises(ValueError, match="no stratum"):
        p_value([wrong])
