"""Texts broken into lines between words: never within an id or a path, a command that fits a line, or before a `%`."""

from __future__ import annotations

import re
from textwrap import wrap

_COMMAND = re.compile(r"`[^`\n]+`")
_BLANK = "\x00"
"""Stands for a blank at which no line may end; no printable text holds it."""


_PERCENT = re.compile(r"(?<=\d) (?=%)")


def kept_together(text: str) -> str:
    """The text with a sign that is no blank before each `%`, so that it stays beside its number."""
    return _PERCENT.sub(_BLANK, text)


def broken(text: str, width: int, first: str = "", rest: str = "") -> list[str]:
    """The lines of a text; the arguments are those of `wrapped`, which keeps commands whole, too.

    >>> broken("8/32 = 25 %", 10)
    ['8/32 =', '25 %']
    """
    lines = wrap(
        kept_together(text),
        width,
        initial_indent=first,
        subsequent_indent=rest,
        break_on_hyphens=False,
        break_long_words=False,
    )
    return [line.replace(_BLANK, " ") for line in lines]


def wrapped(text: str, width: int, first: str = "", rest: str = "") -> str:
    """The text in lines of `width` characters; a word that is longer keeps a line of its own.

    Args:
        text: of one paragraph; a command stands between backticks.
        width: of the lines with their indent [characters].
        first: stands before the first line.
        rest: stands before each other line.

    >>> print(wrapped("fly it again: `scaloft-fi replay NO-depth@3s/T0/0`", 40))
    fly it again:
    `scaloft-fi replay NO-depth@3s/T0/0`
    """
    room = width - max(len(first), len(rest))

    def held(command: re.Match[str]) -> str:
        return command[0].replace(" ", _BLANK) if len(command[0]) <= room else command[0]

    return "\n".join(broken(_COMMAND.sub(held, text), width, first, rest))
