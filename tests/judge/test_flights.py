from __future__ import annotations

from builders import campaigns, outcome
from hypothesis import given

from scaloft_fi.judge.outcome import BASELINE, Outcome
from scaloft_fi.judge.status import Status, flight_of, flights_of

M = "LATE-human@3s"


def test_an_invalid_flight_has_no_baseline() -> None:
    invalid = outcome(invalid="worker died")
    for flight, baseline in ((outcome(M, invalid="x"), outcome()), (outcome(M), None), (outcome(M), invalid)):
        found = flight_of(flight, baseline)
        assert (found.status, found.baseline) == (Status.INVALID, None)


@given(campaigns())
def test_every_flight_of_a_mutant_has_one_status_and_what_is_revealed_names_a_requirement(
    outcomes: list[Outcome],
) -> None:
    flights = flights_of(outcomes)
    assert len(flights) == sum(outcome.mutant != BASELINE for outcome in outcomes)
    for flight in flights:
        assert (flight.status is Status.REVEALED) == bool(flight.revealed)
        assert set(flight.revealed) <= {"SR1", "SR2"}
        assert set(flight.operability_revealed) <= {"OP1"}
