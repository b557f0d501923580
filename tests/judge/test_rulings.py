from __future__ import annotations

import random

from builders import campaigns, outcome, seeded
from hypothesis import given, settings
from hypothesis import strategies as st

from scaloft_fi.judge.outcome import BASELINE, Outcome
from scaloft_fi.judge.status import Status, flights_of, rulings_of

M = "LATE-human@3s"


@given(st.one_of(campaigns(), seeded()))
@settings(deadline=None)
def test_every_flight_is_ruled_as_it_is_beside_its_baseline(flown: list[Outcome]) -> None:
    found = rulings_of(flown)
    ruled = {
        (mutant.id, situation, one.seed): one
        for mutant, situations in found.mutants.items()
        for situation, flights in situations.items()
        for one in flights
    }
    beside = flights_of(flown)
    assert len(ruled) == len(beside) == sum(len(flights) for s in found.mutants.values() for flights in s.values())
    for flight in beside:
        one = ruled[flight.outcome.mutant, flight.outcome.situation, flight.outcome.seed]
        assert one.ruling is flight.ruling
        assert tuple(one.violations) == (() if flight.status is Status.INVALID else flight.outcome.violations)
    assert sorted(one.name for one in found.baselines) == sorted(one.name for one in flown if one.mutant == BASELINE)
    assert found.draws == {(one.situation, one.seed) for one in flown if one.mutant != BASELINE and not one.invalid}
    assert found.situations == {one.situation for one in flown}


@given(seeded(), st.randoms())
@settings(deadline=None, max_examples=20)
def test_the_order_of_outcomes_changes_no_ruling(flown: list[Outcome], chance: random.Random) -> None:
    shuffled = chance.sample(flown, len(flown))
    one, other = rulings_of(flown), rulings_of(shuffled)
    assert one.mutants == other.mutants
    for situations in other.mutants.values():
        for flights in situations.values():
            assert [flight.seed for flight in flights] == sorted(flight.seed for flight in flights)


def test_there_are_rulings_where_anything_was_flown() -> None:
    assert not rulings_of([])
    assert rulings_of([outcome()])
    assert rulings_of([outcome(M)])
