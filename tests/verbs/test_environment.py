"""Whatever the environment refuses, the command ends with the right code and at most one sentence; nothing is lost."""

from __future__ import annotations

import os
import signal
import sqlite3
import subprocess
import sys
import time
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
COMMAND = f"{sys.executable} -P -m scaloft_fi"
FLY = "run --mutant REVERSE-velcmd --situation T0O0W0D0H0 --baseline-seeds 1 --jobs 1"
ENVIRONMENT = {**os.environ, "PYTHONPATH": str(ROOT)}

NO_STUDY = "must be a folder with hazop/, mutants/ and sim/; it lacks hazop/, mutants/, sim/"
ROWS = {
    "$S matrix --study $ROOT >&-": (2, "error: standard output cannot be written: it is closed\n"),
    "$S matrix --study $ROOT >/dev/full": (2, "error: standard output cannot be written: No space left on device\n"),
    "$S matrix --study $ROOT --format json | true; exit ${PIPESTATUS[0]}": (0, ""),
    "$S matrix --study $ROOT 2>&-": (0, ""),
    "$S matrix --cell nothing 2>/dev/full": (2, ""),
    "$S matrix <&- >&- 2>&-": (2, ""),
    "mkdir gone; cd gone; rmdir ../gone; $S matrix": (
        2,
        "error: the current folder cannot be read: No such file or directory; go to another or name --study\n",
    ),
    "ulimit -v 200000; $S score": (
        2,
        "error: score: not enough memory: the limit is 204 MB of at least 320; raise it (`ulimit -v 320000`)\n",
    ),
    "$S score --study $ROOT --campaign '~nosuchuser/x'": (
        2,
        "error: --campaign: name='~nosuchuser/x' must be the path of a folder: Could not determine home directory.\n",
    ),
    "LC_ALL=C PYTHONUTF8=0 PYTHONCOERCECLOCALE=0 PYTHONIOENCODING=ascii $S matrix --study $'\\xff \\n\\e[1m'": (
        2,
        f"error: --study='\\udcff \\n\\x1b[1m' {NO_STUDY}\n",
    ),
}


def _shell(line: str, folder: Path) -> subprocess.CompletedProcess[str]:
    variables = ENVIRONMENT | {"S": COMMAND, "ROOT": str(ROOT), "LC_ALL": "C.UTF-8"}
    return subprocess.run(
        ["bash", "-c", line], cwd=folder, env=variables, capture_output=True, text=True, check=False, timeout=300
    )


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="needs bash, /dev/full and limits of Linux")
@pytest.mark.parametrize("line", ROWS)
def test_the_code_is_right_and_there_is_at_most_one_sentence(line: str, tmp_path: Path) -> None:
    done = _shell(line, tmp_path)
    assert (done.returncode, done.stderr) == ROWS[line]


def _saved(store: Path) -> int:
    """Number of outcomes in a store; 0 before it is there."""
    try:
        with sqlite3.connect(f"{store.absolute().as_uri()}?mode=ro", uri=True) as connection:
            return int(connection.execute("SELECT count(*) FROM outcomes").fetchone()[0])
    except sqlite3.OperationalError:
        return 0


@pytest.mark.flight
@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="needs bash")
def test_a_run_without_streams_in_a_campaign_of_an_odd_name_loses_no_flight(tmp_path: Path) -> None:
    campaign = tmp_path / os.fsdecode(b"-c \n\x1b[1m\xff")
    run = f"$S {FLY} --study $ROOT --campaign ./$'-c \\n\\e[1m\\xff'"
    assert _shell(f"{run} <&- >&- 2>&-", tmp_path).returncode == 2  # its tables could not be printed
    assert _saved(campaign / "outcomes.sqlite") == 3
    left = _shell(f"{run} 2>&1 | true; exit ${{PIPESTATUS[0]}}", tmp_path)
    assert (left.returncode, left.stderr) == (0, "")


@pytest.mark.flight
@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="looks into /proc")
def test_a_terminal_that_closes_interrupts_a_run_which_saves_everything_and_leaves_no_process(tmp_path: Path) -> None:
    words = [*COMMAND.split(), *FLY.split(), "--seeds", "40", "--study", str(ROOT), "--campaign", f"{tmp_path}/c"]
    run = subprocess.Popen(words, env=ENVIRONMENT, stderr=subprocess.PIPE, text=True, start_new_session=True)
    store, until_s = tmp_path / "c" / "outcomes.sqlite", time.monotonic() + 300  # kernels may have to be compiled
    while not _saved(store) and time.monotonic() < until_s:
        time.sleep(0.05)
    os.killpg(run.pid, signal.SIGHUP)
    _, told = run.communicate(timeout=300)
    saved = _saved(store)
    assert run.returncode == 130
    assert 0 < saved < 80
    assert f"error: interrupted: {saved} flights are saved in {tmp_path}/c; the same command resumes: " in told
    with pytest.raises(ProcessLookupError):
        os.killpg(run.pid, 0)
