"""The command line: verbs and what they declare, errors, which study a verb uses, what the environment refuses."""

from __future__ import annotations

import json
import os
import re
import shlex
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Annotated

import click
import pytest
from printed import STUDY, invoked, run
from processes import saved
from studies import FOLDERS, copied

from scaloft_fi.cli import Pipeline, command_of, main
from scaloft_fi.defaults import __version__
from scaloft_fi.errors import GateError, InputError, ScaloftError
from scaloft_fi.hazop.load import study_around
from scaloft_fi.mutants.catalogue import select
from scaloft_fi.output import STUDY_OPTION, WITHOUT_STUDY
from scaloft_fi.study import Study
from scaloft_fi.verbs import GROUPS, VERBS
from scaloft_fi.verbs.options import REST, HelpPage, Option, Page, Verb, typed, verb


def _call(*words: str) -> tuple[int, str, str]:
    result = invoked(*words)
    return result.exit_code, result.stdout, result.stderr


def _verb(monkeypatch: pytest.MonkeyPatch, raising: BaseException) -> None:
    def fail() -> None:
        raise raising

    command = click.Command("matrix", callback=fail)
    monkeypatch.setattr(Pipeline, "get_command", lambda *_: command)


def test_the_version_is_told():
    assert _call("--version") == (0, f"scaloft-fi {__version__}\n", "")


@pytest.mark.parametrize("words", [(), ("--help",), ("-h",)])
def test_help_lists_the_groups_and_their_verbs_in_order(words: tuple[str, ...]):
    code, out, _ = _call(*words)
    told = [name for heading, verbs in GROUPS.items() for name in (f"{heading}:", *(f"  {verb} " for verb in verbs))]
    places = [out.index(f"\n{name}", out.index(next(iter(GROUPS))) - 1) for name in told]
    assert code == 0
    assert places == sorted(places)


def test_a_study_that_is_named_like_an_argument_is_told_its_option(tmp_path: Path):
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
):
    monkeypatch.delenv("SCALOFT_DEBUG", raising=False)
    _verb(monkeypatch, raised)
    assert _call("matrix") == (code, "", said)


