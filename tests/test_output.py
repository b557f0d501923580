"""Files are written whole or not at all, and a signal ends the command with one sentence: nothing is left."""

from __future__ import annotations

import errno
import io
import json
import os
import pty
import re
import signal
import stat
import struct
import subprocess
import sys
import threading
import time
from fcntl import ioctl
from pathlib import Path
from termios import TIOCSWINSZ

import pytest
from hypothesis import given
from hypothesis import strategies as st
from printed import obeyed
from processes import ROOT, marked

from scaloft_fi import output
from scaloft_fi.campaign.processes import HANGUP
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
    write_whole,
)


def test_a_new_file_and_an_earlier_file_get_the_whole_content_and_nothing_else_stays(tmp_path: Path):
    path = tmp_path / "out.csv"
    for content in (b"one", b"", b"three" * 100_000):
        write_whole(path, content)
        assert path.read_bytes() == content
    assert list(tmp_path.iterdir()) == [path]


def test_permissions_of_an_earlier_file_stay_and_a_new_file_follows_the_mask(tmp_path: Path):
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
):
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


def test_a_link_stays_a_link_and_its_target_is_written(tmp_path: Path):
    (tmp_path / "there").mkdir()
    target, link = tmp_path / "there" / "target", tmp_path / "link"
    link.symlink_to("there/target")
    for content in (b"new", b"again"):  # first there is no target
        write_whole(link, content)
        assert link.is_symlink()
        assert target.read_bytes() == content
    assert sorted(path.name for path in tmp_path.rglob("*")) == ["link", "target", "there"]


def test_a_file_that_may_not_be_written_is_not_replaced(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    path = tmp_path / "out"
    path.write_bytes(b"kept")
    before = path.stat().st_ino
    monkeypatch.setattr("os.access", lambda place, _mode: Path(place) != tmp_path)
    write_whole(path, b"in place")  # the folder takes no other file
    assert (path.read_bytes(), path.stat().st_ino) == (b"in place", before)


def test_pipes_and_devices_are_written_directly(tmp_path: Path):
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


def test_the_standard_output_is_continued_wherever_it_goes(tmp_path: Path):
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
def test_an_impossible_name_is_an_error_of_the_file_system(tmp_path: Path, name: str):
    with pytest.raises((OSError, ValueError)):
        write_whole(tmp_path / name, b"x")
    assert list(tmp_path.iterdir()) == []


NUMBERS = (signal.SIGINT, signal.SIGTERM, *HANGUP)


def _started(program: str, cwd: Path) -> subprocess.Popen[str]:
    process = subprocess.Popen(
        [sys.executable, "-c", program], cwd=cwd, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
    )  # fmt: skip
    assert process.stdout.readline() == "ready\n"
    return process


@pytest.mark.parametrize("number", NUMBERS)
def test_a_signal_ends_the_process_wherever_it_is_even_where_exceptions_are_swallowed(
    number: signal.Signals, tmp_path: Path
):
    swallowing = "while True:\n    try:\n        time.sleep(60)\n    except BaseException:\n        pass\n"
    program = "import time; from scaloft_fi import output; output.end_at_signals(); print('ready', flush=True)\n"
    process = _started(program + swallowing, tmp_path)
    process.send_signal(number)
    _, said = process.communicate(timeout=30)
    assert (process.returncode, said) == (130, "\nerror: interrupted\n")


def test_a_file_that_is_being_written_is_gone_and_the_earlier_one_is_whole(tmp_path: Path):
    (tmp_path / "report.html").write_text("earlier")
    program = (
        "import os, time; from pathlib import Path; from scaloft_fi import output; output.end_at_signals()\n"
        "def slow(_): print('ready', flush=True); time.sleep(60)\n"
        "os.fsync = slow\n"
        "output.write_whole(Path('report.html'), b'new')\n"
    )
    process = _started(program, tmp_path)
    assert len(list(tmp_path.iterdir())) == 2
    process.send_signal(signal.SIGINT)
    process.communicate(timeout=30)
    assert [path.name for path in tmp_path.iterdir()] == ["report.html"]
    assert (tmp_path / "report.html").read_text() == "earlier"


def test_what_nohup_ignores_stays_ignored(tmp_path: Path):
    program = (
        "import signal; from scaloft_fi import output; signal.signal(signal.SIGHUP, signal.SIG_IGN)\n"
        "output.end_at_signals(); print('ready', flush=True); signal.raise_signal(signal.SIGHUP)\n"
    )
    process = _started(program, tmp_path)
    _, said = process.communicate(timeout=30)
    assert (process.returncode, said) == (0, "")


def _interrupted(words: list[str], after: bytes, wait_s: float) -> tuple[int, str, list[int]]:
    """Run the command in a terminal, press Ctrl-C `wait_s` after it printed `after`.

    Returns exit code, what the terminal shows, and the processes that are left.
    """
    mark = f"terminal of {os.getpid()} at {time.monotonic_ns()}"
    pid, terminal = pty.fork()
    if pid == 0:
        os.chdir(ROOT)
        os.execve(sys.executable, [sys.executable, "-m", "scaloft_fi", *words], {**os.environ, "MARK": mark})
    shown, pressed = b"", False
    while True:
        try:
            shown += os.read(terminal, 65536)
        except OSError:  # the other end is closed
            break
        if after in shown and not pressed:
            time.sleep(wait_s)
            os.write(terminal, b"\x03")
            pressed = True
    _, status = os.waitpid(pid, 0)
    os.close(terminal)
    return os.waitstatus_to_exitcode(status), shown.decode(errors="replace"), marked(mark)


@pytest.mark.flight
@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="reads /proc")
@pytest.mark.parametrize("wait_s", [pytest.param(0.0, marks=pytest.mark.release), 1.3])
def test_ctrl_c_while_two_workers_fly_saves_what_was_flown_in_one_sentence(wait_s: float, tmp_path: Path):
    words = ["run", "--mutant", "LATE-human", "--situation", "T0O0*", "--jobs", "2", "--campaign", f"{tmp_path}/c"]
    code, shown, left = _interrupted(words, b" flights  ", wait_s)
    assert code == 130
    assert re.findall(r"error: [^\r\n]*", re.sub(r"\x1b\[\d*m", "", shown))[0].startswith("error: interrupted: ")
    assert shown.count("interrupted") == 1
    assert "Traceback" not in shown
    assert "Exception ignored" not in shown
    assert left == []


