"""What a campaign holds, and why it has outgrown the rest."""

from __future__ import annotations

import io
import operator
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from scaloft_fi.campaign.plan import plan
from scaloft_fi.campaign.progress import Silence
from scaloft_fi.campaign.runs.gates import RunOptions
from scaloft_fi.campaign.runs.run import run
from scaloft_fi.campaign.store.archive import STORE_NAME
from scaloft_fi.campaign.store.held import Held, Keys, current_in, flight_named, held_in, with_tracks
from scaloft_fi.campaign.store.store import Store
from scaloft_fi.errors import InputError
from scaloft_fi.hazop.load import load_matrix
from scaloft_fi.judge.outcome import TRACK_COLUMNS, Outcome, pack_track
from scaloft_fi.mutants.catalogue import realise
from scaloft_fi.stack.reference.declaration import REFERENCE
from scaloft_fi.study import Study
from scaloft_fi.verbs.snapshot import Snapshot, snapshot

CONTROL, LATE, MORE = "REVERSE-velcmd", "LATE-human@3s", "MORE-goal@1m"
HAZOP = Path(__file__).parents[3] / "hazop"
CODE = "the code that flies and judges"
HELD, LATEST, CURRENT = (operator.attrgetter(name) for name in ("held", "latest", "outcomes"))


@pytest.fixture
def fly(study: Any, log: Any) -> Callable[..., Held]:
    """Runs two mutants in four situations under a study, and says what the campaign then holds."""

    def flying(changed: Any = None) -> Held:
        now = changed or study
        planned = plan(now.grid, (0,), [realise(now.matrix, name) for name in (LATE, MORE)], None)
        run(
            now,
            planned,
            now.folder / "c",
            options=RunOptions(jobs=1),
            progress=Silence(stream=io.StringIO()),
            flyer=log,
        )
        return _read(now, HELD)

    return flying


def _inputs(study: Any, **changes: str) -> Any:
    return replace(study, inputs={**study.inputs, **changes})


def _read(study: Any, what: Callable[[Snapshot], Any]) -> Any:
    with snapshot(study, f"{study.folder}/c") as now:
        return what(now)


def _why(study: Any) -> dict[str, int]:
    return dict(_read(study, HELD).why)


def test_of_an_unchanged_study_nothing_is_stale_or_owed(fly: Callable[..., Held]) -> None:
    found = fly()
    assert (len(found.current), found.stale, found.owed) == (16, 0, 0)


@pytest.mark.parametrize(
    ("changes", "why"),
    [
        ({"sim": "x"}, "sim/ changed"),
        ({"requirements": "x"}, "the requirements changed"),
        ({"code": "x"}, f"{CODE} changed"),
        ({"sim": "x", "code": "y"}, f"sim/ and {CODE} changed"),
    ],
)
def test_what_every_flight_shares_makes_all_stale(
    study: Any, fly: Callable[..., Held], changes: dict[str, str], why: str
) -> None:
    fly()
    assert _why(_inputs(study, **changes)) == {why: 16}


def test_another_operator_makes_its_mutants_stale_and_nothing_else(study: Any, fly: Callable[..., Held]) -> None:
    fly()
    assert _why(_inputs(study, **{"operator delay": "x"})) == {"operator delay changed": 4}


def test_how_situations_come_true_makes_baselines_stale(study: Any, fly: Callable[..., Held]) -> None:
    fly()
    assert _why(replace(study, predicate="x")) == {"how the situation's values come true changed": 4}


def test_a_mutant_that_changed_is_named(study: Any, fly: Callable[..., Held], tmp_path: Path) -> None:
    fly()
    shutil.copytree(HAZOP, tmp_path / "hazop")
    path = tmp_path / "hazop" / "matrix" / "human.yaml"
    old = "operator: delay\n      magnitude: {argument: delay_s, unit: s, ladder: [0.5, 1, 3, 5]"
    assert old in path.read_text()
    path.write_text(path.read_text().replace(old, old.replace("\n", "\n      arguments: {keep_first: true}\n")))
    changed = replace(study, matrix=load_matrix(tmp_path / "hazop", REFERENCE.by_name))
    assert _why(changed) == {f"mutant {LATE} changed": 4}