def test_debugging_shows_where(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("SCALOFT_DEBUG", "1")
    _verb(monkeypatch, ValueError("odd"))
    code, _, err = _call("matrix")
    assert code == 70
    assert "Traceback" in err


SAYS = f"study: {STUDY}, the reference study of this installation; there is none here: make a study of your own with"


@pytest.mark.parametrize("verb", [("matrix", "--format", "json"), ("mutants", "LATE-human", "--format", "json")])
def test_outside_a_study_one_line_on_standard_error_says_which_study_is_used(
    verb: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    monkeypatch.chdir(tmp_path)
    assert run(*verb) == 0
    told = capsys.readouterr()
    assert told.err.startswith(SAYS)
    assert told.err.count("\n") == 1
    assert json.loads(told.out)


def test_a_study_that_is_named_or_near_is_not_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    monkeypatch.chdir(STUDY / "sim")
    assert run("mutants", "LATE-human") == 0
    monkeypatch.chdir(tmp_path)
    assert run("mutants", "LATE-human", "--study", STUDY) == 0
    assert capsys.readouterr().err == ""


def test_a_quiet_verb_does_not_say_which_study_it_uses(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    monkeypatch.chdir(tmp_path)
    assert run("run", "--mutant", "LATE-humna", "--quiet") == 2
    assert "study: " not in capsys.readouterr().err


WRITING = {
    "mutants": (("--write",), "mutants/catalogue.jsonl"),
    "dispositions": (("--write",), "hazop/dispositions.yaml"),
    "seek": (("LATE-human", "--quiet"), "sim/found.yaml"),
}
"""The verbs that write into a study, and which file."""


def _changed_at() -> dict[Path, int]:
    """When each file of the reference study was changed."""
    return {file: file.stat().st_mtime_ns for name in FOLDERS for file in (STUDY / name).rglob("*")}


@pytest.mark.parametrize("verb", WRITING)
def test_a_study_that_the_user_neither_named_nor_stands_in_is_not_written(
    verb: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    monkeypatch.chdir(tmp_path)
    options, path = WRITING[verb]
    before = _changed_at()
    assert run(verb, *options) == 2
    sentence = capsys.readouterr().err.splitlines()[-1]
    assert sentence.startswith(f"error: {STUDY / path} belongs to the reference study of this installation")
    assert sentence.endswith("make a study of your own with `scaloft-fi new DIR`, or name one with --study")
    assert _changed_at() == before


@pytest.mark.parametrize("verb", WRITING)
def test_the_study_inside_the_package_is_not_written_even_by_name(
    verb: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    copied(tmp_path / "_study")
    monkeypatch.setattr("scaloft_fi.hazop.load._PACKAGE", tmp_path)
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
def test_what_was_typed_is_told_as_a_shell_takes_it(argv: list[str], said: str, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(sys, "argv", argv)
    assert typed() == said


MANY = 10
"""A verb with more options than this groups them."""


def _command(name: str) -> Verb:
    command = command_of(name)
    assert isinstance(command, Verb), f"{name} is not declared by @verb (scaloft_fi/verbs/options.py)"
    return command


def _page(name: str) -> Page:
    return Page(_command(name), info_name=name, help_option_names=["-h", "--help"])


def _parsed(command: Verb, words: list[str]) -> click.Context:
    context = main.make_context("scaloft-fi", [])
    return command.make_context(str(command.name), words, parent=context)


@pytest.mark.parametrize("name", VERBS)
def test_each_verb_has_three_examples_or_four_and_each_is_a_command_that_it_takes(name: str):
    command = _command(name)
    assert len(command.examples) in (3, 4)
    for example in command.examples:
        program, called, *words = shlex.split(example.command)
        assert (program, called) == ("scaloft-fi", name)
        _parsed(command, words)
        assert not example.does.endswith((".", ":"))


def test_an_example_with_an_unknown_option_is_refused():
    with pytest.raises(click.UsageError, match="--mutants"):
        _parsed(_command("run"), ["--mutants", "LATE-human"])


@pytest.mark.parametrize("name", VERBS)
def test_mutants_and_situations_of_examples_are_in_the_reference_study(name: str, study: Study):
    for example in _command(name).examples:
        values = _parsed(_command(name), shlex.split(example.command)[2:]).params
        situations = values.get("situations") or values.get("situation") or ()
        study.grid.select([situations] if isinstance(situations, str) else situations)
        for text in values.get("mutants", ()):
            assert text == "baseline" or select([text], study.matrix, study.catalogue)


def test_a_command_that_is_printed_names_the_study_where_its_verb_takes_one(tmp_path: Path):
    takes = {
        name for name in VERBS if any(option.name in ("study", "study_folder") for option in _command(name).params)
    }
    assert set(VERBS) - takes == set(WITHOUT_STUDY)
    folder = copied(tmp_path / "study of mine")
    named = ["--study", str(folder)]
    listed = invoked("signals", *named).stdout
    assert f"`scaloft-fi signals NAME --study '{folder}'`" in listed.replace(" \\\n", " ")
    assert f"`scaloft-fi run --study '{folder}'`" in invoked("status", *named).stderr
    assert STUDY_OPTION.get() == ""


def test_the_path_of_a_campaign_finds_its_study(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    folder = copied(tmp_path / "mine")
    campaign = folder / "results" / "campaigns" / "night"
    assert study_around(str(campaign)) == folder
    assert study_around(str(tmp_path / "results" / "campaigns" / "night")) is None
    assert study_around("night") is None
    monkeypatch.chdir(tmp_path)
    said = invoked("score", "--campaign", "mine/results/campaigns/night").stderr
    assert "the reference study of this installation" not in said
    assert "`scaloft-fi run --study mine`" in said


@pytest.mark.parametrize("name", VERBS)
def test_a_verb_of_many_options_has_each_in_a_section(name: str):
    sections = dict(_command(name).sections(_page(name)))
    if sum(names.startswith("-") for rows in sections.values() for names, _ in rows) > MANY:
        assert len(sections) > 1
        assert REST not in sections


@pytest.mark.parametrize("name", VERBS)
def test_help_fits_the_terminal_and_breaks_no_option(name: str, monkeypatch: pytest.MonkeyPatch):
    command = _command(name)
    for columns in (160, 80, 40):
        monkeypatch.setenv("COLUMNS", str(columns))
        text = command.get_help(_page(name))
        for line in text.splitlines():
            lone = len(line.split()) == 1 or line.strip() in {example.command for example in command.examples}
            assert len(line) <= min(columns, 100) or lone or re.match(r" *-", line), line
    for heading, rows in command.sections(_page(name)):
        assert f"{heading}:" in text
        for names, _ in rows:
            assert names in text


def test_headings_and_commands_of_help_are_marked_only_where_colours_are_wanted(monkeypatch: pytest.MonkeyPatch):
    @verb("fly")
    def fly() -> None:
        """Fly.

        Examples:
            Fly: `scaloft-fi fly`
            Fly again: `scaloft-fi fly --again`
        """

    monkeypatch.delenv("NO_COLOR", raising=False)
    plain = fly.get_help(Page(fly, info_name="fly"))
    monkeypatch.setenv("FORCE_COLOR", "1")
    marked = fly.get_help(Page(fly, info_name="fly"))
    assert "\x1b" not in plain
    assert click.unstyle(marked) == plain
    assert "\x1b[1mExamples:\x1b[0m" in marked


def test_an_option_that_no_section_names_comes_last():
    @verb("fly", sections={"Where": "--study"})
    def fly(
        *, fast: Annotated[bool, Option("Fast.")], study_folder: Annotated[str, Option("Here.", "--study")]
    ) -> None:
        """Fly."""

    sections = fly.sections(Page(fly, info_name="fly"))
    assert [(heading, [names for names, _ in rows]) for heading, rows in sections] == [
        ("Where", ["--study TEXT"]),
        (REST, ["--fast", "--help"]),
    ]
    assert isinstance(Page(fly, info_name="fly").make_formatter(), HelpPage)


COMMAND = f"{sys.executable} -P -m scaloft_fi"
FLY = "run --mutant REVERSE-velcmd --situation T0O0W0D0H0 --baseline-seeds 1 --jobs 1"
ENVIRONMENT = {**os.environ, "PYTHONPATH": str(STUDY)}

NO_STUDY = "must be a folder with hazop/, mutants/ and sim/; there is no such folder"
ROWS = {
    "$S matrix --study $STUDY >&-": (2, "error: standard output cannot be written: it is closed\n"),
    "$S matrix --study $STUDY >/dev/full": (2, "error: standard output cannot be written: No space left on device\n"),
    "$S matrix --study $STUDY --format json | true; exit ${PIPESTATUS[0]}": (0, ""),
    "$S matrix --study $STUDY 2>&-": (0, ""),
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
    "$S score --study $STUDY --campaign '~nosuchuser/x'": (
        2,
        "error: --campaign: name='~nosuchuser/x' must be the path of a folder: Could not determine home directory.\n",
    ),
    "LC_ALL=C PYTHONUTF8=0 PYTHONCOERCECLOCALE=0 PYTHONIOENCODING=ascii $S matrix --study $'\\xff \\n\\e[1m'": (
        2,
        f"error: --study='\\udcff \\n\\x1b[1m' {NO_STUDY}\n",
    ),
}


def _shell(line: str, folder: Path) -> subprocess.CompletedProcess[str]:
    variables = ENVIRONMENT | {"S": COMMAND, "STUDY": str(STUDY), "LC_ALL": "C.UTF-8"}
    return subprocess.run(
        ["bash", "-c", line], cwd=folder, env=variables, capture_output=True, text=True, check=False, timeout=300
    )


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="needs bash, /dev/full and limits of Linux")
@pytest.mark.parametrize("line", ROWS)
def test_the_code_is_right_and_there_is_at_most_one_sentence(line: str, tmp_path: Path):
    done = _shell(line, tmp_path)
    assert (done.returncode, done.stderr) == ROWS[line]


@pytest.mark.release
@pytest.mark.flight
@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="needs bash")
def test_a_run_without_streams_in_a_campaign_of_an_odd_name_loses_no_flight(tmp_path: Path):
    campaign = tmp_path / os.fsdecode(b"-c \n\x1b[1m\xff")
    run = f"$S {FLY} --study $STUDY --campaign ./$'-c \\n\\e[1m\\xff'"
    assert _shell(f"{run} <&- >&- 2>&-", tmp_path).returncode == 2  # its tables could not be printed
    assert saved(campaign / "outcomes.sqlite") == 3
    left = _shell(f"{run} 2>&1 | true; exit ${{PIPESTATUS[0]}}", tmp_path)
    assert (left.returncode, left.stderr) == (0, "")


@pytest.mark.flight
@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="looks into /proc")
def test_a_terminal_that_closes_interrupts_a_run_which_saves_everything_and_leaves_no_process(tmp_path: Path):
    words = [*COMMAND.split(), *FLY.split(), "--seeds", "40", "--study", str(STUDY), "--campaign", f"{tmp_path}/c"]
    run = subprocess.Popen(words, env=ENVIRONMENT, stderr=subprocess.PIPE, text=True, start_new_session=True)
    store, until_s = tmp_path / "c" / "outcomes.sqlite", time.monotonic() + 300  # kernels may have to be compiled
    while not saved(store) and time.monotonic() < until_s:
        time.sleep(0.05)
    os.killpg(run.pid, signal.SIGHUP)
    _, told = run.communicate(timeout=300)
    count = saved(store)
    assert run.returncode == 130
    assert 0 < count < 80
    assert f"error: interrupted: {count} flights are saved in {tmp_path}/c; the same command resumes: " in told
    with pytest.raises(ProcessLookupError):
        os.killpg(run.pid, 0)
