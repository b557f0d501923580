from __future__ import annotations

import sys
import time
from pathlib import Path

import pytest
from processes import alive, soon

from scaloft_fi.outside.border import BorderError
from scaloft_fi.outside.command import CommandError, Told, run_command, told


def _run(tmp_path: Path, program: str, limit_s: float = 20.0) -> Told:
    (tmp_path / "beside").mkdir(exist_ok=True)
    return run_command([sys.executable, "-c", program], {"OWN": "1"}, tmp_path, limit_s, tmp_path / "beside")


def test_what_the_last_line_says_is_told(tmp_path: Path) -> None:
    program = """
print("warming up")
print('{"altered": 3, "carried": 9, "first_altered_s": 1.5, "stack_error": "died"}')
"""
    assert _run(tmp_path, program) == Told(3, 9, 1.5, "died")
    assert _run(tmp_path, "print('done')") == Told()
    assert _run(tmp_path, "pass") == Told()


def test_it_runs_in_the_folder_with_its_own_environment(tmp_path: Path) -> None:
    _run(tmp_path, "import os, pathlib; pathlib.Path('here').write_text(os.environ['OWN'])")
    assert (tmp_path / "here").read_text() == "1"


def test_a_command_that_hangs_is_ended_with_all_that_it_started(tmp_path: Path) -> None:
    program = """
import pathlib, subprocess, sys, time
deaf = "import signal, time; signal.signal(15, signal.SIG_IGN); time.sleep(60)"
child = subprocess.Popen([sys.executable, "-c", deaf])
pathlib.Path("child").write_text(str(child.pid))
print("waiting for the simulator", flush=True)
time.sleep(60)
"""
    began = time.monotonic()
    with pytest.raises(CommandError, match=r"ran longer than 1 s; it said last: waiting for the simulator"):
        _run(tmp_path, program, 1.0)
    assert time.monotonic() - began < 15.0
    child = int((tmp_path / "child").read_text())
    assert soon(lambda: not alive(child), within_s=5.0)


@pytest.mark.parametrize(
    ("program", "said"),
    [
        ("print('no map'); raise SystemExit(3)", "ended with code 3; it said last: no map"),
        ("import os; os.kill(os.getpid(), 9)", "was ended by SIGKILL; it said last: nothing"),
        ("raise ValueError('odd')", "it said last: .*ValueError: odd"),
        (r"print('x' * 10**5 + '\x1b[2J'); raise SystemExit(1)", "it said last: x{300}$"),
    ],
)
def test_a_command_that_fails_says_its_last_lines(program: str, said: str, tmp_path: Path) -> None:
    with pytest.raises(CommandError, match=said):
        _run(tmp_path, program)


def test_a_flood_of_output_is_read_and_dropped(tmp_path: Path) -> None:
    program = "import sys\nfor _ in range(2000): sys.stdout.write('y' * 10000 + '\\n')\nprint('{\"altered\": 1}')"
    assert _run(tmp_path, program).altered == 1


def test_a_missing_program_is_one_sentence(tmp_path: Path) -> None:
    with pytest.raises(BorderError, match="no-such-program cannot be started: No such file"):
        run_command(["no-such-program"], {}, tmp_path, 5.0, tmp_path)


@pytest.mark.parametrize(
    "last", ['{"altered": -1}', '{"altered": true}', '{"carried": 1.5}', '{"first_altered_s": "a"}']
)
def test_a_wrong_count_is_refused(last: str) -> None:
    with pytest.raises(CommandError, match="the last line says"):
        told(last)


@pytest.mark.parametrize("last", ["", "{", "[1]", "{" * 100_000])
def test_what_is_no_object_says_nothing(last: str) -> None:
    assert told(last) == Told()
