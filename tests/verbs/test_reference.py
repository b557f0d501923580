from __future__ import annotations

import pytest

from scaloft_fi.cli import GROUPS, VERBS, command_of
from scaloft_fi.reference import command_reference
from scaloft_fi.verbs.verb import Page, Verb


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
