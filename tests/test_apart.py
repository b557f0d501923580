"""Files of somebody else are read in a process of their own, whose memory and time are bounded."""

from __future__ import annotations

import faulthandler
import os
import re
import resource
import shutil
import signal
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import bombs
import pytest
from hypothesis import given
from hypothesis import strategies as st
from options import usually
from printed import invoked

from scaloft_fi import document as apart
from scaloft_fi.campaign.store.archive import _unpacked, read_columns
from scaloft_fi.document import MIB, read_apart
from scaloft_fi.errors import ExitCode, InputError
from scaloft_fi.hazop.sheet import read_sheet
from scaloft_fi.outside.records import fields_of
from scaloft_fi.sim.mesh import MeshLimits, read_mesh

pytestmark = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="bounds of memory are those of Linux")
HERE = Path(__file__)


@given(st.recursive(st.integers() | st.text() | st.floats(allow_nan=False), st.lists, max_leaves=20))
def test_what_the_work_makes_comes_home_whatever_it_is(made: Any):
    assert read_apart(HERE, lambda: made) == made


def test_an_error_of_the_work_is_told_as_it_is():
    def refuse() -> None:
        raise InputError("flight.bag: no")

    with pytest.raises(InputError, match=r"^flight\.bag: no$"):
        read_apart(HERE, refuse)


def test_what_a_library_prints_beside_python_is_not_shown(capfd: pytest.CaptureFixture[str]):
    assert read_apart(HERE, lambda: os.write(1, b"bad") + os.write(2, b"header")) == 9
    assert capfd.readouterr() == ("", "")


def test_what_unpacks_to_too_much_is_one_sentence():
    with pytest.raises(InputError, match=r"test_apart\.py: it unpacks to more than 512 MiB"):
        read_apart(HERE, lambda: len(bytearray(2 << 30)))