def test_a_situation_that_is_gone_is_said(study: Any, fly: Callable[..., Held]) -> None:
    fly()
    changed = replace(study, grid=type(study.grid)(study.grid[1:]))
    assert _why(changed) == {"the situation is not in the grid any more": 4}


def test_flights_flown_again_leave_the_stale_ones_beside_them(study: Any, fly: Callable[..., Held]) -> None:
    fly()
    found = fly(_inputs(study, requirements="x"))
    assert (len(found.current), dict(found.why)) == (16, {"the requirements changed": 16})


def test_a_flight_of_which_no_reason_was_kept_is_said_to_have_none(study: Any, fly: Callable[..., Held]) -> None:
    fly()
    with Store(study.folder / "c" / STORE_NAME) as store:
        store._connection.execute("UPDATE outcomes SET origin = NULL")
        assert held_in(study, store, study.folder / "c").stale == 0
    assert _why(_inputs(study, sim="x")) == {"flown for reasons that were not kept": 16}


def test_what_is_owed_is_planned_as_the_study_is_now(study: Any, fly: Callable[..., Held]) -> None:
    fly()
    with Store(study.folder / "c" / STORE_NAME) as store:
        store._connection.execute("DELETE FROM outcomes WHERE mutant = ?", (LATE,))
    assert _read(study, HELD).owed == 4
    assert _read(_inputs(study, sim="x"), HELD).owed == 0


def test_the_latest_are_the_current_ones_else_the_stale(study: Any, fly: Callable[..., Held], log: Any) -> None:
    before = fly().current
    assert _read(_inputs(study, sim="x"), LATEST) == before
    log.change = lambda _flight, outcome: replace(outcome, perceived_digest="now")
    now = _inputs(study, sim="x")
    after = fly(now).current
    assert after != before
    assert _read(now, LATEST) == after == _read(now, CURRENT)
    assert _read(study, LATEST) == before == _read(study, CURRENT)


def test_a_campaign_without_a_flight_that_counts_is_one_sentence(study: Any, fly: Callable[..., Held]) -> None:
    fly()
    with pytest.raises(InputError, match=r"nothing to show: all 16 flights are stale \(`scaloft-fi status`\)"):
        _read(_inputs(study, sim="x"), CURRENT)
    with Store(study.folder / "c" / STORE_NAME) as store:
        store._connection.execute("DELETE FROM outcomes")
    with pytest.raises(InputError, match="the campaign has no flight"):
        _read(study, CURRENT)


def test_what_a_run_writes_meanwhile_is_read_the_next_time(
    study: Any, fly: Callable[..., Held], log: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    there = len(fly().current)
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
        found = _read(study, HELD)
        assert (found.stale, found.owed) == (0, 0)
        return len(found.current)

    # the first of these meets origins that were not there when it began
    monkeypatch.setattr(Store, "origins", origins)
    for reader in (told, opened, lambda: len(_read(study, CURRENT)), lambda: len(_read(study, LATEST))):
        meanwhile.append(planned.pop())
        assert reader() == there
        there += added
    assert len(_read(study, CURRENT)) == there


STUDY = Path(__file__).parents[3]
HERE = "T0O0W0D0H1"
FLOWN = (("baseline", 0), ("baseline", 1), ("LATE-human@3s", 0), ("NO-human@100%", 0))


def test_only_the_trajectories_asked_for_are_read(tmp_path: Path) -> None:
    study, keys = Study.open(STUDY), Keys(Study.open(STUDY))
    track = pack_track({name: [1.0, 2.0] for name in TRACK_COLUMNS})
    with Store(tmp_path / STORE_NAME) as store:
        for mutant, seed in FLOWN:
            planned = keys.planned(flight := flight_named(study, mutant, HERE, seed))
            store.plan([planned])
            store.put(planned.key, Outcome(flight.subject, HERE, seed, ending="landed", track=track))
        known = current_in(study, store)
        found = with_tracks(study, store, known, ["baseline", "LATE-human@3s"])
        first = with_tracks(study, store, known, ["baseline"], [1])
    assert not any(outcome.track for outcome in known)
    assert {o.name for o in found if o.track} == {f"baseline/{HERE}/0", f"baseline/{HERE}/1", f"LATE-human@3s/{HERE}/0"}
    assert {outcome.name for outcome in first if outcome.track} == {f"baseline/{HERE}/1"}
    assert [outcome.name for outcome in first] == [outcome.name for outcome in known]
