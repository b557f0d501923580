from __future__ import annotations

import io
import os
import pty
import struct
import subprocess
import sys
from fcntl import ioctl
from termios import TIOCSWINSZ

import pytest

from scaloft_fi import console
from scaloft_fi.console import LEAST, PIPED, Marked, coloured, joined, width


class Screen(io.StringIO):
    def isatty(self) -> bool:
        return True


@pytest.fixture(autouse=True)
def plain(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("COLUMNS", "NO_COLOR", "FORCE_COLOR", "CLICOLOR_FORCE", "CLICOLOR"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("TERM", "xterm")


@pytest.mark.parametrize(
    ("said", "found"),
    [("60", 60), ("12", LEAST), ("0", PIPED), ("", PIPED), ("-5", PIPED), ("wide", PIPED), ("9" * 5000, PIPED)],
)
def test_columns_tell_the_width(said: str, found: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "stdout", io.StringIO())
    monkeypatch.setenv("COLUMNS", said)
    assert width() == found


def test_a_terminal_tells_its_width() -> None:
    ours, theirs = pty.openpty()
    ioctl(theirs, TIOCSWINSZ, struct.pack("HHHH", 24, 73, 0, 0))
    program = "from scaloft_fi.console import width; print(width())"
    subprocess.run([sys.executable, "-c", program], stdout=theirs, check=True)
    assert os.read(ours, 100).split() == [b"73"]


@pytest.mark.parametrize(
    ("said", "stream", "found"),
    [
        ({}, Screen(), True),
        ({}, io.StringIO(), False),
        ({"NO_COLOR": "1"}, Screen(), False),
        ({"NO_COLOR": ""}, Screen(), True),
        ({"TERM": "dumb"}, Screen(), False),
        ({"CLICOLOR": "0"}, Screen(), False),
        ({"FORCE_COLOR": "1"}, io.StringIO(), True),
        ({"CLICOLOR_FORCE": "1"}, io.StringIO(), True),
        ({"FORCE_COLOR": "0"}, io.StringIO(), False),
        ({"FORCE_COLOR": "1", "NO_COLOR": "1"}, Screen(), False),
    ],
)
def test_colours_are_where_a_terminal_is_or_the_user_wants_them(
    said: dict[str, str], stream: io.StringIO, found: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name, value in said.items():
        monkeypatch.setenv(name, value)
    assert coloured(stream) is found


def test_marks_are_kept_where_texts_are_joined() -> None:
    assert isinstance(joined([Marked("a"), "b"]), Marked)
    assert type(joined(["a", "b"])) is str
    assert console.styled("", console.Style.BAD) == ""
