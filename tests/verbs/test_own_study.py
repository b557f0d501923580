"""Which study a verb uses when the user names none, and what it never writes into."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest

from scaloft_fi.cli import main

STUDY = Path(__file__).parents[2]
SAYS = f"study: {STUDY}, the reference study of this installation; there is none here: make a study of your own with"


def run(*args: str | Path) -> int:
    with pytest.raises(SystemExit) as left:
        main([*map(str, args)])
    assert isinstance(left.value.code, int)
    return left.value.code


@pytest.mark.parametrize("verb", [("matrix", "--format", "json"), ("mutants", "LATE-human", "--format", "json")])
def test_outside_a_study_one_line_on_standard_error_says_which_study_is_used(
    verb: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert run(*verb) == 0
    told = capsys.readouterr()
    assert told.err.startswith(SAYS)
    assert told.err.count("\n") == 1
    assert json.loads(told.out)


def test_a_study_that_is_named_or_near_is_not_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(STUDY / "sim")
    assert run("mutants", "LATE-human") == 0
    monkeypatch.chdir(tmp_path)
    assert run("mutants", "LATE-human", "--study", STUDY) == 0
    assert capsys.readouterr().err == ""


def test_a_quiet_verb_does_not_say_which_study_it_uses(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert run("run", "--mutant", "LATE-humna", "--quiet") == 2
    assert "study: " not in capsys.readouterr().err


WRITING = {
    "mutants": (("--write",), "mutants/catalogue.jsonl"),
    "dispositions": (("--write",), "hazop/dispositions.yaml"),
    "seek": (("LATE-human", "--quiet"), "sim/found.yaml"),
}
"""The verbs that write into a study, and which file."""


@pytest.mark.parametrize("verb", WRITING)
def test_a_study_that_the_user_neither_named_nor_stands_in_is_not_written(
    verb: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    options, path = WRITING[verb]
    before = {
        file: file.stat().st_mtime_ns for name in ("hazop", "mutants", "sim") for file in (STUDY / name).rglob("*")
    }
    assert run(verb, *options) == 2
    sentence = capsys.readouterr().err.splitlines()[-1]
    assert sentence.startswith(f"error: {STUDY / path} belongs to the reference study of this installation")
    assert sentence.endswith("make a study of your own with `scaloft-fi new DIR`, or name one with --study")
    after = {
        file: file.stat().st_mtime_ns for name in ("hazop", "mutants", "sim") for file in (STUDY / name).rglob("*")
    }
    assert after == before


@pytest.mark.parametrize("verb", WRITING)
def test_the_study_inside_the_package_is_not_written_even_by_name(
    verb: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for name in ("hazop", "mutants", "sim"):
        shutil.copytree(STUDY / name, tmp_path / "_study" / name)
    monkeypatch.setattr("scaloft_fi.study.PACKAGE", tmp_path)
    options, path = WRITING[verb]
    assert run(verb, *options, "--study", tmp_path / "_study") == 2
    assert f"{tmp_path / '_study' / path} belongs to the reference study" in capsys.readouterr().err
