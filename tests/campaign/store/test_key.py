"""What changes the key of a flight, and what does not."""

from __future__ import annotations

import shutil
from collections.abc import Mapping
from dataclasses import replace
from importlib import import_module
from pathlib import Path

import pytest
from ranges import with_range

from scaloft_fi import sources
from scaloft_fi.campaign.flight import Flight
from scaloft_fi.campaign.store.held import Keys, flight_named
from scaloft_fi.mutants.operators import OPERATORS
from scaloft_fi.study import PACKAGE, Study

ROOT = Path(__file__).parents[3]
NAMES = [(mutant, key) for mutant in ("baseline", "LATE-human@3s") for key in ("T0O0W0D0H0", "T1O0W0D1H1")]


@pytest.fixture
def copy(tmp_path: Path) -> Path:
    for name in ("hazop", "mutants", "sim"):
        shutil.copytree(ROOT / name, tmp_path / name)
    return tmp_path


def _flights(study: Study) -> dict[tuple[str, str], Flight]:
    return {name: flight_named(study, *name, 0) for name in NAMES}


def _stale(copy: Path, file: str, old: str, new: str) -> dict[tuple[str, str], tuple[str, ...]]:
    """Which parts of which flights an edit changes; a flight is left out when its key stays."""
    before, path = Study(copy), copy / "sim" / file
    then = {name: (Keys(before).origin(f), Keys(before).key(f)) for name, f in _flights(before).items()}
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))
    keys, found = Keys(Study(copy)), {}
    for name, flight in _flights(Study(copy)).items():
        origin, key = then[name]
        changed = origin.changed(keys.origin(flight))
        assert bool(changed) == (key != keys.key(flight))
        if changed:
            found[name] = changed
    return found


def test_an_edit_of_the_world_changes_every_flight(copy: Path) -> None:
    assert _stale(copy, "world.yaml", "light: 0.9", "light: 0.8") == dict.fromkeys(NAMES, ("sim",))


def test_an_edit_of_a_requirement_changes_every_flight(copy: Path) -> None:
    edited = _stale(copy, "requirements.yaml", "speed_mps / 0.25", "speed_mps / 0.30")
    assert edited == dict.fromkeys(NAMES, ("requirements",))


def test_an_edit_of_a_value_changes_the_situations_that_have_it(copy: Path) -> None:
    edited = _stale(copy, "situations.yaml", "light: 0.0", "light: 0.01")
    assert edited == dict.fromkeys([name for name in NAMES if "D1" in name[1]], ("situation",))


def test_an_edit_of_how_a_value_comes_true_changes_baselines_alone(copy: Path) -> None:
    edited = _stale(copy, "situations.yaml", "eventually(x_m < -1)", "eventually(x_m < -2)")
    assert edited == dict.fromkeys([name for name in NAMES if name[0] == "baseline"], ("realised",))


def test_another_argument_of_a_mutant_changes_its_flights_alone() -> None:
    study = Study(ROOT)
    flight = flight_named(study, "LATE-human@3s", "T0O0W0D0H1", 0)
    assert flight.mutant is not None
    other = replace(flight, mutant=replace(flight.mutant, arguments={"delay_s": 4.0}))
    keys = Keys(study)
    assert keys.origin(flight).changed(keys.origin(other)) == ("mutant",)
    assert keys.key(flight) != keys.key(other)


def test_one_key_and_many_are_made_alike() -> None:
    study = Study(ROOT)
    keys = Keys(study)
    for flight in _flights(study).values():
        assert keys.key(flight) == Keys(study).key(flight) == keys.planned(flight).key
        assert keys.key(flight) != keys.key(replace(flight, seed=1))


def test_a_drawn_number_is_part_of_the_key(copy: Path) -> None:
    study = Study(with_range(copy))
    situations = ("T0O0W0D0H0C2", "T0O0W0D0H0C2=0.871", "T0O0W0D0H0C2=0.872")
    origins = [Keys(study).origin(flight_named(study, "baseline", key, 0)) for key in situations]
    assert study.changes(study.grid.situation(situations[1])) == {"world.mission.cruise_mps": 0.871}
    assert len({origin.situation for origin in origins}) == len({origin.realised for origin in origins}) == 3


