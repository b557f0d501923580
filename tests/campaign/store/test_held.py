"""What a campaign holds, and why it has outgrown the rest; what changes the key of a flight, and what does not."""

from __future__ import annotations

import operator
import shutil
from collections.abc import Callable, Mapping
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest
from builders import with_range
from hypothesis import given
from hypothesis import strategies as st
from processes import ROOT
from running import CONTROL, LATE, MORE, Runs, asked

from scaloft_fi import sources
from scaloft_fi.campaign.plan import plan
from scaloft_fi.campaign.store.archive import STORE_NAME
from scaloft_fi.campaign.store.held import Held, Keys, Now, current_in, flight_named, held_in, with_tracks
from scaloft_fi.campaign.store.record import Origin
from scaloft_fi.campaign.store.store import Store
from scaloft_fi.errors import InputError
from scaloft_fi.hazop.load import load_matrix
from scaloft_fi.judge.outcome import TRACK_COLUMNS, Outcome, pack_track
from scaloft_fi.mutants.catalogue import realise
from scaloft_fi.mutants.operators import OPERATORS
from scaloft_fi.stack.reference.declaration import REFERENCE
from scaloft_fi.study import PACKAGE, Study
from scaloft_fi.verbs.snapshot import Snapshot, snapshot

CODE = "the code that flies and judges"
HELD, LATEST, CURRENT = (operator.attrgetter(name) for name in ("held", "latest", "outcomes"))


@pytest.fixture
def fly(study: Any, log: Any) -> Callable[..., Held]:
    """Runs two mutants in four situations under a study, and says what the campaign then holds."""

    def flying(changed: Any = None) -> Held:
        now = changed or study
        Runs(study, log)(asked(now, names=(LATE, MORE), canary=""), of=now)
        return _read(now, HELD)

    return flying


def _inputs(study: Any, **changes: str) -> Any:
    return replace(study, inputs={**study.inputs, **changes})


def _read(study: Any, what: Callable[[Snapshot], Any]) -> Any:
    with snapshot(study, f"{study.folder}/c") as now:
        return what(now)


def _why(study: Any) -> dict[str, int]:
    return dict(_read(study, HELD).why)


def test_of_an_unchanged_study_nothing_is_stale_or_owed(study: Any, fly: Callable[..., Held]):
    found = fly()
    assert (len(_read(study, CURRENT)), found.stale, found.owed) == (16, 0, 0)


def _other_arguments(study: Any, folder: Path) -> Any:
    """The study with another argument of LATE."""
    shutil.copytree(ROOT / "hazop", folder / "hazop")
    path = folder / "hazop" / "matrix" / "human.yaml"
    old = "operator: delay\n      magnitude: {argument: delay_s, unit: s, ladder: [0.5, 1, 3, 5]"
    assert old in path.read_text()
    path.write_text(path.read_text().replace(old, old.replace("\n", "\n      arguments: {keep_first: true}\n")))
    return replace(study, matrix=load_matrix(folder / "hazop", REFERENCE.by_name))


@pytest.mark.parametrize(
    ("change", "why"),
    [
        (lambda study, _: _inputs(study, sim="x"), {"sim/ changed": 16}),
        (lambda study, _: _inputs(study, requirements="x"), {"the requirements changed": 16}),
        (lambda study, _: _inputs(study, code="x"), {f"{CODE} changed": 16}),
        (lambda study, _: _inputs(study, sim="x", code="y"), {f"sim/ and {CODE} changed": 16}),
        (lambda study, _: _inputs(study, **{"operator delay": "x"}), {"operator delay changed": 4}),
        (lambda study, _: replace(study, predicate="x"), {"how the situation's values come true changed": 4}),
        (_other_arguments, {f"mutant {LATE} changed": 4}),
        (
            lambda study, _: replace(study, grid=type(study.grid)(study.grid[1:])),
            {"the situation is not in the grid any more": 4},
        ),
    ],
)
def test_an_edit_makes_the_flights_stale_that_it_can_change_and_is_named(
    study: Any, fly: Callable[..., Held], tmp_path: Path, change: Callable[[Any, Path], Any], why: dict[str, int]
):
    fly()
    assert _why(change(study, tmp_path)) == why


def test_flights_flown_again_leave_the_stale_ones_beside_them(study: Any, fly: Callable[..., Held]):
    fly()
    now = _inputs(study, requirements="x")
    found = fly(now)
    assert (len(_read(now, CURRENT)), dict(found.why)) == (16, {"the requirements changed": 16})


