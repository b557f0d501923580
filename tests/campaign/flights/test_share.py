"""Flights that share their baseline's beginning against the same flights flown whole."""

from __future__ import annotations

import os
import random
from dataclasses import asdict, replace
from functools import cache
from pathlib import Path

import pytest
from effort import usually
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from scaloft_fi.campaign.flight import Batch, Flight
from scaloft_fi.campaign.flights.fly import Worker
from scaloft_fi.campaign.flights.fork import CAN_FORK
from scaloft_fi.campaign.flights.physics import Physics
from scaloft_fi.campaign.flights.share import as_baseline
from scaloft_fi.campaign.plan import alone
from scaloft_fi.judge.outcome import Outcome, Subject
from scaloft_fi.mutants.catalogue import realise
from scaloft_fi.mutants.wire import SeamCount
from scaloft_fi.sim.situation import Situation
from scaloft_fi.study import Study

ROOT = Path(__file__).parents[3]
SHORT = ("T0O0W0D0H0", "T0O0W0D0H1", "T0O0W0D1H1")
"""Situations without a corner: the shortest missions."""


def test_what_never_differs_has_its_baselines_outcome_but_for_what_it_carried() -> None:
    baseline = Outcome(Subject("baseline"), "D0", 1, ending="landed", digest="d", realised=(("D", True),), track=b"t")
    subject = Subject("LATE-human@3s", "LATE", "human", "3s")
    assert as_baseline(baseline, subject, {"person": SeamCount(7, 0, None)}) == Outcome(
        subject, "D0", 1, ending="landed", carried=7, digest="d", track=b"t"
    )


@cache
def _study() -> Study:
    """The reference study, ready to fly."""
    study = Study.open(ROOT)
    Physics().prepare(study, lambda _text: None)
    return study


def _outcomes(batches: list[Batch]) -> dict[str, Outcome]:
    home: list[Outcome] = []
    for batch in batches:
        Worker(_study(), Physics())(batch, home.append)
    assert len({outcome.name for outcome in home}) == len(home)
    return {outcome.name: outcome for outcome in home}


def _drawn(number: int) -> tuple[Flight, ...]:
    """A baseline and three mutants in a short situation; the simplest number draws as much as any other."""
    draw = random.Random(number)
    situation, seed = _study().grid.situation(draw.choice(SHORT)), draw.randrange(4)
    return tuple(Flight(mutant, situation, seed) for mutant in (None, *draw.sample(_study().catalogue, 3)))


@pytest.mark.flight
@pytest.mark.skipif(not CAN_FORK, reason="this platform flies every flight whole")
@settings(max_examples=usually(1, release=12), suppress_health_check=list(HealthCheck))
@given(number=st.integers(0, 10_000))
def test_shared_flights_are_the_whole_flights_digest_for_digest_and_field_for_field(number: int) -> None:
    flights = _drawn(number)
    shared, whole = _outcomes([Batch(flights, shared=True)]), _outcomes(alone(flights))
    assert shared.keys() == whole.keys() == {flight.name for flight in flights}
    assert not any(outcome.invalid for outcome in whole.values())
    for name, outcome in whole.items():
        assert asdict(shared[name]) == asdict(outcome)


@pytest.mark.flight
@pytest.mark.skipif(not CAN_FORK, reason="this platform flies every flight whole")
def test_faults_that_strike_at_events_strike_alike_in_shared_and_in_whole_flights() -> None:
    situation: Situation = _study().grid.situation("T0O0W0D0H1")
    mutants = [realise(_study().matrix, name) for name in ("NO-velcmd#sight", "UNINTENDED-battery#mode")]
    flights = tuple(Flight(mutant, situation, 0) for mutant in (None, *mutants))
    shared, whole = _outcomes([Batch(flights, shared=True)]), _outcomes(alone(flights))
    for name, outcome in whole.items():
        assert asdict(shared[name]) == asdict(outcome)
    velcmd, battery = (whole[flight.name] for flight in flights[1:])
    assert (velcmd.altered, battery.altered) == (20, 2)
    assert velcmd.infected_at_s is not None
    assert 5.0 < velcmd.infected_at_s < 7.0


@pytest.mark.flight
@pytest.mark.skipif(not CAN_FORK, reason="this platform flies every flight whole")
def test_a_whole_flight_that_takes_its_process_with_it_takes_no_other(monkeypatch: pytest.MonkeyPatch) -> None:
    situation: Situation = _study().grid.situation("T0O0W0D0H1")
    names = ("MORE-depth@1.25x", "REVERSE-depth", "LATE-human@3s", "LESS-depth@0.9x")
    from_take_off, deadly, late, last = flights = [
        Flight(realise(_study().matrix, name), situation, 0) for name in names
    ]
    whole, fly_whole = [], Physics.__call__

    def fly(self: Physics, study: Study, flight: Flight) -> Outcome:
        whole.append(flight)
        if flight == deadly:
            os._exit(1)
        outcome = fly_whole(self, study, flight)
        return replace(outcome, ending=f"after {len(whole)}")

    monkeypatch.setattr(Physics, "__call__", fly)
    found = _outcomes([Batch(tuple(flights), shared=True)])
    assert found[deadly.name].invalid == "its worker process died every time it was flown"
    assert not any(found[flight.name].invalid for flight in (from_take_off, late, last))
    assert (found[from_take_off.name].ending, found[late.name].ending) == ("after 1", "landed")