def test_what_takes_too_long_is_one_sentence_and_leaves_no_process(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(apart, "APART_S", 0.3)
    begun: list[int] = []
    fork = os.fork
    monkeypatch.setattr(os, "fork", lambda: begun.append(pid := fork()) or pid)
    with pytest.raises(InputError, match="reading it takes more than 0 s, which what was read of it may take"):
        read_apart(HERE, lambda: time.sleep(60))
    with pytest.raises(ProcessLookupError):
        os.kill(begun[0], 0)


@pytest.mark.parametrize("ended_by", [signal.SIGKILL, signal.SIGABRT])
def test_a_library_that_ends_its_process_ends_not_ours(ended_by: signal.Signals):
    with pytest.raises(InputError, match="reading it ended its process"):
        read_apart(HERE, lambda: (faulthandler.disable(), os.kill(os.getpid(), ended_by)))


def test_the_bounds_grow_with_the_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(apart, "BYTES_A_BYTE", 1 << 20)
    large = tmp_path / "large"
    large.write_bytes(bytes(2_000))
    assert read_apart(large, lambda: len(bytearray(1 << 30))) == 1 << 30


@pytest.fixture
def peaks(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """What each process of its own took at most, beyond what this process has [bytes]."""
    found: list[int] = []

    def waitpid(pid: int, options: int) -> tuple[int, int]:
        pid, status, used = os.wait4(pid, options)
        found.append((used.ru_maxrss - resource.getrusage(resource.RUSAGE_SELF).ru_maxrss) * 1024)
        return pid, status

    monkeypatch.setattr(os, "waitpid", waitpid)
    return found


def refused(peaks: list[int], read: Callable[[], object]) -> str:
    """The sentence of a bomb, which was read within the bounds and left nothing."""
    began_s = time.monotonic()
    with pytest.raises(InputError) as error:
        read()
    assert time.monotonic() - began_s < 20.0
    assert all(peak < 600 * MIB + 16 * 9 * MIB for peak in peaks), peaks
    assert "\n" not in str(error.value)
    return str(error.value)


@pytest.fixture
def temporary(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """The folder of temporary files, which is empty afterwards."""
    folder = tmp_path / "temporary"
    folder.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    yield folder
    assert list(folder.iterdir()) == []


@pytest.mark.parametrize("name", usually([*bombs.RECORDS][:2], release=[*bombs.RECORDS]))
def test_a_record_that_unpacks_to_2_gib_is_one_sentence(name: str, peaks: list[int], temporary: Path, tmp_path: Path):
    path = bombs.RECORDS[name](tmp_path)
    assert re.search(r": it unpacks to more than \d+ MiB, which", refused(peaks, lambda: fields_of(path)))
    assert len(peaks) == 1


@pytest.mark.parametrize("name", bombs.MESHES)
def test_a_mesh_that_declares_more_than_it_has_is_one_sentence(name: str, peaks: list[int], tmp_path: Path):
    path = bombs.MESHES[name](tmp_path)
    told = refused(peaks, lambda: read_mesh(path, "world.yaml:3", 1.0, "z", MeshLimits()))
    assert told.startswith("world.yaml:3: mesh=")
    assert len(peaks) == 1


@pytest.mark.release
def test_a_parquet_whose_one_value_is_meant_often_is_one_sentence(peaks: list[int], tmp_path: Path):
    path = bombs.parquet(tmp_path)
    told = refused(peaks, lambda: read_columns(path, path.read_bytes(), {"text": "string"}))
    assert re.search(r"outcomes\.parquet: it unpacks to more than \d+ MiB, which", told)


@pytest.mark.release
def test_an_archive_that_unpacks_to_640_mib_is_one_sentence(peaks: list[int], temporary: Path, tmp_path: Path):
    path = bombs.archive(tmp_path)
    told = refused(peaks, lambda: _unpacked.__wrapped__(path, 0, path.stat().st_size))
    assert told.startswith(f"{path}: the archive has more than 10000 files or ")
    shutil.rmtree(*temporary.iterdir())


@pytest.mark.release
@pytest.mark.parametrize("name", [*bombs.RECORDS, "slow bag"])
def test_judge_says_one_sentence_of_a_bomb_and_exits_with_2(name: str, tmp_path: Path, temporary: Path):
    path = {**bombs.RECORDS, "slow bag": bombs.slow_bag}[name](tmp_path)
    began_s = time.monotonic()
    told = invoked("judge", "--fields", str(path))
    assert time.monotonic() - began_s < 20.0
    assert told.exit_code == ExitCode.BAD_INPUT
    assert len(told.stderr.splitlines()) == 1


@pytest.mark.release
@pytest.mark.parametrize("name", bombs.SHEETS)
def test_a_workbook_that_unpacks_to_too_much_is_one_sentence(name: str, peaks: list[int], tmp_path: Path):
    path = bombs.SHEETS[name](tmp_path)
    assert str(path) in refused(peaks, lambda: read_sheet(path))


def test_a_limit_of_the_user_stays_a_limit():
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1 << 20, hard))
    try:
        assert read_apart(HERE, lambda: resource.getrlimit(resource.RLIMIT_FSIZE)) == (1 << 20, hard)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


def test_time_is_earned_by_what_is_read_unless_the_file_packs_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(apart, "APART_S", 0.2)
    monkeypatch.setattr(apart, "BYTES_A_S", 1 << 23)

    def slow(name: str, *, reads: bool) -> str:
        path = tmp_path / name
        path.write_bytes(bytes(1 << 24))

        def work() -> str:
            for _ in range(1 + reads):  # of two readings the first earns the time for the second
                len(path.read_bytes()) if reads else None
                time.sleep(0.4)
            return "read"

        return read_apart(path, work)

    assert slow("a.bin", reads=False) == "read"
    assert slow("a.bag", reads=True) == "read"
    with pytest.raises(InputError, match="which what was read of it may take"):
        slow("a.bag", reads=False)
