"""`check` and `doctor`: what is wrong with a study, and with the machine."""

from __future__ import annotations

import json
from collections.abc import Callable
from importlib.metadata import EntryPoint
from pathlib import Path
from typing import Any

import pytest
from click.testing import Result
from jsonschema import Draft202012Validator
from printed import Call, of_form, told_by
from studies import edit_in

from scaloft_fi.campaign.runs.gates import published
from scaloft_fi.campaign.store.platforms import fingerprint
from scaloft_fi.errors import GateError
from scaloft_fi.verbs.check import CHECK


@pytest.fixture
def small(copy: Path) -> Path:
    """A copy of the reference study with its own grid alone."""
    for path in (copy / "sim" / "grids").iterdir():
        path.unlink()
    return copy


def _break(study: Path) -> None:
    edit_in(study / "sim" / "world.yaml", "light: 0.9", "light: 5")


def test_a_sound_study_ends_with_0_and_says_what_was_checked(call: Call, small: Path):
    done = told_by(call("check", study=small, campaign=False))
    assert done.startswith(f"{small / 'hazop' / 'matrix'}: note: no cell of the matrix has a fault at 1 of ")
    assert "32 situations, all built with 40 pairs of values" in done
    told = " ".join(done.split())  # lines break elsewhere where a folder has a longer name
    assert "not checked: `scaloft-fi check --fly` flies once" in told
    assert f"{small}: no errors, 1 note." in told


def test_an_error_ends_with_2_and_stands_on_a_line_with_its_place_before_the_notes(call: Call, small: Path):
    _break(small)
    done = call("check", study=small, campaign=False)
    assert done.exit_code == 2
    assert done.stdout.splitlines()[0] == f"{small / 'sim' / 'world.yaml'}:3: error: light=5 must be >= 0 and <= 1"
    assert "1 error, 1 note." in done.stdout


def test_programs_get_records_of_the_published_form(call: Call, small: Path, tmp_path: Path):
    _break(small)
    done = call("check", "--format", "json", "--tables", str(tmp_path / "tables"), study=small, campaign=False)
    told = json.loads(done.stdout)
    Draft202012Validator(CHECK.schema).validate(told)
    first = told["findings"][0]
    assert (done.exit_code, told["errors"], first["severity"], first["line"]) == (2, 1, "error", 3)
    assert told["grids"][0]["built"] == 0
    assert (tmp_path / "tables" / "findings.csv").read_text().count("\n") == 3


@pytest.mark.flight
def test_a_flight_shows_which_seams_the_stack_polls(call: Call, small: Path):
    done = call("check", "--fly", "--format", "json", study=small, campaign=False)
    told = json.loads(done.stdout)
    assert (done.exit_code, told["checked"]["polled"], told["checked"]["unflown"]) == (0, 21, "")
    silent = [finding["what"] for finding in told["findings"] if "nothing was sent over" in finding["what"]]
    assert silent == ["in one baseline flight nothing was sent over person, failsafe, collision"]


def test_a_study_with_errors_is_not_flown(call: Call, small: Path):
    _break(small)
    told = json.loads(call("check", "--fly", "--format", "json", study=small, campaign=False).stdout)
    assert told["checked"]["unflown"] == "not flown, because the study has errors"


@pytest.fixture
def answer(monkeypatch: pytest.MonkeyPatch) -> Callable[[Callable[[], str]], None]:
    """Replaces the known flight."""

    def become(tell: Callable[[], str]) -> None:
        monkeypatch.setattr("scaloft_fi.verbs.doctor.fly_again", lambda _say: tell())

    become(lambda: "as published")
    return become


def _told(result: Result) -> dict[str, Any]:
    return of_form("doctor", result.stdout)


def test_every_part_of_the_platform_is_told_with_whether_it_decides_bits(call: Call, answer: object):
    result = call("doctor", "--format", "json", campaign=False)
    assert result.exit_code == 0, result.output
    whole = _told(result)
    told = {row["part"]: (row["value"], row["decides_bits"]) for row in whole["platform"]}
    assert {name: value for name, (value, _) in told.items()}.items() >= fingerprint().items()
    assert {told[name][1] for name in ("numpy kernels", "OPENBLAS_CORETYPE")} == {True}
    assert told["scaloft-fi"][1] is False
    packages = {row["package"]: row for row in whole["packages"]}
    assert packages["numpy"]["version"] == fingerprint()["numpy"]
    assert packages["distributed"]["extra"] == "cluster"
    assert "pytest" not in packages
    assert (whole["study"]["mutants"], whole["study"]["situations"]) == (712, 32)
    assert 0 < whole["machine"]["memory_available_gib"] < whole["machine"]["memory_gib"]
    assert whole["known_flight"] == {"same": True, "told": "as published"}
    text = " ".join(call("doctor", campaign=False).stdout.split())
    for words in ("current, 712 mutants", "GiB available of", "be written", "as published"):
        assert words in text


def test_without_the_flight_nothing_is_flown(call: Call, answer: Callable[[Callable[[], str]], None]):
    answer(lambda: pytest.fail("it flew"))
    result = told_by(call("doctor", "--no-flight", campaign=False))
    assert "Known flight" not in result


def test_other_facts_of_the_known_flight_exit_with_4_after_the_tables(
    call: Call, answer: Callable[[Callable[[], str]], None]
):
    def fail() -> str:
        raise GateError(f"{published().name} has other facts")

    answer(fail)
    result = call("doctor", campaign=False)
    assert result.exit_code == 4
    assert "Platform" in result.stdout
    assert result.stdout.count("has other facts") == 1
    assert result.stderr == f"error: {published().name} has other facts\n"


def test_a_plugin_that_does_not_load_is_named_and_everything_else_is_told(
    call: Call, answer: object, monkeypatch: pytest.MonkeyPatch
):
    plugins = [EntryPoint("odd", "no_such_module_at_all", "g"), EntryPoint("well", "json", "g")]
    monkeypatch.setattr("scaloft_fi.verbs.doctor.entry_points", lambda **_: plugins)
    result = call("doctor", "--format", "json", campaign=False)
    assert result.exit_code == 2
    assert "plugin 'odd' of package 'no_such_module_at_all' cannot be loaded: ModuleNotFoundError" in result.stderr
    assert [(row["plugin"], row["loads"]) for row in _told(result)["plugins"]] == [("odd", False), ("well", True)]


def test_a_stale_catalogue_is_bad_input_and_everything_else_is_told(call: Call, answer: object, copy: Path):
    catalogue = copy / "mutants" / "catalogue.jsonl"
    catalogue.write_text("".join(catalogue.read_text().splitlines(keepends=True)[1:]))
    result = call("doctor", "--format", "json", study=copy, campaign=False)
    assert result.exit_code == 2
    assert "mutants --write" in result.stderr
    assert _told(result)["known_flight"]
