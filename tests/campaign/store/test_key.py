"""What changes the key of a flight, and what does not."""

from __future__ import annotations

import shutil
from collections.abc import Mapping
from dataclasses import replace
from importlib import import_module
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from ranges import with_range

from scaloft_fi import sources
from scaloft_fi.campaign.store.held import Keys, flight_named
from scaloft_fi.campaign.store.origin import Origin
from scaloft_fi.mutants.operators import OPERATORS
from scaloft_fi.study import PACKAGE, Study

ROOT = Path(__file__).parents[3]
EVERY = BASE, IDENTITY, LATE, ROUTE = "baseline", "PLACEBO", "LATE-human@3s", "REVERSE-waypoint"
BOTH = DARK, LIGHT = "T1O0W0D1H1", "T0O0W0D0H0"
ARGUMENT = "operator: delay\n      arguments: {keep_first: true}\n"
EDITS = {
    ("sim/world.yaml", "light: 0.9", "light: 0.8"): ("sim", EVERY, BOTH),
    ("sim/vehicle.yaml", "mass_kg: 1.5", "mass_kg: 1.6"): ("sim", EVERY, BOTH),
    ("sim/sensors.yaml", "latency_s: 0.05", "latency_s: 0.06"): ("sim", EVERY, BOTH),
    ("sim/stack.yaml", "gate_sigma: 8.0", "gate_sigma: 7.0"): ("sim", EVERY, BOTH),
    ("sim/requirements.yaml", "speed_mps / 0.25", "speed_mps / 0.30"): ("requirements", EVERY, BOTH),
    ("sim/situations.yaml", "light: 0.0", "light: 0.01"): ("situation", EVERY, (DARK,)),
    ("sim/situations.yaml", "eventually(x_m < -1)", "eventually(x_m < -2)"): ("realised", (BASE,), BOTH),
    ("hazop/matrix/human.yaml", "operator: delay\n", ARGUMENT): ("mutant", (LATE,), BOTH),
    ("sim/stack.yaml", "name: reference", "name:  reference  # the same"): ("", (), ()),
    ("hazop/matrix/human.yaml", "deviation: Detection delivered late.", "deviation: Late."): ("", (), ()),
}
"""Edits of a study, with what they change: a part of the origins of subjects in situations."""
SOURCES = {
    "sim/flight": EVERY,
    "sim/sensors/camera": EVERY,
    "stack/reference/mission": EVERY,
    "judge/requirement": EVERY,
    "mutants/wire": EVERY,
    "campaign/flights/share": EVERY,
    "mutants/operators/arrival": (IDENTITY, LATE),
    "mutants/operators/sensors": (),
    "mutants/reference/mission": (ROUTE,),
    "mutants/sample": (IDENTITY, LATE, ROUTE),
    "analysis/score": (),
    "views/table": (),
}
"""Modules of the package, and the subjects whose flights an edit of them can change."""


@pytest.fixture
def copy(tmp_path: Path) -> Path:
    for name in ("hazop", "mutants", "sim"):
        shutil.copytree(ROOT / name, tmp_path / name)
    return tmp_path


def _origins(folder: Path) -> dict[tuple[str, str], Origin]:
    study = Study(folder)
    return {(name, at): Keys(study).origin(flight_named(study, name, at, 0)) for name in EVERY for at in BOTH}


def _moved(before: Mapping[tuple[str, str], Origin], now: Mapping[tuple[str, str], Origin]) -> set[str]:
    return {name for name, at in before if before[name, at] != now[name, at]}


@pytest.mark.parametrize("edit", EDITS)
def test_an_edit_changes_the_part_of_all_flights_that_it_can_change_and_of_no_other(
    copy: Path, edit: tuple[str, str, str]
) -> None:
    file, old, new = edit
    before, text = _origins(copy), (copy / file).read_text()
    assert old in text
    (copy / file).write_text(text.replace(old, new, 1))
    now = _origins(copy)
    part, subjects, situations = EDITS[edit]
    changed = {place: before[place].changed(now[place]) for place in before if before[place] != now[place]}
    assert changed == {(name, at): (part,) for name in subjects for at in situations}


@pytest.mark.parametrize("module", SOURCES)
def test_other_code_moves_the_keys_of_all_subjects_that_it_can_change_and_of_no_other(
    module: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    before, read, edited = _origins(ROOT), sources.read, PACKAGE / f"{module}.py"
    assert edited.is_file()
    monkeypatch.setattr(
        sources, "read", lambda path: replace(read(path), meaning="x") if path == edited else read(path)
    )
    assert _moved(before, _origins(ROOT)) == {*SOURCES[module]}


def test_a_file_beside_the_documents_a_seed_and_a_situation_move_every_key(copy: Path) -> None:
    before = _origins(copy)
    (copy / "sim" / "mine.obj").write_text("v 0 0 0\n")
    assert _moved(before, _origins(copy)) == {*EVERY}
    study = Study(copy)
    for name in EVERY:
        places = (DARK, 0), (DARK, 1), (LIGHT, 0)
        assert len({Keys(study).key(flight_named(study, name, *place)) for place in places}) == len(places)


def test_a_study_that_gains_the_operator_of_a_plugin_keeps_all_flights_but_those_of_its_mutants(
    copy: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    before, cells = _origins(copy), copy / "hazop" / "matrix" / "human.yaml"
    (tmp_path / "odd_ware.py").write_text("def linger(_context, *, delay_s):\n    return lambda _t_s, sample: sample\n")
    monkeypatch.syspath_prepend(tmp_path)
    make = import_module("odd_ware").linger
    known = dict(OPERATORS)
    gained = {**known, "linger": replace(known["delay"], name="linger", make=make)}
    monkeypatch.setattr(OPERATORS, "_entries", gained)
    cells.write_text(cells.read_text().replace("operator: delay\n", "operator: linger\n", 1))
    assert _moved(before, _origins(copy)) == {LATE}


def test_a_drawn_number_is_part_of_the_key(copy: Path) -> None:
    study = Study(with_range(copy))
    situations = ("T0O0W0D0H0C2", "T0O0W0D0H0C2=0.871", "T0O0W0D0H0C2=0.872")
    origins = [Keys(study).origin(flight_named(study, "baseline", key, 0)) for key in situations]
    assert study.changes(study.grid.situation(situations[1])) == {"world.mission.cruise_mps": 0.871}
    assert len({origin.situation for origin in origins}) == len({origin.realised for origin in origins}) == 3


hashes = st.text("0123456789abcdef", max_size=4)
origins = st.builds(Origin, hashes, hashes, hashes, hashes, hashes, hashes, hashes)


@given(origins, origins, st.integers(0, 2), st.integers(0, 2))
def test_two_keys_are_equal_when_all_that_enters_them_is(one: Origin, other: Origin, seed: int, later: int) -> None:
    assert one.key(seed) == Origin(*one).key(seed)
    assert (one.key(seed) == other.key(later)) == ((one, seed) == (other, later))


@given(origins, origins)
def test_the_parts_that_changed_are_those_that_differ(one: Origin, other: Origin) -> None:
    changed = one.changed(other)
    assert one._replace(**{name: getattr(other, name) for name in changed}) == other
    assert (changed == ()) == (one == other)
