"""The store: rows, selections, what survives a kill, and what is said of a file that is lost."""

from __future__ import annotations

import math
import multiprocessing
import os
import shutil
import signal
import sqlite3
import subprocess
import sys
import tempfile
import textwrap
import threading
from collections.abc import Callable, Iterator
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from builders import campaigns, outcome, seeded
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from options import cases, usually

from scaloft_fi.campaign.store import store
from scaloft_fi.campaign.store.record import COLUMNS, Origin, Planned, Reader, Record, to_row
from scaloft_fi.campaign.store.store import SCHEMA, FlownFlight, Store, told_when_slow
from scaloft_fi.errors import InputError
from scaloft_fi.judge.outcome import BASELINE, Outcome
from scaloft_fi.judge.requirement import Kind
from scaloft_fi.judge.status import rulings_beside, rulings_of

M = "LATE-human@3s"


@pytest.fixture
def open_store(tmp_path: Path) -> Iterator[Store]:
    with Store(tmp_path / "s.sqlite") as store:
        yield store


def test_what_was_put_is_there_after_reopening(tmp_path: Path):
    kept = replace(outcome(M), track=b"\x00\x01")
    with Store(tmp_path / "deep" / "campaign.sqlite") as store:
        assert store.put("k", kept)
    with Store(tmp_path / "deep" / "campaign.sqlite", create=False) as store:
        assert store.get("k") == kept
        assert store.get("other") is None
        assert store.known(["k", "other"]) == {"k"}


def test_putting_again_changes_nothing(open_store: Store):
    assert open_store.put("k", outcome(M))
    assert not open_store.put("k", outcome(M))
    assert not open_store.put("k", outcome(M, violated={"SR1": 3.0}))
    assert list(open_store.outcomes()) == [outcome(M)]


def test_an_invalid_flight_gives_way_to_one_that_counts(open_store: Store):
    open_store.put("k", outcome(M, invalid="the worker died"))
    assert open_store.known(["k"]) == set()
    assert open_store.put("k", outcome(M))
    assert not open_store.put("k", outcome(M, invalid="the worker died"))
    assert list(open_store.outcomes()) == [outcome(M)]


def test_outcomes_come_without_tracks_in_one_order(open_store: Store):
    for seed in (2, 0, 1):
        open_store.put(f"k{seed}", replace(outcome(M, seed=seed), track=b"x"))
    assert list(open_store.outcomes()) == [outcome(M, seed=seed) for seed in range(3)]
    assert list(open_store.outcomes(["k1"])) == [outcome(M, seed=1)]


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None, max_examples=10)
@given(campaigns())
def test_a_campaign_survives_the_store(tmp_path: Path, outcomes: list[Outcome]):
    path = tmp_path / "s.sqlite"
    path.unlink(missing_ok=True)
    with Store(path) as store:
        for _ in range(2):
            for flown in outcomes:
                store.put(flown.name, flown)
        assert sorted(store.outcomes(), key=lambda o: o.name) == sorted(outcomes, key=lambda o: o.name)


def test_the_first_fact_about_a_campaign_stays(open_store: Store):
    open_store.set_meta({"numpy": "1", "system": "Linux"})
    open_store.set_meta({"numpy": "2"})
    assert open_store.meta() == {"numpy": "1", "system": "Linux"}


def test_two_processes_may_write_one_store(tmp_path: Path):
    with Store(tmp_path / "s.sqlite") as one, Store(tmp_path / "s.sqlite") as two:
        assert one.put("a", outcome(M, seed=0))
        assert two.put("b", outcome(M, seed=1))
        assert one.known("ab") == two.known("ab") == {"a", "b"}


def test_a_moment_within_another_is_part_of_it(tmp_path: Path):
    with Store(tmp_path / "s.sqlite") as store, Store(tmp_path / "s.sqlite") as writer:
        store.put("k", outcome(M))
        with store.snapshot():
            with store.snapshot():
                assert len(store.flights()) == 1
            writer.put("later", outcome(M, seed=1))
            assert len(store.flights()) == 1
        assert len(store.flights()) == 2