def test_a_flight_of_which_no_reason_was_kept_is_said_to_have_none(study: Any, fly: Callable[..., Held]):
    fly()
    with Store(study.folder / "c" / STORE_NAME) as store:
        store._connection.execute("UPDATE outcomes SET origin = NULL")
        assert held_in(Now(study, store), study.folder / "c").stale == 0
    assert _why(_inputs(study, sim="x")) == {"flown for reasons that were not kept": 16}


def test_what_is_owed_is_planned_as_the_study_is_now(study: Any, fly: Callable[..., Held]):
    fly()
    with Store(study.folder / "c" / STORE_NAME) as store:
        store._connection.execute("DELETE FROM outcomes WHERE mutant = ?", (LATE,))
    assert _read(study, HELD).owed == 4
    assert _read(_inputs(study, sim="x"), HELD).owed == 0


def test_the_latest_are_the_current_ones_else_the_stale(study: Any, fly: Callable[..., Held], log: Any):
    fly()
    before = _read(study, CURRENT)
    assert _read(_inputs(study, sim="x"), LATEST) == before
    log.change = lambda _flight, outcome: replace(outcome, perceived_digest="now")
    now = _inputs(study, sim="x")
    fly(now)
    after = _read(now, CURRENT)
    assert after != before
    assert _read(now, LATEST) == after == _read(now, CURRENT)
    assert _read(study, LATEST) == before == _read(study, CURRENT)


def test_a_campaign_without_a_flight_that_counts_is_one_sentence(study: Any, fly: Callable[..., Held]):
    fly()
    with pytest.raises(
        InputError, match=r"nothing to show: all 16 flights are stale \(`scaloft-fi status --campaign \S+/c`\)"
    ):
        _read(_inputs(study, sim="x"), CURRENT)
    with Store(study.folder / "c" / STORE_NAME) as store:
        store._connection.execute("DELETE FROM outcomes")
    with pytest.raises(InputError, match="the campaign has no flight"):
        _read(study, CURRENT)


def test_what_a_run_writes_meanwhile_is_read_the_next_time(
    study: Any, fly: Callable[..., Held], log: Any, monkeypatch: pytest.MonkeyPatch
):
    fly()
    there = len(_read(study, CURRENT))
    path, read, keys = study.folder / "c" / STORE_NAME, Store.origins, Keys(study)
    planned = [plan(study.grid, (seed,), [realise(study.matrix, CONTROL)], None) for seed in range(1, 5)]
    meanwhile: list[Any] = []
    added = len(planned[0].baselines) + len(planned[0].mutants)

    def origins(store: Store) -> Any:
        """Those there are; then another process plans and flies."""
        found = read(store)
        if meanwhile:
            more = meanwhile.pop()
            flights = (*more.baselines, *more.mutants)
            with Store(path) as other:
                other.plan(map(keys.planned, flights))
                other.put_all((keys.key(flight), log(study, flight)) for flight in flights)
        return found

    def opened() -> int:
        with Store(path) as store:
            return len(current_in(study, store))

    def told() -> int:
        found, flights = _read(study, lambda now: (now.held, len(now.outcomes)))
        assert (found.stale, found.owed) == (0, 0)
        return flights

    # the first of these meets origins that were not there when it began
    monkeypatch.setattr(Store, "origins", origins)
    for reader in (told, opened, lambda: len(_read(study, CURRENT)), lambda: len(_read(study, LATEST))):
        meanwhile.append(planned.pop())
        assert reader() == there
        there += added
    assert len(_read(study, CURRENT)) == there


HERE = "T0O0W0D0H1"
FLOWN = (("baseline", 0), ("baseline", 1), ("LATE-human@3s", 0), ("NO-human@100%", 0))


def test_only_the_trajectories_asked_for_are_read(tmp_path: Path):
    study, keys = Study.open(ROOT), Keys(Study.open(ROOT))
    track = pack_track({name: [1.0, 2.0] for name in TRACK_COLUMNS})
    with Store(tmp_path / STORE_NAME) as store:
        for mutant, seed in FLOWN:
            planned = keys.planned(flight := flight_named(study, mutant, HERE, seed))
            store.plan([planned])
            store.put(planned.key, Outcome(flight.subject, HERE, seed, ending="landed", track=track))
        known = current_in(study, store)
        found = with_tracks(study, store, known, lambda one: one.mutant in ("baseline", "LATE-human@3s"))
        first = with_tracks(study, store, known, lambda one: (one.mutant, one.seed) == ("baseline", 1))
    assert not any(outcome.track for outcome in known)
    assert {o.name for o in found if o.track} == {f"baseline/{HERE}/0", f"baseline/{HERE}/1", f"LATE-human@3s/{HERE}/0"}
    assert {outcome.name for outcome in first if outcome.track} == {f"baseline/{HERE}/1"}
    assert [outcome.name for outcome in first] == [outcome.name for outcome in known]


