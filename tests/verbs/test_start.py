from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import Result

Call = Callable[..., Result]
STUDY = Path(__file__).parents[2]

PROGRAM = """
import sys
from scaloft_fi.cli import main
try:
    main(sys.argv[1:])
except SystemExit as done:
    assert done.code == 0, done.code
heavy = {"numba", "pybullet", "filterpy", "distributed", "scipy"}
assert not heavy & set(sys.modules), heavy & set(sys.modules)
"""
VERBS = {
    "score": (),
    "status": (),
    "coverage": (),
    "kills": (),
    "worksheet": (),
    "dispositions": (),
    "export": ("--format", "csv"),
    "report": ("--output", "report.html"),
}


@pytest.fixture
def flown(call: Call) -> Call:
    assert call("run", "--mutant", "LATE-human", "--situation", "T0O0W0D0H?", "--quiet").exit_code == 0
    return call


@pytest.mark.parametrize("verb", VERBS)
def test_who_reads_results_waits_for_no_compiler(flown: Call, tmp_path: Path, verb: str) -> None:
    where = ["--study", str(STUDY), "--campaign", f"{tmp_path}/campaign"]
    words = [sys.executable, "-c", PROGRAM, verb, *VERBS[verb], *where]
    done = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
