"""Confirmation on fresh seeds: the score's test, alpha by candidates, no knife edges."""

from __future__ import annotations

from dataclasses import replace

import pytest
from builders import outcome, pool

from scaloft_fi.analysis.detection import Sample, Spending, detect
from scaloft_fi.analysis.pool import Pool
from scaloft_fi.analysis.seeking import FEWEST, MOST, confirmed, does_mission, room, safely_held, seeds_for, share_of
from scaloft_fi.judge.requirement import Kind

HERE = "T0O0W0D0H1"


def with_rho(flown, rhos, name="SR2"):
    return [
        replace(o, readings=tuple(replace(r, rho=rho) if r.requirement == name else r for r in o.readings))
        for o, rho in zip(flown, rhos, strict=True)
    ]


def mutant(violating: int, flights: int):
    violated = {"SR2": 7.0}
    return [
        outcome("LATE-human@3s", HERE, seed, violated=violated if seed < violating else {}) for seed in range(flights)
    ]


def test_the_shares_of_all_candidates_sum_to_alpha():
    assert sum(share_of(0.01, candidate) for candidate in range(1, 60)) == pytest.approx(0.01)


@pytest.mark.parametrize("candidate", range(1, 9))
def test_as_many_seeds_are_flown_as_decide_though_one_flight_does_not_violate(candidate):
    share, held = share_of(0.01, candidate), Pool.of(pool(HERE))
    seeds = seeds_for(held, HERE, ("SR2",), share)
    assert seeds is not None
    assert seeds >= FEWEST
    for flights, decides in ((seeds, True), (seeds - 1, False)):
        sample = Sample(HERE, ((), *((("SR2",),) * (flights - 1))), infected=True)
        assert detect("", [sample], held, Spending(share), Kind.SAFETY).detected is decides


def test_more_seeds_than_allowed_are_no_candidate():
    assert seeds_for(Pool.of(pool(HERE)), HERE, ("SR2",), 1e-12) is None
    assert seeds_for(Pool.of(pool(HERE)), HERE, (), 0.01) is None
    assert MOST < 100


def test_the_evidence_is_the_scores_own_test():
    baselines = with_rho(pool(HERE), [0.3] * 10)
    told = confirmed(mutant(6, 6), baselines, ("SR2",), 1, 0.005)
    assert told is not None
    assert (told.requirement, told.violated, told.flights, told.baselines) == ("SR2", 6, 6, 10)
    violated = tuple(("SR2",) for _ in range(6))
    judged = detect("", [Sample(HERE, violated, True)], Pool.of(baselines), Spending(0.005), Kind.SAFETY)
    assert told.p == judged.p["SR2"] <= told.alpha == 0.005


@pytest.mark.parametrize(("violating", "flights", "good"), [(6, 6, True), (5, 6, True), (2, 6, False), (2, 2, False)])
def test_too_few_violations_or_flights_confirm_nothing(violating, flights, good):
    assert (confirmed(mutant(violating, flights), pool(HERE), ("SR2",), 1, 0.005) is not None) is good


def test_nine_in_ten_baselines_must_be_above_their_own_spread():
    safe = with_rho(pool(HERE), [0.3, 0.31, 0.32, 0.3, 0.29, 0.3, 0.3, 0.31, 0.3, 0.3])
    edge = with_rho(pool(HERE), [0.01, 0.2, 0.02, 0.3, 0.03, 0.3, 0.01, 0.31, 0.02, 0.3])
    assert room("SR2", safe).enough
    assert room("SR2", safe).margin == 0.3
    assert not room("SR2", edge).enough
    assert room("SR2", edge).held < 9
    assert safely_held(Pool.of(safe), HERE, ("SR2",), safe) == ("SR2",)
    assert safely_held(Pool.of(edge), HERE, ("SR2",), edge) == ()


def test_a_requirement_that_is_not_steady_is_never_tested():
    red = pool(HERE, red=4, violated={"SR2": 5.0})
    assert safely_held(Pool.of(red), HERE, ("SR2",), red) == ()


@pytest.mark.parametrize(("missed", "good"), [(0, True), (1, True), (2, False)])
def test_the_value_of_each_axis_comes_true_in_nine_of_ten_baselines(missed, good):
    baselines = [
        replace(one, realised=(("light", True), ("person", number >= missed))) for number, one in enumerate(pool(HERE))
    ]
    assert does_mission(baselines) is good


@pytest.mark.parametrize(("red", "good"), [(0, True), (1, True), (2, False)])
def test_nine_of_ten_baselines_hold_the_operability_requirements(red, good):
    assert does_mission(pool(HERE, red=red, violated={"OP1": 5.0})) is good
