"""The reference of all verbs in Markdown, made of their declarations."""

from __future__ import annotations

import re
from inspect import cleandoc

import click

from scaloft_fi.cli.verb import Verb
from scaloft_fi.cli.verbs import GROUPS, command_of

_ACTIVE = re.compile(r"([\\*_\[\]<>|])")
PROGRAM = "scaloft-fi"


def command_reference() -> str:
    """A heading of level 2 for each group of verbs, and below it for each verb its usage, help, options and examples.

    Every verb's file is imported.
    """
    parts = []
    for heading, verbs in GROUPS.items():
        parts += [f"## {heading}", *(_page(verb) for verb in verbs)]
    return "\n\n".join(parts) + "\n"


def _page(name: str) -> str:
    command = command_of(name)
    assert isinstance(command, Verb)
    context = click.Context(command, info_name=f"{PROGRAM} {name}", help_option_names=["-h", "--help"])
    usage = " ".join([PROGRAM, name, *command.collect_usage_pieces(context)])
    parts = [f"### `{PROGRAM} {name}`", f"```\n{usage}\n```", *_paragraphs(command.help or "")]
    for heading, rows in command.sections(context):
        listed = "\n".join(f"- `{names}`: {_literal(' '.join(meaning.split()))}" for names, meaning in rows)
        parts += [f"**{heading}**", listed]
    parts.append("**Examples**")
    parts += [f"{_literal(example.does)}:\n\n```\n{example.command}\n```" for example in command.examples]
    return "\n\n".join(parts)


def _paragraphs(text: str) -> list[str]:
    return [_literal(" ".join(paragraph.split())) for paragraph in cleandoc(text).split("\n\n")]


def _literal(text: str) -> str:
    """The text outside of backticks as Markdown shows it unchanged."""
    pieces = text.split("`")
    return "`".join(_ACTIVE.sub(r"\\\1", piece) if at % 2 == 0 else piece for at, piece in enumerate(pieces))
