from __future__ import annotations

import os
import shutil
import sqlite3
import threading
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest
from builders import outcome

from scaloft_fi.campaign.store import store
from scaloft_fi.campaign.store.store import Store, told_when_slow
from scaloft_fi.errors import InputError

M = "LATE-human@3s"
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
def test_a_store_that_is_lost_is_noticed_at_the_next_save_and_its_flights_are_copied(tmp_path: Path, loss: str) -> None:
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


def test_a_second_loss_gets_a_folder_of_its_own(tmp_path: Path) -> None:
    for number in ("", "-2", "-3"):
        with Store(tmp_path / "mine" / NAME) as store:
            (tmp_path / "mine" / NAME).unlink()
            with pytest.raises(InputError, match=rf"1 flight is in {tmp_path}/mine-rescued{number}, which"):
                store.put("k", outcome(M))


def test_where_no_copy_fits_beside_it_is_made_in_the_temporary_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
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


def test_a_file_that_was_cut_cannot_be_copied_and_the_message_says_so(tmp_path: Path) -> None:
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
) -> None:
    path = tmp_path / "mine" / NAME
    with Store(path) as store:
        store.put("0", outcome(M))
        monkeypatch.setattr("os.access", lambda _path, _mode: False)
        with pytest.raises(InputError, match=r"can no longer be written; 2 flights of this command and all earlier"):
            store.put("1", outcome(M, seed=1))
    with Store(path, create=False) as store:
        assert store.known("01") == {"0", "1"}


@pytest.mark.parametrize(
    ("code", "words"),
    [
        ("SQLITE_IOERR_WRITE", "the disk does not answer"),
        ("SQLITE_BUSY", "another process has kept it locked for 30 s"),
        ("SQLITE_FULL", "the disk is full"),
        ("SQLITE_CORRUPT", "odd"),
    ],
)
def test_an_error_of_the_disk_is_one_sentence_that_says_what_is_kept(tmp_path: Path, code: str, words: str) -> None:
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


def test_a_save_that_takes_long_is_said_while_it_takes_long(monkeypatch: pytest.MonkeyPatch) -> None:
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
