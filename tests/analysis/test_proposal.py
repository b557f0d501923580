"""Candidates of requirements: their reach is what the formula says, and the choice lies between both drones."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from scaloft_fi.analysis.proposal import Candidates, choose
from scaloft_fi.judge.requirement import judge_signals
from scaloft_fi.sim.log import Side, Signal

SIGNALS = tuple(
    Signal(name, unit, "", Side.TRUTH)
    for name, unit in (("elapsed_s", "s"), ("z_m", "m"), ("est_z_m", "m"), ("clearance_cart_m", "m"), ("landed", ""))
)
CANDIDATES = Candidates(SIGNALS, (("low", "z_m <= 1"),), ("cart",))
values = st.lists(st.integers(-40, 40).map(lambda n: n / 10 + 0.05), min_size=100, max_size=100)


def log(z: list[float], estimate: list[float], clearance: list[float]) -> dict[str, np.ndarray]:
    columns = (np.arange(len(z)) / 20, np.array(z), np.array(estimate), np.array(clearance), np.zeros(len(z)))
    return dict(zip((one.name for one in SIGNALS), columns, strict=True))


def test_each_signal_with_a_unit_and_each_error_of_an_estimate_is_limited_in_each_way_under_each_condition():
    assert list(CANDIDATES.terms) == ["z_m", "est_z_m", "clearance_cart_m", "abs(est_z_m - z_m)"]
    assert [one.formula for one in CANDIDATES.conditions] == ["", "low", "once(low)", "clearance_cart_m / 0.5 <= 1"]
    assert len(CANDIDATES.listed) == 4 * 2 * 6 * 4
    assert len({(*one.formula(0.5), one.above) for one in CANDIDATES.listed}) == len(CANDIDATES.listed)


@given(values, values, values, st.integers(0, 191), st.integers(-60, 60))
def test_a_flight_violates_a_candidate_where_its_reach_is_beyond_the_limit(z, estimate, clearance, number, tenths):
    signals, candidate = log(z, estimate, clearance), CANDIDATES.listed[number]
    reach, limit = CANDIDATES.reaches(signals)[number], tenths / 10
    chosen = choose([candidate], np.array([[limit - 1.0]]), np.array([[limit + 1.0]] * 3), 3)
    assert chosen is not None
    requirement = chosen.requirement("P", CANDIDATES.definitions)
    judged = judge_signals(requirement, signals, cut_short=False).reading
    signed = candidate.sign * chosen.limit
    assert abs(signed - limit) <= 0.5
    if abs(reach - signed) > 1e-9:
        assert judged.violated == (reach > signed)


def test_the_widest_margin_wins_and_a_limit_lies_between_both_drones():
    clean = np.array([[1.0, 2.0, -np.inf], [1.2, 2.2, -np.inf]])
    mutated = np.array([[1.3, 4.0, 9.0], [1.3, 4.2, 9.0], [1.3, 4.4, 9.0], [0.0, 0.0, 0.0]])
    plain = [CANDIDATES.listed[0], CANDIDATES.listed[0], CANDIDATES.listed[0]]
    chosen = choose(plain, clean, mutated, 3)
    assert chosen is not None
    assert 2.2 < chosen.limit < 4.0


@pytest.mark.parametrize("flights", [1, 2])
def test_too_few_flights_or_none_beyond_the_unmutated_drone_choose_nothing(flights: int):
    plain = [CANDIDATES.listed[0]]
    assert choose(plain, np.zeros((10, 1)), np.ones((flights, 1)), 3) is None
    assert choose(plain, np.ones((10, 1)), np.zeros((6, 1)), 3) is None


@given(st.integers(0, 10_000))
def test_the_choice_never_takes_a_limit_that_the_unmutated_drone_passes(seed: int):
    random = np.random.default_rng(seed)
    clean, mutated = random.normal(size=(8, 16)), random.normal(size=(6, 16)) + 1.0
    chosen = choose(CANDIDATES.listed[:16], clean, mutated, 3)
    if chosen is not None:
        number = CANDIDATES.listed.index(chosen.candidate)
        sign = chosen.candidate.sign
        assert clean[:, number].max() < sign * chosen.limit
        assert (mutated[:, number] > sign * chosen.limit).sum() >= 3
