"""A signal ends the command with one sentence and the exit code 130: no traceback, no file, no process is left."""

from __future__ import annotations

import os
import pty
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from scaloft_fi.campaign.processes import HANGUP

ROOT = Path(__file__).parents[1]
NUMBERS = (signal.SIGINT, signal.SIGTERM, *HANGUP)


def _started(program: str, cwd: Path) -> subprocess.Popen[str]:
    process = subprocess.Popen(
        [sys.executable, "-c", program], cwd=cwd, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
    )  # fmt: skip
    assert process.stdout is not None
    assert process.stdout.readline() == "ready\n"
    return process


@pytest.mark.parametrize("number", NUMBERS)
def test_a_signal_ends_the_process_wherever_it_is_even_where_exceptions_are_swallowed(
    number: signal.Signals, tmp_path: Path
) -> None:
    swallowing = "while True:\n    try:\n        time.sleep(60)\n    except BaseException:\n        pass\n"
    program = "import time; from scaloft_fi import output; output.end_at_signals(); print('ready', flush=True)\n"
    process = _started(program + swallowing, tmp_path)
    process.send_signal(number)
    _, said = process.communicate(timeout=30)
    assert (process.returncode, said) == (130, "\nerror: interrupted\n")


def test_a_file_that_is_being_written_is_gone_and_the_earlier_one_is_whole(tmp_path: Path) -> None:
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


def test_what_nohup_ignores_stays_ignored(tmp_path: Path) -> None:
    program = (
        "import signal; from scaloft_fi import output; signal.signal(signal.SIGHUP, signal.SIG_IGN)\n"
        "output.end_at_signals(); print('ready', flush=True); signal.raise_signal(signal.SIGHUP)\n"
    )
    process = _started(program, tmp_path)
    _, said = process.communicate(timeout=30)
    assert (process.returncode, said) == (0, "")


def _interrupted(words: list[str], after: bytes, wait_s: float) -> tuple[int, str, list[int]]:
    """Run the command in a terminal, press Ctrl-C `wait_s` after it printed `after`.

    Returns exit code, what the terminal shows, and the processes of the terminal's session that are left.
    """
    pid, terminal = pty.fork()
    if pid == 0:
        os.chdir(ROOT)
        os.execv(sys.executable, [sys.executable, "-m", "scaloft_fi", *words])
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
    return os.waitstatus_to_exitcode(status), shown.decode(errors="replace"), _session(pid)


def _session(number: int) -> list[int]:
    """The processes of a session that live."""
    found = []
    for path in Path("/proc").glob("[0-9]*/stat"):
        try:
            state, _, _, session, *_ = path.read_text().rpartition(")")[2].split()
        except OSError:
            continue
        if int(session) == number and state != "Z":
            found.append(int(path.parent.name))
    return found


@pytest.mark.flight
@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="reads /proc")
@pytest.mark.parametrize("wait_s", [0.0, 1.3])
def test_ctrl_c_while_two_workers_fly_saves_what_was_flown_in_one_sentence(wait_s: float, tmp_path: Path) -> None:
    words = ["run", "--mutant", "LATE-human", "--situation", "T0O0*", "--jobs", "2", "--campaign", f"{tmp_path}/c"]
    code, shown, left = _interrupted(words, b" flights  ", wait_s)
    assert code == 130
    assert re.findall(r"error: [^\r\n]*", re.sub(r"\x1b\[\d*m", "", shown))[0].startswith("error: interrupted: ")
    assert shown.count("interrupted") == 1
    assert "Traceback" not in shown
    assert "Exception ignored" not in shown
    assert left == []