class Failing(io.StringIO):
    """A stream whose writes fail."""

    def __init__(self, number: int) -> None:
        super().__init__()
        self.number = number

    def write(self, text: str, /) -> int:
        raise OSError(self.number, "no room") if self.number != errno.EPIPE else BrokenPipeError(self.number, "left")


def test_a_result_is_told_without_what_a_terminal_obeys(capsys: pytest.CaptureFixture[str]):
    output.tell("a\x1b[2J\nb\n")
    output.tell_line("one\nline\x07")
    output.tell(Marked("\x1b[1mours\x1b[0m\n"))
    assert capsys.readouterr().out == "a\\x1b[2J\nb\none line\\x07\n\x1b[1mours\x1b[0m\n"


def test_bytes_are_those_of_a_file(capfdbinary: pytest.CaptureFixture[bytes]):
    output.tell("\N{LATIN SMALL LETTER U WITH DIAERESIS}\r\n".encode())
    assert capfdbinary.readouterr().out == b"\xc3\xbc\r\n"


def test_a_terminal_gets_bytes_as_printable_text(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]):
    monkeypatch.setattr("sys.stdout.isatty", lambda: True)
    output.tell(b"a\x1b[2J\xff\n")
    assert capsys.readouterr().out == "a\\x1b[2J\\xff\n"


def test_a_message_is_one_line(capsys: pytest.CaptureFixture[str]):
    output.say("warning: a\nb \x1b[1m")
    assert capsys.readouterr().err == "warning: a b \\x1b[1m\n"


@pytest.mark.parametrize("number", [errno.ENOSPC, errno.EBADF, errno.EIO])
def test_a_result_that_cannot_be_written_is_an_error(monkeypatch: pytest.MonkeyPatch, number: int):
    monkeypatch.setattr("sys.stdout", Failing(number))
    with pytest.raises(InputError, match=r"standard output cannot be written: (no room|it is closed)"):
        output.tell("a")


def test_a_reader_that_left_is_no_error(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr("sys.stdout", Failing(errno.EPIPE))
    output.tell("a")


@pytest.mark.parametrize("number", [errno.ENOSPC, errno.EPIPE])
def test_a_message_that_cannot_be_written_stops_nothing(monkeypatch: pytest.MonkeyPatch, number: int):
    monkeypatch.setattr("sys.stderr", Failing(number))
    output.say("a")


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
    assert output.styled("", output.Style.BAD) == ""


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
