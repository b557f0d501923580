"""The example of one's own tests: from a folder with tests to their score, with one file and no change of a test."""

from __future__ import annotations

import contextlib
import io
import shutil
from pathlib import Path

import pytest
from printed import of_form, run
from processes import ROOT

EXAMPLE = ROOT / "examples" / "own_tests"
SHOWN, WITHOUT_EFFECT = "NO-goal", "NO-human@100%"
"""A drone that never reaches its goal misses its mission; nobody is there whom it could see too late."""


def test_the_suite_is_one_file_of_at_most_25_lines():
    assert len((EXAMPLE / "suite.yaml").read_text().splitlines()) <= 25


@pytest.mark.release
@pytest.mark.flight
def test_the_tests_show_the_fault_of_their_mission_and_not_one_of_a_person_who_is_not_there(tmp_path: Path):
    shutil.copytree(EXAMPLE, tmp_path / "own")
    words = ("--study", ROOT, "--campaign", tmp_path / "flown", "--quiet", "--jobs", "2", "--format", "json")
    faults = ("--mutant", SHOWN, "--mutant", WITHOUT_EFFECT)
    with contextlib.redirect_stdout(io.StringIO()) as out:
        assert run("suite", tmp_path / "own" / "suite.yaml", *words, *faults) == 0
    told = of_form("suite", out.getvalue())
    tests = {one["test"]: one for one in told["tests"]}
    assert {one["state"] for one in tests.values()} == {"steady"}
    assert tests["test_mission::test_mission"]["shows"] == [SHOWN]
    assert not any(WITHOUT_EFFECT in one["shows"] for one in tests.values())
