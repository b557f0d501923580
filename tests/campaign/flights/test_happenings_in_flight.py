"""Flights in drawn worlds where things happen: shared, flown whole, flown again, and PLACEBO agree to the bit."""

from __future__ import annotations

import shutil
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import pytest
import yaml
from effort import usually
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from scaloft_fi.campaign.flight import Batch, Flight
from scaloft_fi.campaign.flights.fly import Worker, fly_log
from scaloft_fi.campaign.flights.fork import CAN_FORK
from scaloft_fi.campaign.flights.physics import Physics
from scaloft_fi.campaign.plan import alone
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.mutants.catalogue import realise
from scaloft_fi.mutants.mutant import PLACEBO
from scaloft_fi.study import Study

pytestmark = pytest.mark.flight

ROOT = Path(__file__).parents[3]
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
    study = tmp_path_factory.mktemp("study")
    for name in ("hazop", "mutants", "sim"):
        shutil.copytree(ROOT / name, study / name)
    return study


def _outcomes(study: Study, batches: list[Batch]) -> dict[str, Outcome]:
    home: list[Outcome] = []
    for batch in batches:
        Worker(study, Physics())(batch, home.append)
    return {outcome.name: outcome for outcome in home}


@pytest.mark.skipif(not CAN_FORK, reason="this platform flies every flight whole")
@settings(max_examples=usually(2, release=8), suppress_health_check=list(HealthCheck))
@given(happenings=st.lists(kinds, max_size=2), walk=walks, mutants=st.sets(st.sampled_from(MUTANTS), min_size=2))
def test_in_a_world_where_things_happen_sharing_replay_and_placebo_are_exact(
    folder: Path, happenings: list[dict[str, Any]], walk: dict[str, Any], mutants: set[str]
) -> None:
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
    shared, whole = _outcomes(study, [Batch(flights, shared=True)]), _outcomes(study, alone(flights))
    assert shared.keys() == whole.keys()
    for name, outcome in whole.items():
        assert not outcome.invalid
        assert asdict(shared[name]) == asdict(outcome)
    baseline = fly_log(study, flights[0])
    assert baseline.digest == whole[flights[0].name].digest
    assert fly_log(study, replace(flights[0], mutant=PLACEBO)).digest == baseline.digest
    assert {"person_x_m", "person_y_m"} <= baseline.signals.keys()
