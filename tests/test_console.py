"""What is told and shown: inert, as wide as the terminal, in colours where they are wanted."""

from __future__ import annotations

import errno
import io
import json
import os
import pty
import struct
import subprocess
import sys
from fcntl import ioctl
from termios import TIOCSWINSZ

import pytest
from hypothesis import given
from hypothesis import strategies as st
from printed import obeyed

from scaloft_fi import output as console
from scaloft_fi.errors import InputError
from scaloft_fi.output import (
    LEAST,
    PIPED,
    Marked,
    all_printable,
    coloured,
    joined,
    json_text,
    line,
    printable,
    width,
    wrapped,
)


class Failing(io.StringIO):
    """A stream whose writes fail."""

    def __init__(self, number: int) -> None:
        super().__init__()
        self.number = number

    def write(self, text: str, /) -> int:
        raise OSError(self.number, "no room") if self.number != errno.EPIPE else BrokenPipeError(self.number, "left")


def test_a_result_is_told_without_what_a_terminal_obeys(capsys: pytest.CaptureFixture[str]):
    console.tell("a\x1b[2J\nb\n")
    console.tell_line("one\nline\x07")
    console.tell(Marked("\x1b[1mours\x1b[0m\n"))
    assert capsys.readouterr().out == "a\\x1b[2J\nb\none line\\x07\n\x1b[1mours\x1b[0m\n"


def test_bytes_are_those_of_a_file(capfdbinary: pytest.CaptureFixture[bytes]):
    console.tell("\N{LATIN SMALL LETTER U WITH DIAERESIS}\r\n".encode())
    assert capfdbinary.readouterr().out == b"\xc3\xbc\r\n"


def test_a_terminal_gets_bytes_as_printable_text(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]):
    monkeypatch.setattr("sys.stdout.isatty", lambda: True)
    console.tell(b"a\x1b[2J\xff\n")
    assert capsys.readouterr().out == "a\\x1b[2J\\xff\n"


def test_a_message_is_one_line(capsys: pytest.CaptureFixture[str]):
    console.say("warning: a\nb \x1b[1m")
    assert capsys.readouterr().err == "warning: a b \\x1b[1m\n"


@pytest.mark.parametrize("number", [errno.ENOSPC, errno.EBADF, errno.EIO])
def test_a_result_that_cannot_be_written_is_an_error(monkeypatch: pytest.MonkeyPatch, number: int):
    monkeypatch.setattr("sys.stdout", Failing(number))
    with pytest.raises(InputError, match=r"standard output cannot be written: (no room|it is closed)"):
        console.tell("a")


def test_a_reader_that_left_is_no_error(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr("sys.stdout", Failing(errno.EPIPE))
    console.tell("a")


@pytest.mark.parametrize("number", [errno.ENOSPC, errno.EPIPE])
def test_a_message_that_cannot_be_written_stops_nothing(monkeypatch: pytest.MonkeyPatch, number: int):
    monkeypatch.setattr("sys.stderr", Failing(number))
    console.say("a")


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
def test_columns_tell_the_width(said: str, found: int, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(sys, "stdout", io.StringIO())
    monkeypatch.setenv("COLUMNS", said)
    assert width() == found


def test_a_terminal_tells_its_width():
    ours, theirs = pty.openpty()
    ioctl(theirs, TIOCSWINSZ, struct.pack("HHHH", 24, 73, 0, 0))
    program = "from scaloft_fi.output import width; print(width())"
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
):
    for name, value in said.items():
        monkeypatch.setenv(name, value)
    assert coloured(stream) is found


def test_marks_are_kept_where_texts_are_joined():
    assert isinstance(joined([Marked("a"), "b"]), Marked)
    assert type(joined(["a", "b"])) is str
    assert console.styled("", console.Style.BAD) == ""


WORDS = st.lists(st.sampled_from(["NO-depth@3s", "a", "`scaloft-fi run --seeds 3`", "p/" * 30]), max_size=20)


@given(WORDS, st.integers(30, 100))
def test_no_word_and_no_command_that_fits_is_broken(words: list[str], width: int):
    lines = wrapped(" ".join(words), width, "  ", "    ").split("\n")
    assert " ".join(" ".join(lines).split()) == " ".join(words)
    for row in lines:
        assert len(row) <= width or len(row.split()) == 1
    assert sum(row.count("`scaloft-fi run --seeds 3`") for row in lines) == words.count("`scaloft-fi run --seeds 3`")


def test_a_command_that_is_longer_than_a_line_can_be_pasted_into_a_shell():
    command = "echo scaloft-fi run --mutant LATE-human@3s --situation shows-LATE-human@3s --seeds 10"
    text = wrapped(f"What next: `{command}` flies it, `echo more` too.", 40, "", "    ")
    assert len(text.split("\n")) > 2
    assert max(map(len, text.split("\n"))) <= 40
    pasted = text.partition("`")[2].partition("`")[0]
    said = subprocess.run(["sh", "-c", pasted], capture_output=True, text=True, check=True).stdout
    assert f"echo {said.strip()}" == command
    assert text.count("\\") == pasted.count("\\") == pasted.count("\n")


texts = st.text(st.characters(), max_size=40)  # lone surrogates too
values = st.recursive(
    texts | st.integers() | st.booleans() | st.none(),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(texts, inner, max_size=3),
    max_leaves=8,
)
OBEYED = "\x00\x07\x08\x0c\r\x1b\x7f\x85\x9b\xad\u200b\u200d\u200e\u2028\u202e\u2066\u2069\ufeff\udc80\ufffe\U000e0041"


@given(texts)
def test_no_printable_text_holds_what_a_terminal_obeys_or_hides(text: str):
    shown = printable(text)
    assert obeyed(shown) == set()
    assert printable(shown) == shown
    shown.encode()


@pytest.mark.parametrize("letter", OBEYED)
def test_what_is_obeyed_is_spelled_out(letter: str):
    assert printable(f"a{letter}b") == f"a{ascii(letter)[1:-1]}b"


@pytest.mark.parametrize("text", ["人が検出されない — Ürümqi ñ ٣ 🙂", "two\nlines\tand a tab", "a\xa0b", ""])
def test_letters_of_every_script_line_breaks_and_tabs_stay(text: str):
    assert printable(text) == text


@given(texts)
def test_a_line_is_one_line(text: str):
    assert len(line(text).splitlines()) <= 1
    assert line(line(text)) == line(text)


@given(values, st.booleans())
def test_json_comes_back_and_shows_nothing_that_isobeyed(content: object, letters: bool):
    text = json_text(content, indent=1, letters=letters)
    assert obeyed(text) == set()
    assert json.loads(text) == content
    text.encode()


def test_a_number_that_is_not_finite_is_no_json():
    with pytest.raises(ValueError, match="Out of range"):
        json_text([float("nan")])


@given(values)
def test_all_texts_of_json_values_become_printable(content: object):
    assert obeyed(json.dumps(all_printable(content), ensure_ascii=False)) == set()