def test_a_writer_killed_in_the_middle_loses_nothing_that_was_put(tmp_path: Path):
    path = tmp_path / "s.sqlite"
    script = f"""
        import sys
        sys.path.insert(0, {str(Path(__file__).parents[2] / "support")!r})
        from pathlib import Path
        from builders import outcome
        from scaloft_fi.campaign.store.store import Store
        store = Store(Path({str(path)!r}))
        for seed in range(100000):
            store.put(str(seed), outcome({M!r}, seed=seed))
            print(seed, flush=True)
    """
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(Path(__file__).resolve().parents[3]), *sys.path])}
    with subprocess.Popen(
        [sys.executable, "-c", textwrap.dedent(script)], stdout=subprocess.PIPE, text=True, env=environment
    ) as writer:
        done = [int(writer.stdout.readline()) for _ in range(20)]
        writer.send_signal(signal.SIGKILL)
        done += [int(line) for line in writer.stdout if line.endswith("\n")]
    with Store(path) as store:
        kept = {flown.seed for flown in store.outcomes()}
        assert kept >= set(done)
        assert store.put("after", outcome(M, seed=-1))


def test_a_full_disk_is_one_sentence_and_loses_nothing_that_was_put(tmp_path: Path):
    path = tmp_path / "s.sqlite"
    flown = [replace(outcome(M, seed=seed), track=os.urandom(20_000)) for seed in range(50)]
    kept: list[Outcome] = []
    with Store(path) as store:
        (pages,) = store._connection.execute("PRAGMA page_count").fetchone()
        store._connection.execute(f"PRAGMA max_page_count = {pages + 20}")

        def put_all_one_by_one() -> None:
            for one in flown:
                store.put(str(one.seed), one)
                kept.append(one)

        with pytest.raises(InputError, match=r"s\.sqlite: .* disk is full"):
            put_all_one_by_one()
        with pytest.raises(InputError, match="disk is full"):  # and all of many or none
            store.put_all((str(one.seed), one) for one in flown)
        assert [store.get(str(one.seed)) for one in kept] == kept
    assert 0 < len(kept) < 50
    with Store(path) as store:
        assert store.known(str(one.seed) for one in flown) == {str(one.seed) for one in kept}
        assert sum(store.put(str(one.seed), one) for one in flown) == 50 - len(kept)
        assert [store.get(str(one.seed)) for one in flown] == flown


def test_a_track_that_many_flights_have_is_kept_once(open_store: Store):
    for seed, track in enumerate((b"same", b"same", b"other", b"")):
        open_store.put(str(seed), replace(outcome(M, seed=seed), track=track))
    assert [flown.track for _, flown in open_store.rows()] == [b"same", b"same", b"other", b""]
    assert open_store._connection.execute("SELECT count(*) FROM tracks").fetchone() == (2,)


def test_there_is_no_campaign_where_none_was_made(tmp_path: Path):
    with pytest.raises(InputError, match="there is no campaign here"):
        Store(tmp_path / "s.sqlite", create=False)
    assert list(tmp_path.iterdir()) == []


def test_a_results_folder_that_cannot_be_made_is_one_sentence_and_nothing_is_written(tmp_path: Path):
    (tmp_path / "results").write_text("a file where the folder should be")
    with pytest.raises(InputError, match="the results folder cannot be written"):
        Store(tmp_path / "results" / "campaigns" / "s.sqlite")
    assert [path.name for path in tmp_path.iterdir()] == ["results"]


def test_a_file_that_is_no_store_is_left_alone(tmp_path: Path):
    path = tmp_path / "s.sqlite"
    path.write_text("these are notes of mine, not a database; " * 50)
    with pytest.raises(InputError, match="cannot be used"):
        Store(path)
    assert path.read_text().startswith("these are notes")


def test_what_was_planned_is_there_with_what_entered_its_key(tmp_path: Path):
    origin = Origin("s", "r", "c", "m", "t")
    plan = [Planned(origin.key(seed), M, "T0O0W0D0H0", seed, canary=seed > 1, origin=origin) for seed in range(3)]
    with Store(tmp_path / "s.sqlite") as store:
        store.plan(plan)
        store.plan(plan)
        assert store.planned() == sorted(plan)
        assert store._connection.execute("SELECT count(*) FROM origins").fetchone() == (1,)


def test_a_planned_flight_is_unflown_until_an_outcome_counts(open_store: Store):
    plan = [Planned(key, M, "T0O0W0D0H0", seed) for seed, key in enumerate("abc")]
    open_store.plan(plan)
    open_store.put("a", outcome(M))
    open_store.put("b", outcome(M, seed=1, invalid="the worker died"))
    assert open_store.planned(unflown=True) == plan[1:]


def test_a_canary_that_is_asked_for_later_is_none_any_more(open_store: Store):
    for canary in (True, False, True):
        open_store.plan([Planned("k", M, "T0O0W0D0H0", 0, canary)])
    assert open_store.planned() == [Planned("k", M, "T0O0W0D0H0", 0)]


