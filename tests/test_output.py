from __future__ import annotations

import os
import stat
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from scaloft_fi import output
from scaloft_fi.output import write_whole

ROOT = Path(__file__).parents[1]


def test_a_new_file_and_an_earlier_file_get_the_whole_content_and_nothing_else_stays(tmp_path: Path) -> None:
    path = tmp_path / "out.csv"
    for content in (b"one", b"", b"three" * 100_000):
        write_whole(path, content)
        assert path.read_bytes() == content
    assert list(tmp_path.iterdir()) == [path]


def test_permissions_of_an_earlier_file_stay_and_a_new_file_follows_the_mask(tmp_path: Path) -> None:
    old, new = tmp_path / "old", tmp_path / "new"
    old.touch()
    old.chmod(0o640)
    mask = os.umask(0o027)
    try:
        write_whole(old, b"a")
        write_whole(new, b"a")
    finally:
        os.umask(mask)
    assert [stat.S_IMODE(path.stat().st_mode) for path in (old, new)] == [0o640, 0o640]
    old.chmod(0o600)
    write_whole(old, b"b")
    assert stat.S_IMODE(old.stat().st_mode) == 0o600


@pytest.mark.parametrize("fails", ["fsync", "replace", "write"])
def test_after_a_failure_the_earlier_file_is_as_it_was_and_no_other_file_stays(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, fails: str
) -> None:
    path = tmp_path / "out"
    path.write_bytes(b"earlier")

    def failing(*_words: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path if fails == "replace" else output.os, fails, failing)
    for place in (path, tmp_path / "new"):
        with pytest.raises(OSError, match="No space"):
            write_whole(place, b"later")
    assert path.read_bytes() == b"earlier"
    assert list(tmp_path.iterdir()) == [path]


def test_a_link_stays_a_link_and_its_target_is_written(tmp_path: Path) -> None:
    (tmp_path / "there").mkdir()
    target, link = tmp_path / "there" / "target", tmp_path / "link"
    link.symlink_to("there/target")
    for content in (b"new", b"again"):  # first there is no target
        write_whole(link, content)
        assert link.is_symlink()
        assert target.read_bytes() == content
    assert sorted(path.name for path in tmp_path.rglob("*")) == ["link", "target", "there"]


def test_a_file_that_may_not_be_written_is_not_replaced(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "out"
    path.write_bytes(b"kept")
    before = path.stat().st_ino
    monkeypatch.setattr("os.access", lambda place, _mode: Path(place) != tmp_path)
    write_whole(path, b"in place")  # the folder takes no other file
    assert (path.read_bytes(), path.stat().st_ino) == (b"in place", before)


def test_pipes_and_devices_are_written_directly(tmp_path: Path) -> None:
    pipe, found = tmp_path / "pipe", list[bytes]()
    os.mkfifo(pipe)
    reader = threading.Thread(target=lambda: found.append(pipe.read_bytes()), daemon=True)
    reader.start()
    write_whole(pipe, b"through the pipe")
    reader.join(10)
    assert found == [b"through the pipe"]
    assert stat.S_ISFIFO(pipe.stat().st_mode)
    write_whole(Path(os.devnull), b"gone")
    assert stat.S_ISCHR(Path(os.devnull).stat().st_mode)
    if Path("/dev/full").exists():
        with pytest.raises(OSError, match="No space"):
            write_whole(Path("/dev/full"), b"x")


def test_the_standard_output_is_continued_wherever_it_goes(tmp_path: Path) -> None:
    script = (
        "from pathlib import Path; from scaloft_fi.output import write_whole; print('before');"
        "write_whole(Path('/dev/stdout'), b'content\\n'); print('after')"
    )
    path = tmp_path / "log"
    path.write_text("earlier\n")
    command, environment = [sys.executable, "-c", script], {**os.environ, "PYTHONPATH": str(ROOT)}
    with path.open("a") as file:
        subprocess.run(command, env=environment, stdout=file, check=True)
    assert path.read_text() == "earlier\nbefore\ncontent\nafter\n"
    piped = subprocess.run(command, env=environment, stdout=subprocess.PIPE, check=True)
    assert piped.stdout == b"before\ncontent\nafter\n"
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("name", ["x" * 300, "no\0name", "no/folder/out", "."])
def test_an_impossible_name_is_an_error_of_the_file_system(tmp_path: Path, name: str) -> None:
    with pytest.raises((OSError, ValueError)):
        write_whole(tmp_path / name, b"x")
    assert list(tmp_path.iterdir()) == []