SITUATION = "T1O0W0D1H1"
EVERY = BASE, IDENTITY, LATE, ROUTE = "baseline", "PLACEBO", "LATE-human@3s", "REVERSE-waypoint"
EDITS = {
    ("sim/world.yaml", "light: 0.9", "light: 0.8"): EVERY,
    ("sim/vehicle.yaml", "mass_kg: 1.5", "mass_kg: 1.6"): EVERY,
    ("sim/sensors.yaml", "latency_s: 0.05", "latency_s: 0.06"): EVERY,
    ("sim/stack.yaml", "gate_sigma: 8.0", "gate_sigma: 7.0"): EVERY,
    ("sim/requirements.yaml", "speed_mps / 0.25", "speed_mps / 0.30"): EVERY,
    ("sim/situations.yaml", "light: 0.0", "light: 0.01"): EVERY,
    ("sim/situations.yaml", "eventually(x_m < -1)", "eventually(x_m < -2)"): (BASE,),
    ("hazop/matrix/human.yaml", "operator: delay\n", "operator: delay\n      arguments: {keep_first: true}\n"): (LATE,),
    ("sim/stack.yaml", "name: reference", "name:  reference  # the same"): (),
    ("hazop/matrix/human.yaml", "deviation: Detection delivered late.", "deviation: Late."): (),
}
"""Edits of a study, and the subjects whose flights they can change."""
SOURCES = {
    "sim/flight": EVERY,
    "sim/sensors/camera": EVERY,
    "stack/reference/mission": EVERY,
    "judge/requirement": EVERY,
    "mutants/wire": EVERY,
    "campaign/flights/share": EVERY,
    "mutants/operators/presence": (IDENTITY,),
    "mutants/operators/timing": (LATE,),
    "mutants/reference/route": (ROUTE,),
    "mutants/sample": (IDENTITY, LATE, ROUTE),
    "analysis/score": (),
    "views/table": (),
}
"""Modules of the package, and the subjects whose flights an edit of them can change."""


def _keys(folder: Path) -> dict[str, str]:
    study = Study(folder)
    return {name: Keys(study).key(flight_named(study, name, SITUATION, 0)) for name in EVERY}


def _moved(before: Mapping[str, str], now: Mapping[str, str]) -> set[str]:
    return {name for name in EVERY if before[name] != now[name]}


@pytest.mark.parametrize("edit", EDITS)
def test_an_edit_moves_the_keys_of_all_subjects_that_it_can_change_and_of_no_other(
    copy: Path, edit: tuple[str, str, str]
) -> None:
    file, old, new = edit
    before, text = _keys(copy), (copy / file).read_text()
    assert old in text
    (copy / file).write_text(text.replace(old, new, 1))
    assert _moved(before, _keys(copy)) == {*EDITS[edit]}


@pytest.mark.parametrize("module", SOURCES)
def test_other_code_moves_the_keys_of_all_subjects_that_it_can_change_and_of_no_other(
    module: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    before, read, edited = _keys(ROOT), sources.read, PACKAGE / f"{module}.py"
    assert edited.is_file()
    monkeypatch.setattr(
        sources, "read", lambda path: replace(read(path), meaning="x") if path == edited else read(path)
    )
    assert _moved(before, _keys(ROOT)) == {*SOURCES[module]}


def test_a_file_beside_the_documents_a_seed_and_a_situation_move_every_key(copy: Path) -> None:
    before = _keys(copy)
    (copy / "sim" / "mine.obj").write_text("v 0 0 0\n")
    assert _moved(before, _keys(copy)) == {*EVERY}
    study = Study(copy)
    for name in EVERY:
        places = (SITUATION, 0), (SITUATION, 1), ("T0O0W0D0H0", 0)
        assert len({Keys(study).key(flight_named(study, name, *place)) for place in places}) == len(places)


def test_a_study_that_gains_the_operator_of_a_plugin_keeps_all_flights_but_those_of_its_mutants(
    copy: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    before, cells = _keys(copy), copy / "hazop" / "matrix" / "human.yaml"
    (tmp_path / "odd_ware.py").write_text("def linger(_context, *, delay_s):\n    return lambda _t_s, sample: sample\n")
    monkeypatch.syspath_prepend(tmp_path)
    make = import_module("odd_ware").linger
    known = dict(OPERATORS)
    gained = {**known, "linger": replace(known["delay"], name="linger", make=make)}
    monkeypatch.setattr(OPERATORS, "_entries", gained)
    cells.write_text(cells.read_text().replace("operator: delay\n", "operator: linger\n", 1))
    assert _moved(before, _keys(copy)) == {LATE}
