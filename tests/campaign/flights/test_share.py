"""Flights that share their baseline's beginning against the same flights flown whole, in drawn worlds too."""

from __future__ import annotations

import os
import random
from dataclasses import asdict, replace
from functools import cache
from importlib.metadata import EntryPoint
from pathlib import Path
from typing import Any

import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from options import usually
from processes import ROOT
from studies import copied

from scaloft_fi.campaign.flights.fly import CAN_FORK, Batch, Flight, Worker, fly_log
from scaloft_fi.campaign.flights.physics import Physics
from scaloft_fi.campaign.plan import alone
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.mutants.catalogue import realise
from scaloft_fi.mutants.mutant import PLACEBO
from scaloft_fi.mutants.operators import OPERATORS
from scaloft_fi.registry import PLUGIN_GROUP
from scaloft_fi.sim.situation import Situation
from scaloft_fi.study import Study

pytestmark = [pytest.mark.flight, pytest.mark.skipif(not CAN_FORK, reason="this platform flies every flight whole")]
SHORT = ("T0O0W0D0H0", "T0O0W0D0H1", "T0O0W0D1H1")
"""Situations without a corner: the shortest missions."""


@cache
def _study() -> Study:
    """The reference study, ready to fly."""
    study = Study.open(ROOT)
    Physics().prepare(study, lambda _text: None)
    return study


def _outcomes(batches: list[Batch], study: Study | None = None) -> dict[str, Outcome]:
    home: list[Outcome] = []
    for batch in batches:
        Worker(study or _study(), Physics())(batch, home.append)
    assert len({outcome.name for outcome in home}) == len(home)
    return {outcome.name: outcome for outcome in home}


def _drawn(number: int) -> tuple[Flight, ...]:
    """A baseline and three mutants in a short situation; the simplest number draws as much as any other."""
    draw = random.Random(number)
    situation, seed = _study().grid.situation(draw.choice(SHORT)), draw.randrange(4)
    return tuple(Flight(mutant, situation, seed) for mutant in (None, *draw.sample(_study().catalogue, 3)))


@settings(max_examples=usually(1, release=12), suppress_health_check=list(HealthCheck))
@given(number=st.integers(0, 10_000))
def test_shared_flights_are_the_whole_flights_digest_for_digest_and_field_for_field(number: int):
    flights = _drawn(number)
    shared, whole = _outcomes([Batch(flights, shared=True)]), _outcomes(alone(flights))
    assert shared.keys() == whole.keys() == {flight.name for flight in flights}
    assert not any(outcome.invalid for outcome in whole.values())
    for name, outcome in whole.items():
        assert asdict(shared[name]) == asdict(outcome)


def test_faults_that_strike_at_events_strike_alike_in_shared_and_in_whole_flights():
    situation: Situation = _study().grid.situation("T0O0W0D0H1")
    mutants = [realise(_study().matrix, name) for name in ("NO-velcmd#sight", "UNINTENDED-battery#mode")]
    flights = tuple(Flight(mutant, situation, 0) for mutant in (None, *mutants))
    shared, whole = _outcomes([Batch(flights, shared=True)]), _outcomes(alone(flights))
    for name, outcome in whole.items():
        assert asdict(shared[name]) == asdict(outcome)
    velcmd, battery = (whole[flight.name] for flight in flights[1:])
    assert (velcmd.altered, battery.altered) == (20, 2)
    assert 5.0 < velcmd.infected_at_s < 7.0


def test_a_whole_flight_that_takes_its_process_with_it_takes_no_other(monkeypatch: pytest.MonkeyPatch):
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


def _no_tap(_context: Any, **_arguments: Any) -> Any:
    raise RuntimeError("no antenna")