EVERY = BASE, IDENTITY, _, ROUTE = "baseline", "PLACEBO", LATE, "REVERSE-waypoint"
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
    "campaign/flights/fly": EVERY,
    "mutants/operators/arrival": (IDENTITY, LATE),
    "mutants/operators/sensors": (),
    "mutants/reference/mission": (ROUTE,),
    "mutants/sample": (IDENTITY, LATE, ROUTE),
    "analysis/score": (),
    "views/table": (),
}
"""Modules of the package, and the subjects whose flights an edit of them can change."""


def _origins(folder: Path) -> dict[tuple[str, str], Origin]:
    study = Study(folder)
    return {(name, at): Keys(study).origin(flight_named(study, name, at, 0)) for name in EVERY for at in BOTH}


def _moved(before: Mapping[tuple[str, str], Origin], now: Mapping[tuple[str, str], Origin]) -> set[str]:
    return {name for name, at in before if before[name, at] != now[name, at]}


@pytest.mark.parametrize("edit", EDITS)
def test_an_edit_changes_the_part_of_all_flights_that_it_can_change_and_of_no_other(
    copy: Path, edit: tuple[str, str, str]
):
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
):
    before, read, edited = _origins(ROOT), sources.read, PACKAGE / f"{module}.py"
    assert edited.is_file()
    monkeypatch.setattr(
        sources, "read", lambda path: replace(read(path), meaning="x") if path == edited else read(path)
    )
    assert _moved(before, _origins(ROOT)) == {*SOURCES[module]}


def test_a_file_beside_the_documents_a_seed_and_a_situation_move_every_key(copy: Path):
    before = _origins(copy)
    (copy / "sim" / "mine.obj").write_text("v 0 0 0\n")
    assert _moved(before, _origins(copy)) == {*EVERY}
    study = Study(copy)
    for name in EVERY:
        places = (DARK, 0), (DARK, 1), (LIGHT, 0)
        assert len({Keys(study).key(flight_named(study, name, *place)) for place in places}) == len(places)


def test_a_study_that_gains_the_operator_of_a_plugin_keeps_all_flights_but_those_of_its_mutants(
    copy: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    before, cells = _origins(copy), copy / "hazop" / "matrix" / "human.yaml"
    (tmp_path / "odd_ware.py").write_text("def linger(_context, *, delay_s):\n    return lambda _t_s, sample: sample\n")
    monkeypatch.syspath_prepend(tmp_path)
    make = import_module("odd_ware").linger
    known = dict(OPERATORS)
    gained = {**known, "linger": replace(known["delay"], name="linger", make=make)}
    monkeypatch.setattr(OPERATORS, "_entries", gained)
    cells.write_text(cells.read_text().replace("operator: delay\n", "operator: linger\n", 1))
    assert _moved(before, _origins(copy)) == {LATE}


def test_a_drawn_number_is_part_of_the_key(copy: Path):
    study = Study(with_range(copy))
    situations = ("T0O0W0D0H0C2", "T0O0W0D0H0C2=0.871", "T0O0W0D0H0C2=0.872")
    origins = [Keys(study).origin(flight_named(study, "baseline", key, 0)) for key in situations]
    assert study.changes(study.grid.situation(situations[1])) == {"world.mission.cruise_mps": 0.871}
    assert len({origin.situation for origin in origins}) == len({origin.realised for origin in origins}) == 3


hashes = st.text("0123456789abcdef", max_size=4)
origins = st.builds(Origin, hashes, hashes, hashes, hashes, hashes, hashes, hashes)


@given(origins, origins, st.integers(0, 2), st.integers(0, 2))
def test_two_keys_are_equal_when_all_that_enters_them_is(one: Origin, other: Origin, seed: int, later: int):
    assert one.key(seed) == Origin(*one).key(seed)
    assert (one.key(seed) == other.key(later)) == ((one, seed) == (other, later))


@given(origins, origins)
def test_the_parts_that_changed_are_those_that_differ(one: Origin, other: Origin):
    changed = one.changed(other)
    assert one._replace(**{name: getattr(other, name) for name in changed}) == other
    assert (changed == ()) == (one == other)
