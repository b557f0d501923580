"""Files are written whole or not at all, and a signal ends the command with one sentence: nothing is left."""

from __future__ import annotations

import os
import pty
import re
import signal
import stat
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest
from processes import ROOT, marked

from scaloft_fi import output
from scaloft_fi.campaign.processes import HANGUP
from scaloft_fi.output import write_whole


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