@pytest.mark.parametrize("schema", [SCHEMA - 1, SCHEMA + 1])
def test_a_store_of_another_version_is_refused_and_left_alone(tmp_path: Path, schema: int):
    path = tmp_path / "s.sqlite"
    with Store(path) as store:
        store._connection.execute(f"PRAGMA user_version={schema}")
    content = path.read_bytes()
    for create in (True, False):
        with pytest.raises(InputError, match=rf"another version of scaloft-fi wrote this store \(schema {schema}, not"):
            Store(path, create=create)
    assert path.read_bytes() == content


def _forbid_writing(monkeypatch: pytest.MonkeyPatch) -> None:
    """No folder can be written, as on a medium that is read only; permissions would not stop the superuser."""
    monkeypatch.setattr("os.access", lambda _path, _mode: False)


def test_a_campaign_that_can_only_be_read_is_read_and_left_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    path = tmp_path / "100% ours?" / "s.sqlite"
    with Store(path) as store:
        store.put("k", outcome(M))
    _forbid_writing(monkeypatch)
    content = path.read_bytes()
    with Store(path, create=False) as store:
        assert list(store.outcomes()) == [outcome(M)]
        assert store.known(["k"]) == {"k"}
        with pytest.raises(InputError, match="readonly"):
            store.put("other", outcome(M, seed=1))
        assert [file.name for file in path.parent.iterdir()] == ["s.sqlite"]
    assert path.read_bytes() == content


