from __future__ import annotations

import multiprocessing
import os
import signal
import subprocess
import sys
import textwrap
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from builders import campaigns, outcome
from hypothesis import HealthCheck, given, settings

from scaloft_fi.campaign.store.origin import Origin
from scaloft_fi.campaign.store.record import Planned
from scaloft_fi.campaign.store.store import SCHEMA, Store
from scaloft_fi.errors import InputError
from scaloft_fi.judge.outcome import Outcome

M = "LATE-human@3s"


def test_what_was_put_is_there_after_reopening(tmp_path: Path) -> None:
    kept = replace(outcome(M), track=b"\x00\x01")
    with Store(tmp_path / "deep" / "campaign.sqlite") as store:
        assert store.put("k", kept)
    with Store(tmp_path / "deep" / "campaign.sqlite", create=False) as store:
        assert store.get("k") == kept
        assert store.get("other") is None
        assert store.known(["k", "other"]) == {"k"}


def test_putting_again_changes_nothing(tmp_path: Path) -> None:
    with Store(tmp_path / "s.sqlite") as store:
        assert store.put("k", outcome(M))
        assert not store.put("k", outcome(M))
        assert not store.put("k", outcome(M, violated={"SR1": 3.0}))
        assert list(store.outcomes()) == [outcome(M)]


def test_an_invalid_flight_gives_way_to_one_that_counts(tmp_path: Path) -> None:
    with Store(tmp_path / "s.sqlite") as store:
        store.put("k", outcome(M, invalid="the worker died"))
        assert store.known(["k"]) == set()
        assert store.put("k", outcome(M))
        assert not store.put("k", outcome(M, invalid="the worker died"))
        assert list(store.outcomes()) == [outcome(M)]


def test_outcomes_come_without_tracks_in_one_order(tmp_path: Path) -> None:
    with Store(tmp_path / "s.sqlite") as store:
        for seed in (2, 0, 1):
            store.put(f"k{seed}", replace(outcome(M, seed=seed), track=b"x"))
        assert list(store.outcomes()) == [outcome(M, seed=seed) for seed in range(3)]
        assert list(store.outcomes(["k1"])) == [outcome(M, seed=1)]


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None, max_examples=10)
@given(campaigns())
def test_a_campaign_survives_the_store(tmp_path: Path, outcomes: list[Outcome]) -> None:
    path = tmp_path / "s.sqlite"
    path.unlink(missing_ok=True)
    with Store(path) as store:
        for _ in range(2):
            for flown in outcomes:
                store.put(flown.name, flown)
        assert sorted(store.outcomes(), key=lambda o: o.name) == sorted(outcomes, key=lambda o: o.name)


def test_the_first_fact_about_a_campaign_stays(tmp_path: Path) -> None:
    with Store(tmp_path / "s.sqlite") as store:
        store.set_meta({"numpy": "1", "system": "Linux"})
        store.set_meta({"numpy": "2"})
        assert store.meta() == {"numpy": "1", "system": "Linux"}


def test_two_processes_may_write_one_store(tmp_path: Path) -> None:
    with Store(tmp_path / "s.sqlite") as one, Store(tmp_path / "s.sqlite") as two:
        assert one.put("a", outcome(M, seed=0))
        assert two.put("b", outcome(M, seed=1))
        assert one.known("ab") == two.known("ab") == {"a", "b"}


def test_a_moment_within_another_is_part_of_it(tmp_path: Path) -> None:
    with Store(tmp_path / "s.sqlite") as store, Store(tmp_path / "s.sqlite") as writer:
        store.put("k", outcome(M))
        with store.snapshot():
            with store.snapshot():
                assert len(store.flights()) == 1
            writer.put("later", outcome(M, seed=1))
            assert len(store.flights()) == 1
        assert len(store.flights()) == 2


def test_a_writer_killed_in_the_middle_loses_nothing_that_was_put(tmp_path: Path) -> None:
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
        assert writer.stdout is not None
        done = [int(writer.stdout.readline()) for _ in range(20)]
        writer.send_signal(signal.SIGKILL)
        done += [int(line) for line in writer.stdout if line.endswith("\n")]
    with Store(path) as store:
        kept = {flown.seed for flown in store.outcomes()}
        assert kept >= set(done)
        assert store.put("after", outcome(M, seed=-1))


def test_a_full_disk_is_one_sentence_and_loses_nothing_that_was_put(tmp_path: Path) -> None:
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


def test_a_track_that_many_flights_have_is_kept_once(tmp_path: Path) -> None:
    with Store(tmp_path / "s.sqlite") as store:
        for seed, track in enumerate((b"same", b"same", b"other", b"")):
            store.put(str(seed), replace(outcome(M, seed=seed), track=track))
        assert [flown.track for _, flown in store.rows()] == [b"same", b"same", b"other", b""]
        assert store._connection.execute("SELECT count(*) FROM tracks").fetchone() == (2,)


def test_there_is_no_campaign_where_none_was_made(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="there is no campaign here"):
        Store(tmp_path / "s.sqlite", create=False)
    assert list(tmp_path.iterdir()) == []


def test_a_results_folder_that_cannot_be_made_is_one_sentence_and_nothing_is_written(tmp_path: Path) -> None:
    (tmp_path / "results").write_text("a file where the folder should be")
    with pytest.raises(InputError, match="the results folder cannot be written"):
        Store(tmp_path / "results" / "campaigns" / "s.sqlite")
    assert [path.name for path in tmp_path.iterdir()] == ["results"]


def test_a_file_that_is_no_store_is_left_alone(tmp_path: Path) -> None:
    path = tmp_path / "s.sqlite"
    path.write_text("these are notes of mine, not a database; " * 50)
    with pytest.raises(InputError, match="cannot be used"):
        Store(path)
    assert path.read_text().startswith("these are notes")


def test_what_was_planned_is_there_with_what_entered_its_key(tmp_path: Path) -> None:
    origin = Origin("s", "r", "c", "m", "t")
    plan = [Planned(origin.key(seed), M, "T0O0W0D0H0", seed, canary=seed > 1, origin=origin) for seed in range(3)]
    with Store(tmp_path / "s.sqlite") as store:
        store.plan(plan)
        store.plan(plan)
        assert store.planned() == sorted(plan)
        assert store._connection.execute("SELECT count(*) FROM origins").fetchone() == (1,)


def test_a_canary_that_is_asked_for_later_is_none_any_more(tmp_path: Path) -> None:
    with Store(tmp_path / "s.sqlite") as store:
        for canary in (True, False, True):
            store.plan([Planned("k", M, "T0O0W0D0H0", 0, canary)])
        assert store.planned() == [Planned("k", M, "T0O0W0D0H0", 0)]


@pytest.mark.parametrize("schema", [SCHEMA - 1, SCHEMA + 1])
def test_a_store_of_another_version_is_refused_and_left_alone(tmp_path: Path, schema: int) -> None:
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


def test_a_campaign_that_can_only_be_read_is_read_and_left_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
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
) -> None:
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


def test_processes_that_begin_one_store_at_once_wait_for_each_other(tmp_path: Path) -> None:
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


def test_a_plan_above_the_limit_is_refused_before_anything_is_flown(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SCALOFT_MOST_FLIGHTS", "2")
    with Store(tmp_path / "s.sqlite") as store:
        store.plan([Planned(key, M, "T0O0W0D0H0", 0) for key in "ab"])
        with pytest.raises(InputError, match=r"more rows than the limit for 2 flights; .* SCALOFT_MOST"):
            store.plan([Planned("c", M, "T0O0W0D0H0", 0)])
        assert [flight.key for flight in store.planned()] == ["a", "b"]
