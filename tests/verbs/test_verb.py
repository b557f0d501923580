"""What each verb declares: examples, options, sections, help, its part of the reference."""

from __future__ import annotations

import re
import shlex
from pathlib import Path
from typing import Annotated

import click
import pytest

from scaloft_fi.cli import GROUPS, VERBS, command_of, main
from scaloft_fi.mutants.catalogue import select
from scaloft_fi.reference import command_reference
from scaloft_fi.study import Study
from scaloft_fi.verbs.options import REST, HelpPage, Option, Page, Verb, verb

ROOT = Path(__file__).parents[2]
MANY = 10
"""A verb with more options than this groups them."""


@pytest.fixture(scope="module")
def study() -> Study:
    return Study.open(ROOT)


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
def test_each_verb_has_three_examples_or_four_and_each_is_a_command_that_it_takes(name: str) -> None:
    command = _command(name)
    assert len(command.examples) in (3, 4)
    for example in command.examples:
        program, called, *words = shlex.split(example.command)
        assert (program, called) == ("scaloft-fi", name)
        _parsed(command, words)
        assert not example.does.endswith((".", ":"))


def test_an_example_with_an_unknown_option_is_refused() -> None:
    with pytest.raises(click.UsageError, match="--mutants"):
        _parsed(_command("run"), ["--mutants", "LATE-human"])


@pytest.mark.parametrize("name", VERBS)
def test_mutants_and_situations_of_examples_are_in_the_reference_study(name: str, study: Study) -> None:
    for example in _command(name).examples:
        values = _parsed(_command(name), shlex.split(example.command)[2:]).params
        situations = values.get("situations") or values.get("situation") or ()
        study.grid.select([situations] if isinstance(situations, str) else situations)
        for text in values.get("mutants", ()):
            assert text == "baseline" or select([text], study.matrix, study.catalogue)


@pytest.mark.parametrize("name", VERBS)
def test_a_verb_of_many_options_has_each_in_a_section(name: str) -> None:
    sections = dict(_command(name).sections(_page(name)))
    if sum(names.startswith("-") for rows in sections.values() for names, _ in rows) > MANY:
        assert len(sections) > 1
        assert REST not in sections


@pytest.mark.parametrize("name", VERBS)
def test_help_fits_the_terminal_and_breaks_no_option(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
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


def test_headings_and_commands_of_help_are_marked_only_where_colours_are_wanted(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    @verb("fly", examples=(("Fly", "scaloft-fi fly"),) * 3)
    def fly() -> None:
        """Fly."""

    monkeypatch.delenv("NO_COLOR", raising=False)
    plain = fly.get_help(Page(fly, info_name="fly"))
    monkeypatch.setenv("FORCE_COLOR", "1")
    marked = fly.get_help(Page(fly, info_name="fly"))
    assert "\x1b" not in plain
    assert click.unstyle(marked) == plain
    assert "\x1b[1mExamples:\x1b[0m" in marked


def test_an_option_that_no_section_names_comes_last() -> None:
    @verb("fly", examples=(), sections={"Where": "--study"})
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


@pytest.fixture(scope="module")
def reference() -> str:
    return command_reference()


def test_every_group_and_verb_has_a_heading_in_their_order(reference: str) -> None:
    headings = [line for line in reference.splitlines() if line.startswith("#")]
    wanted = [
        title for group, verbs in GROUPS.items() for title in (group, *(f"`scaloft-fi {verb}`" for verb in verbs))
    ]
    assert [heading.lstrip("# ") for heading in headings] == wanted


@pytest.mark.parametrize("name", VERBS)
def test_every_option_and_example_of_a_verb_stands_in_its_part(name: str, reference: str) -> None:
    command = command_of(name)
    assert isinstance(command, Verb)
    part = reference.split(f"### `scaloft-fi {name}`\n")[1].split("\n#")[0]
    for heading, rows in command.sections(Page(command, info_name=name, help_option_names=["-h", "--help"])):
        assert f"**{heading}**" in part
        for names, _ in rows:
            assert f"- `{names}`: " in part
    for example in command.examples:
        assert f"\n{example.command}\n" in part


def test_marks_of_markdown_in_a_help_are_literal(reference: str) -> None:
    assert r"a pattern with \*, ? or \[ over names and ids" in reference