def test_what_a_writer_has_not_folded_into_the_file_is_read_all_the_same(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    path = tmp_path / "s.sqlite"
    with Store(path) as writer:
        writer.put("k", outcome(M))
        _forbid_writing(monkeypatch)
        with Store(path, create=False) as store:
            assert list(store.outcomes()) == [outcome(M)]


def _open(path: Path, barrier: Any, said: Any) -> None:
    barrier.wait()
    try:
        Store(path).close()
        said.put("")
    except Exception as error:  # noqa: BLE001 - told by the test
        said.put(str(error))


@pytest.mark.release
def test_processes_that_begin_one_store_at_once_wait_for_each_other(tmp_path: Path):
    context = multiprocessing.get_context("fork")
    for number in range(20):
        barrier, said = context.Barrier(6), context.Queue()
        words = (tmp_path / str(number) / "outcomes.sqlite", barrier, said)
        processes = [context.Process(target=_open, args=words) for _ in range(6)]
        for process in processes:
            process.start()
        assert [said.get() for _ in processes] == [""] * 6
        for process in processes:
            process.join()


def test_a_plan_above_the_limit_is_refused_before_anything_is_flown(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("SCALOFT_MOST_FLIGHTS", "2")
    with Store(tmp_path / "s.sqlite") as store:
        store.plan([Planned(key, M, "T0O0W0D0H0", 0) for key in "ab"])
        with pytest.raises(InputError, match=r"more rows than the limit for 2 flights; .* SCALOFT_MOST"):
            store.plan([Planned("c", M, "T0O0W0D0H0", 0)])
        assert [flight.key for flight in store.planned()] == ["a", "b"]


def _stored(row: Record) -> Record:
    """What SQLite makes of a row."""
    with closing(sqlite3.connect(":memory:")) as connection:
        connection.execute(f"CREATE TABLE t ({', '.join(f'{name} {cell.sql}' for name, cell in COLUMNS.items())})")
        connection.execute(f"INSERT INTO t VALUES ({', '.join('?' * len(row))})", row)
        return connection.execute("SELECT * FROM t").fetchone()


@given(campaigns(), st.binary(max_size=40))
def test_outcomes_survive_their_rows(flown: list[Outcome], track: bytes):
    read = Reader()
    for kept in flown:
        kept = replace(kept, track=track, stack_error="it's \u26a0")
        (again,) = read([_stored(to_row(kept))], [track])
        assert again == kept
        assert hash(again) == hash(kept)
        assert all(isinstance(reading.kind, Kind) for reading in again.readings)


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_numbers_survive_to_the_bit(number: float):
    kept = outcome("LATE-human@3s", violated={"SR1": number})
    kept = replace(kept, duration_s=number, infected_at_s=number)
    assert Reader()([_stored(to_row(kept))]) == [kept]


@given(campaigns())
def test_many_rows_are_read_as_each_of_them(flown: list[Outcome]):
    rows = [to_row(kept) for kept in flown]
    assert Reader()(rows) == [outcome for row in rows for outcome in Reader()([row])] == flown


def test_a_number_that_is_none_is_refused():
    with pytest.raises(ValueError, match="not JSON compliant"):
        to_row(outcome(violated={"SR1": math.nan}))


def test_what_two_flights_have_in_common_is_kept_once():
    read = Reader()
    one, other = read([to_row(outcome("LATE-human@3s", seed=seed, violated={"SR2": 3.0})) for seed in (0, 1)])
    assert one.subject is other.subject
    assert all(r is s for r, s in zip(one.readings + one.violations, other.readings + other.violations, strict=True))


HERE = "T0O0W0D0H0"


@settings(deadline=None, max_examples=usually(25, release=60))
@given(st.one_of(campaigns(), seeded()), st.data())
def test_the_flights_that_stand_are_read_and_no_others(flown: list[Outcome], data: st.DataObject):
    stale = {str(number) for number in data.draw(st.sets(st.integers(0, len(flown))))}
    rows = [(str(number), one) for number, one in enumerate(flown)]
    with tempfile.TemporaryDirectory() as folder, Store(Path(folder) / "s.sqlite") as store:
        store.put_all(rows)
        standing = store.standing(lambda flight: flight.key not in stale)
    assert {one.name for one in standing} == {one.name for key, one in rows if key not in stale}


@settings(deadline=None, max_examples=usually(25, release=60))
@given(st.one_of(campaigns(), seeded()))
def test_what_is_read_for_rulings_has_all_that_rules_a_flight(flown: list[Outcome]):
    with tempfile.TemporaryDirectory() as folder, Store(Path(folder) / "s.sqlite") as store:
        store.put_all((str(number), one) for number, one in enumerate(flown))
        whole = store.standing(lambda _: True)
        baselines = store.standing(lambda _: True, {BASELINE})
        brief = list(store.standing_mutants(lambda _: True))
    assert baselines == tuple(one for one in whole if one.mutant == BASELINE)
    names = [f"{one.subject.id}/{one.situation}/{one.seed}" for one in brief]
    assert sorted(names) == sorted(one.name for one in whole if one.mutant != BASELINE)
    found, expected = rulings_beside(baselines, brief), rulings_of(whole)
    assert found == expected


def test_whether_flights_stand_is_asked_once_of_what_they_were_made_from(tmp_path: Path):
    one, other = (Origin("s", "r", "c", "m", situation) for situation in ("t", "u"))
    with Store(tmp_path / "s.sqlite") as store:
        store.plan(Planned(o.key(s), M, HERE, s, origin=o) for o in (one, other) for s in (0, 1))
        for made_from in (one, other):
            for seed in (1, 0):
                store.put(made_from.key(seed), outcome(M, seed=seed, digest=made_from.situation))
        store.put("k", outcome(M, seed=7))
        numbers = {origin: number for number, origin in store.origins().items()}
        asked: list[FlownFlight] = []

        def stands(flight: FlownFlight) -> bool:
            asked.append(flight)
            return flight.origin != numbers[one]

        assert [(o.digest, o.seed) for o in store.standing(stands)] == [("u", 0), ("u", 1), (M, 7)]
        assert [flight.origin for flight in asked] == [numbers[one], numbers[other], None]
        assert store.flights()[-1] == FlownFlight("k", M, HERE, 7, None)


def test_a_store_with_a_row_that_cannot_be_read_is_closed_while_the_error_is_still_looked_at(tmp_path: Path):
    path = tmp_path / "s.sqlite"
    with Store(path) as store:
        store.put_all((str(seed), outcome(M, seed=seed)) for seed in range(3))
    with closing(sqlite3.connect(path)) as connection:
        connection.execute("UPDATE outcomes SET digest = CAST(X'FFFE' AS TEXT) WHERE seed = 1")
        connection.commit()
    with pytest.raises(InputError, match=r"id 2: digest="), Store(path, create=False) as store:
        store.keyed()
    assert [one.name for one in tmp_path.iterdir()] == [path.name]


NAME = "outcomes.sqlite"


def _replaced(path: Path) -> None:
    other = path.with_name("other.sqlite")
    shutil.copy(path, other)
    other.replace(path)


def _cut(path: Path) -> None:
    with path.open("r+b") as file:
        file.truncate(4096)


LOSSES: dict[str, tuple[Callable[[Path], object], str]] = {
    "file removed": (lambda path: path.unlink(), "outcomes.sqlite was removed or renamed"),
    "file replaced": (_replaced, "outcomes.sqlite was replaced by another file"),
    "folder removed": (lambda path: shutil.rmtree(path.parent), "outcomes.sqlite was removed or renamed"),
    "folder renamed": (lambda path: path.parent.rename(path.parents[1] / "moved"), "was removed or renamed"),
    "all results removed": (lambda path: shutil.rmtree(path.parents[1]), "was removed or renamed"),
    "log removed": (lambda path: path.with_name(f"{NAME}-wal").unlink(), "outcomes.sqlite-wal was removed or renamed"),
}


@pytest.mark.parametrize("loss", LOSSES)
def test_a_store_that_is_lost_is_noticed_at_the_next_save_and_its_flights_are_copied(tmp_path: Path, loss: str):
    path = tmp_path / "campaigns" / "mine" / NAME
    flown = [replace(outcome(M, seed=seed), track=os.urandom(3000)) for seed in range(5)]
    lose, reason = LOSSES[loss]
    with Store(path) as store:
        for one in flown[:4]:
            store.put(str(one.seed), one)
        lose(path)
        with pytest.raises(InputError) as raised:
            store.put("4", flown[4])
    rescued = tmp_path / "campaigns" / "mine-rescued"
    said = str(raised.value)
    assert said.startswith(f"{path}: the campaign's store is lost: ")
    assert reason in said
    assert said.endswith(f"; a copy with its 5 flights is in {rescued}, which --campaign takes")
    with Store(rescued / NAME) as again:
        assert [again.get(str(one.seed)) for one in flown] == flown
        assert again.put("5", outcome(M, seed=5))


def test_a_second_loss_gets_a_folder_of_its_own(tmp_path: Path):
    for number in ("", "-2", "-3"):
        with Store(tmp_path / "mine" / NAME) as store:
            (tmp_path / "mine" / NAME).unlink()
            with pytest.raises(InputError, match=rf"1 flight is in {tmp_path}/mine-rescued{number}, which"):
                store.put("k", outcome(M))


def test_where_no_copy_fits_beside_it_is_made_in_the_temporary_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    temporary = tmp_path / "tmp"
    temporary.mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(temporary))
    path = tmp_path / "results" / "mine" / NAME
    with Store(path) as store:
        shutil.rmtree(tmp_path / "results")
        (tmp_path / "results").write_text("a file where the folder was")
        with pytest.raises(InputError, match=rf"1 flight is in {temporary}/scaloft-fi-rescued-"):
            store.put("k", outcome(M))
    (copy,) = temporary.rglob(NAME)
    with Store(copy, create=False) as again:
        assert again.known(["k"]) == {"k"}


def test_a_file_that_was_cut_cannot_be_copied_and_the_message_says_so(tmp_path: Path):
    path = tmp_path / "mine" / NAME
    with Store(path) as store:
        for seed in range(20):
            store.put(str(seed), replace(outcome(M, seed=seed), track=os.urandom(20_000)))
        store._connection.execute("PRAGMA wal_checkpoint(TRUNCATE)")
        store.put("20", outcome(M, seed=20))
        _cut(path)
        with pytest.raises(InputError, match=r"was cut; (no copy of its flights could be made|a copy with its)"):
            store.put("21", outcome(M, seed=21))


def test_a_folder_that_becomes_read_only_is_noticed_and_everything_is_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    path = tmp_path / "mine" / NAME
    with Store(path) as store:
        store.put("0", outcome(M))
        monkeypatch.setattr("os.access", lambda _path, _mode: False)
        with pytest.raises(InputError, match=r"can no longer be written; 2 flights of this command and all earlier"):
            store.put("1", outcome(M, seed=1))
    with Store(path, create=False) as store:
        assert store.known("01") == {"0", "1"}


@cases("code", "words")
def test_an_error_of_the_disk_is_one_sentence_that_says_what_is_kept(tmp_path: Path, code: str, words: str):
    with Store(tmp_path / NAME) as store:
        store.put("0", outcome(M))

        def failing() -> None:
            with store.transaction():
                error = sqlite3.OperationalError("odd")
                error.sqlite_errorname = code
                raise error

        with pytest.raises(InputError) as raised:
            failing()
    kept = "1 flight of this command and all earlier ones are kept, and the same command resumes"
    assert str(raised.value) == f"{tmp_path / NAME}: the campaign's store cannot be used: {words}; {kept}"


def test_a_save_that_takes_long_is_said_while_it_takes_long(monkeypatch: pytest.MonkeyPatch):
    said, told = list[str](), threading.Event()
    monkeypatch.setattr(store, "SLOW_S", 0.01)

    def say(text: str) -> None:
        said.append(text)
        told.set()

    with told_when_slow(Path("mine"), say):
        assert told.wait(10)
    (line,) = said
    assert line.startswith("warning: mine: a save has taken 0.01 s so far")
    monkeypatch.setattr(store, "SLOW_S", 60.0)
    before = threading.active_count()
    with told_when_slow(Path("mine"), say):
        pass
    assert (len(said), threading.active_count()) == (1, before)