def test_an_operator_that_cannot_be_built_is_invalid_with_its_plugin_and_no_other_flight_is(
    monkeypatch: pytest.MonkeyPatch,
):
    plugin = EntryPoint("odd", __name__, PLUGIN_GROUP)
    monkeypatch.setattr("scaloft_fi.registry.plugins", lambda: (plugin,))
    monkeypatch.setitem(OPERATORS._entries, "negate", replace(OPERATORS["negate"], make=_no_tap))
    situation: Situation = _study().grid.situation("T0O0W0D0H0")
    mutants = (None, *(realise(_study().matrix, name) for name in ("REVERSE-velcmd", "LATE-human@3s")))
    flights = tuple(Flight(mutant, situation, 0) for mutant in mutants)
    for batch in (Batch(flights, shared=True), Batch(flights)):
        found = _outcomes([batch])
        assert {name.partition("/")[0]: outcome.invalid for name, outcome in found.items()} == {
            "baseline": "",
            "REVERSE-velcmd": f"plugin 'odd' of package {__name__!r}: TapError: operator 'negate' "
            "raises when it is built: RuntimeError: no antenna",
            "LATE-human@3s": "",
        }


MUTANTS = ("LATE-human@3s", "MORE-goal@1m", "UNINTENDED-collision@20s", "REVERSE-velcmd")

starts = st.one_of(
    st.fixed_dictionaries({"at_s": st.floats(0.5, 20.0)}),
    st.fixed_dictionaries({"near": st.just([0.0, 4.0]), "within_m": st.floats(0.5, 3.0)}),
)
signed = st.floats(-0.5, 0.5)
kinds = st.one_of(
    st.fixed_dictionaries({"kind": st.just("light"), "light": st.floats(0.05, 1.0), "start": starts}),
    st.fixed_dictionaries({"kind": st.just("dust"), "haze_per_m": st.floats(0.01, 0.3), "start": starts}),
    st.fixed_dictionaries({"kind": st.just("wind"), "velocity_mps": st.tuples(signed, signed, signed).map(list)}),
    st.fixed_dictionaries(
        {
            "kind": st.just("wind"),
            "velocity_mps": st.tuples(signed, signed, signed).map(list),
            "start": starts,
            "lasts_s": st.floats(0.5, 3.0),
        }
    ),
    st.fixed_dictionaries({"kind": st.just("drift"), "rate_mps": st.tuples(*[st.floats(-0.002, 0.002)] * 3).map(list)}),
)
walks = st.fixed_dictionaries(
    {
        "kind": st.just("walk"),
        "body": st.just("person"),
        "path": st.lists(st.tuples(st.floats(-1.0, 1.0), st.floats(2.0, 6.0)).map(list), min_size=1, max_size=3),
        "speed_mps": st.floats(0.2, 1.5),
        "start": starts,
    }
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return copied(tmp_path_factory.mktemp("study"))


@pytest.mark.release
@settings(max_examples=usually(1, release=8), suppress_health_check=list(HealthCheck))
@given(happenings=st.lists(kinds, max_size=2), walk=walks, mutants=st.sets(st.sampled_from(MUTANTS), min_size=2))
def test_in_a_world_where_things_happen_sharing_replay_and_placebo_are_exact(
    folder: Path, happenings: list[dict[str, Any]], walk: dict[str, Any], mutants: set[str]
):
    text = (ROOT / "sim" / "world.yaml").read_text()
    drawn = {f"h{number}": {**one, "active": True} for number, one in enumerate([*happenings, walk])}
    head, tail = text.split("\n  person:", 1)
    present = tail.replace("present: false", "present: true", 1)
    (folder / "sim" / "world.yaml").write_text(f"{head}\n  person:{present}\n{yaml.safe_dump({'happenings': drawn})}")
    study = Study(folder)
    Physics().prepare(study, lambda _text: None)
    situation = study.grid.situation("T0O0W0D0H1")
    subjects = (None, *(realise(study.matrix, name) for name in sorted(mutants)))
    flights = tuple(Flight(subject, situation, 0) for subject in subjects)
    shared, whole = _outcomes([Batch(flights, shared=True)], study), _outcomes(alone(flights), study)
    assert shared.keys() == whole.keys()
    for name, outcome in whole.items():
        assert not outcome.invalid
        assert asdict(shared[name]) == asdict(outcome)
    baseline = fly_log(study, flights[0])
    assert baseline.digest == whole[flights[0].name].digest
    assert fly_log(study, replace(flights[0], mutant=PLACEBO)).digest == baseline.digest
    assert {"person_x_m", "person_y_m"} <= baseline.signals.keys()
