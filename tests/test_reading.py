"""The one reader: what is no regular file of a bounded size is refused in a sentence, at once."""

from __future__ import annotations

import errno
import os
import pickle
import socket
from pathlib import Path

import pytest

from scaloft_fi import document
from scaloft_fi.document import UnreadableError, digest, read_bytes, read_text


def pipe(path: Path) -> None:
    os.mkfifo(path)


def listening(path: Path) -> None:
    with socket.socket(socket.AF_UNIX) as plug:
        plug.bind(str(path))


ODD = {
    "a pipe": pipe,
    "a folder": Path.mkdir,
    "a device": lambda path: path.symlink_to("/dev/zero"),
    os.strerror(errno.ELOOP): lambda path: path.symlink_to(path.name),
    os.strerror(errno.ENOENT): lambda path: path.symlink_to("nowhere"),
    os.strerror(errno.ENXIO): listening,
}


@pytest.mark.parametrize("read", [read_bytes, read_text, digest])
@pytest.mark.parametrize("kind", ODD)
def test_what_is_no_regular_file_is_refused_at_once(tmp_path, monkeypatch, kind, read):
    monkeypatch.chdir(tmp_path)  # a socket has a short name
    ODD[kind](path := Path("odd"))
    with pytest.raises(UnreadableError, match=f"^odd: cannot be read: .*{kind}"):
        read(path)


@pytest.mark.parametrize("name", ["a\0b", "a" * 300, "~nosuchuser/a.yaml", "nowhere/a.yaml"])
def test_a_name_that_the_system_refuses_is_refused_in_a_sentence(tmp_path, name):
    with pytest.raises(UnreadableError, match="cannot be read: "):
        read_bytes(tmp_path / name)
    assert not document.is_file(tmp_path / name)
    assert not document.is_folder(tmp_path / name)


def test_a_file_of_the_largest_size_is_read_and_a_larger_file_is_refused_with_the_limit(tmp_path):
    path = tmp_path / "a"
    path.write_bytes(b"x" * 1000)
    assert read_bytes(path, 1000) == b"x" * 1000
    assert digest(path, 1000) == digest(path)
    for read in (read_bytes, read_text, digest):
        with pytest.raises(UnreadableError, match="larger than 999 bytes"):
            read(path, 999)


def test_a_file_whose_size_the_system_does_not_tell_is_bounded_too(monkeypatch):
    status = Path("/proc/self/status")
    if not status.exists():
        pytest.skip("only Linux has files of unknown size")
    assert status.stat().st_size == 0
    with pytest.raises(UnreadableError, match="larger than 10 bytes"):
        read_bytes(status, 10)


def test_bytes_that_are_no_text_are_refused(tmp_path):
    (tmp_path / "a").write_bytes(b"\xff")
    with pytest.raises(UnreadableError, match="not UTF-8 text"):
        read_text(tmp_path / "a")


def test_a_link_that_leads_nowhere_is_there(tmp_path):
    (tmp_path / "a").symlink_to("nowhere")
    assert document.is_there(tmp_path / "a")
    assert not document.is_there(tmp_path / "b")


def test_the_refusal_survives_the_way_between_processes(tmp_path):
    with pytest.raises(UnreadableError) as error:
        read_bytes(tmp_path / "a")
    again = pickle.loads(pickle.dumps(error.value))
    assert (str(again), again.reason) == (str(error.value), os.strerror(errno.ENOENT))
