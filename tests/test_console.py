from __future__ import annotations

import errno
import io

import pytest

from scaloft_fi import console
from scaloft_fi.console import Marked
from scaloft_fi.errors import InputError


class Failing(io.StringIO):
    """A stream whose writes fail."""

    def __init__(self, number: int) -> None:
        super().__init__()
        self.number = number

    def write(self, text: str, /) -> int:
        raise OSError(self.number, "no room") if self.number != errno.EPIPE else BrokenPipeError(self.number, "left")


def test_a_result_is_told_without_what_a_terminal_obeys(capsys: pytest.CaptureFixture[str]) -> None:
    console.tell("a\x1b[2J\nb\n")
    console.tell_line("one\nline\x07")
    console.tell(Marked("\x1b[1mours\x1b[0m\n"))
    assert capsys.readouterr().out == "a\\x1b[2J\nb\none line\\x07\n\x1b[1mours\x1b[0m\n"


def test_bytes_are_those_of_a_file(capfdbinary: pytest.CaptureFixture[bytes]) -> None:
    console.tell("\N{LATIN SMALL LETTER U WITH DIAERESIS}\r\n".encode())
    assert capfdbinary.readouterr().out == b"\xc3\xbc\r\n"


def test_a_terminal_gets_bytes_as_printable_text(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("sys.stdout.isatty", lambda: True)
    console.tell(b"a\x1b[2J\xff\n")
    assert capsys.readouterr().out == "a\\x1b[2J\\xff\n"


def test_a_message_is_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    console.say("warning: a\nb \x1b[1m")
    assert capsys.readouterr().err == "warning: a b \\x1b[1m\n"


@pytest.mark.parametrize("number", [errno.ENOSPC, errno.EBADF, errno.EIO])
def test_a_result_that_cannot_be_written_is_an_error(monkeypatch: pytest.MonkeyPatch, number: int) -> None:
    monkeypatch.setattr("sys.stdout", Failing(number))
    with pytest.raises(InputError, match=r"standard output cannot be written: (no room|it is closed)"):
        console.tell("a")


def test_a_reader_that_left_is_no_error(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sys.stdout", Failing(errno.EPIPE))
    console.tell("a")


@pytest.mark.parametrize("number", [errno.ENOSPC, errno.EPIPE])
def test_a_message_that_cannot_be_written_stops_nothing(monkeypatch: pytest.MonkeyPatch, number: int) -> None:
    monkeypatch.setattr("sys.stderr", Failing(number))
    console.say("a")
