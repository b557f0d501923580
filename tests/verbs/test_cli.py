"""The command line: verbs, errors, exit codes, and which study a verb uses and never writes into."""

from __future__ import annotations

import json
import shutil
import sys
from pathlib import Path

import click
import pytest
from click.testing import CliRunner
from refusal import run

from scaloft_fi.cli import GROUPS, Pipeline, main
from scaloft_fi.defaults import __version__
from scaloft_fi.errors import GateError, InputError, ScaloftError
from scaloft_fi.verbs.options import typed

ROOT = Path(__file__).parents[2]


def _call(*words: str) -> tuple[int, str, str]:
    result = CliRunner().invoke(main, list(words), catch_exceptions=False)
    return result.exit_code, result.stdout, result.stderr


def _verb(monkeypatch: pytest.MonkeyPatch, raising: BaseException) -> None:
    def fail() -> None:
        raise raising

    command = click.Command("matrix", callback=fail)
    monkeypatch.setattr(Pipeline, "get_command", lambda *_: command)


def test_the_version_is_told() -> None:
    assert _call("--version") == (0, f"scaloft-fi {__version__}\n", "")


@pytest.mark.parametrize("words", [(), ("--help",), ("-h",)])
def test_help_lists_the_groups_and_their_verbs_in_order(words: tuple[str, ...]) -> None:
    code, out, _ = _call(*words)
    told = [name for heading, verbs in GROUPS.items() for name in (f"{heading}:", *(f"  {verb} " for verb in verbs))]
    places = [out.index(f"\n{name}", out.index(next(iter(GROUPS))) - 1) for name in told]
    assert code == 0
    assert places == sorted(places)


def test_a_study_that_is_named_like_an_argument_is_told_its_option(tmp_path: Path) -> None:
    code, _, err = _call("check", str(tmp_path))
    assert code == 2
    assert f"unexpected extra argument ({tmp_path}); a study is named by --study {tmp_path}; see" in err


@pytest.mark.parametrize(
    ("raised", "code", "said"),
    [
        (InputError("a:1: b=2 must be 3"), 2, "error: a:1: b=2 must be 3\n"),
        (GateError("PLACEBO differs"), 4, "error: PLACEBO differs\n"),
        (ScaloftError("lost"), 70, "error: lost\n"),
        (KeyboardInterrupt(), 130, "\nerror: interrupted\n"),
        (ValueError("odd\nvalue"), 70, "error: internal error: ValueError: odd value (SCALOFT_DEBUG=1 shows where)\n"),
    ],
)
def test_an_error_is_one_sentence_and_an_exit_code(
    monkeypatch: pytest.MonkeyPatch, raised: BaseException, code: int, said: str
) -> None:
    monkeypatch.delenv("SCALOFT_DEBUG", raising=False)
    _verb(monkeypatch, raised)
    assert _call("matrix") == (code, "", said)


def test_debugging_shows_where(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SCALOFT_DEBUG", "1")
    _verb(monkeypatch, ValueError("odd"))
    code, _, err = _call("matrix")
    assert code == 70
    assert "Traceback" in err


STUDY = Path(__file__).parents[2]
SAYS = f"study: {STUDY}, the reference study of this installation; there is none here: make a study of your own with"


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


@pytest.mark.parametrize(
    ("argv", "said"),
    [
        (["/venv/bin/scaloft-fi", "run", "--mutant", "LATE-human*"], "scaloft-fi run --mutant 'LATE-human*'"),
        (["/package/__main__.py", "margin", "LATE-human"], "python -m scaloft_fi margin LATE-human"),
    ],
)
def test_what_was_typed_is_told_as_a_shell_takes_it(
    argv: list[str], said: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "argv", argv)
    assert typed() == said
