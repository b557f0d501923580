"""The verb `check`: lines for people and editors, records for programs, exit codes."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import Result
from jsonschema import Draft202012Validator

from scaloft_fi.verbs.check import CHECK

Call = Callable[..., Result]


@pytest.fixture
def small(copy: Path) -> Path:
    """A copy of the reference study with its own grid alone."""
    for path in (copy / "sim" / "grids").iterdir():
        path.unlink()
    return copy


def _break(study: Path) -> None:
    world = study / "sim" / "world.yaml"
    world.write_text(world.read_text().replace("light: 0.9", "light: 5"))


def test_a_sound_study_ends_with_0_and_says_what_was_checked(call: Call, small: Path) -> None:
    done = call("check", study=small, campaign=False)
    assert done.exit_code == 0
    assert done.stdout.startswith(f"{small / 'hazop' / 'matrix'}: note: no cell of the matrix has a fault at 1 of ")
    assert "32 situations, all built with 40 pairs of values" in done.stdout
    told = " ".join(done.stdout.split())  # lines break elsewhere where a folder has a longer name
    assert "not checked: `scaloft-fi check --fly` flies once" in told
    assert f"{small}: no errors, 1 note." in told


def test_an_error_ends_with_2_and_stands_on_a_line_with_its_place_before_the_notes(call: Call, small: Path) -> None:
    _break(small)
    done = call("check", study=small, campaign=False)
    assert done.exit_code == 2
    assert done.stdout.splitlines()[0] == f"{small / 'sim' / 'world.yaml'}:3: error: light=5 must be >= 0 and <= 1"
    assert "1 error, 1 note." in done.stdout


def test_programs_get_records_of_the_published_form(call: Call, small: Path, tmp_path: Path) -> None:
    _break(small)
    done = call("check", "--format", "json", "--tables", str(tmp_path / "tables"), study=small, campaign=False)
    told = json.loads(done.stdout)
    Draft202012Validator(CHECK.schema).validate(told)
    first = told["findings"][0]
    assert (done.exit_code, told["errors"], first["severity"], first["line"]) == (2, 1, "error", 3)
    assert told["grids"][0]["built"] == 0
    assert (tmp_path / "tables" / "findings.csv").read_text().count("\n") == 3


@pytest.mark.flight
def test_a_flight_shows_which_seams_the_stack_polls(call: Call, small: Path) -> None:
    done = call("check", "--fly", "--format", "json", study=small, campaign=False)
    told = json.loads(done.stdout)
    assert (done.exit_code, told["checked"]["polled"], told["checked"]["unflown"]) == (0, 21, "")
    silent = [finding["what"] for finding in told["findings"] if "nothing was sent over" in finding["what"]]
    assert silent == ["in one baseline flight nothing was sent over person, failsafe, collision"]


def test_a_study_with_errors_is_not_flown(call: Call, small: Path) -> None:
    _break(small)
    told = json.loads(call("check", "--fly", "--format", "json", study=small, campaign=False).stdout)
    assert told["checked"]["unflown"] == "not flown, because the study has errors"
