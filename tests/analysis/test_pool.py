from __future__ import annotations

import pytest
from builders import campaigns, outcome, pool
from hypothesis import given

from scaloft_fi.analysis.pool import LEAST, Pair, Pool, State
from scaloft_fi.judge.outcome import BASELINE, Outcome
from scaloft_fi.judge.requirement import Kind

HERE, THERE = "T0O0W0D0H0", "T0O0W0D0H1"


@pytest.mark.parametrize(
    ("flights", "violated", "open_", "triggered", "state"),
    [
        (9, 0, 0, 9, State.UNKNOWN),
        (10, 0, 0, 4, State.VACUOUS),
        (10, 0, 0, 5, State.STEADY),
        (10, 0, 2, 10, State.OPEN),
        (10, 0, 1, 10, State.STEADY),
        (10, 1, 0, 10, State.STEADY),
        (10, 1, 1, 10, State.UNSTEADY),
        (10, 2, 0, 10, State.UNSTEADY),
        (10, 5, 0, 10, State.UNSTEADY),
        (10, 6, 0, 10, State.RED),
        (50, 46, 0, 50, State.RED),
        (50, 5, 0, 50, State.STEADY),
        (50, 6, 0, 50, State.UNSTEADY),
    ],
)
def test_a_pair_has_the_first_state_that_fits(
    flights: int, violated: int, open_: int, triggered: int, state: State
) -> None:
    pair = Pair(HERE, "SR1", Kind.SAFETY, flights, violated, open_, triggered)
    assert pair.state is state
    assert pair.tests == (state in (State.STEADY, State.UNSTEADY, State.RED))


def test_a_requirement_that_is_never_triggered_is_vacuous_and_not_held() -> None:
    found = Pool.of(pool(HERE, vacuous=("SR2",)))
    assert found.states[HERE, "SR2"] is State.VACUOUS
    assert found.states[HERE, "SR1"] is State.STEADY
    assert found.steady(HERE, Kind.SAFETY) == ("SR1",)


def test_a_requirement_that_a_crash_left_open_is_not_held() -> None:
    found = Pool.of(pool(HERE, red=LEAST, violated={"SR1": 30.0}, struck="bar"))
    assert {name: found.states[HERE, name] for name in ("SR1", "SR2", "OP1")} == {
        "SR1": State.RED,
        "SR2": State.OPEN,
        "OP1": State.OPEN,
    }


def test_one_green_flight_makes_nothing_steady() -> None:
    found = Pool.of(pool(HERE, seeds=9))
    assert found.states[HERE, "SR1"] is State.UNKNOWN
    assert found.flown == frozenset()
    assert Pool.of(pool(HERE, seeds=10)).flown == {HERE}


def test_a_requirement_that_decides_nothing_makes_no_pair() -> None:
    found = Pool.of(pool(HERE, THERE))
    assert {name for _, name in found.pairs} == {"SR1", "SR2", "OP1"}
    assert found.requirements(Kind.SAFETY) == ("SR1", "SR2")
    assert found.requirements(Kind.OPERABILITY) == ("OP1",)


@given(campaigns())
def test_mutants_and_invalid_flights_say_nothing_of_the_pool(outcomes: list[Outcome]) -> None:
    clean = [one for one in outcomes if one.mutant == BASELINE and not one.invalid]
    assert Pool.of(outcomes).pairs == Pool.of(clean).pairs
    for pair in Pool.of(outcomes).pairs.values():
        assert pair.violated + pair.open <= pair.flights
        assert pair.violated <= pair.triggered <= pair.flights


def test_a_flight_that_violates_has_triggered_the_requirement() -> None:
    flights = [outcome(BASELINE, HERE, seed, violated={"SR2": 3.0}, vacuous=("SR2",)) for seed in range(LEAST)]
    assert Pool.of(flights).states[HERE, "SR2"] is State.RED
