"""Sentences broken into lines between words: never within an id or a path, nor within a command that fits a line."""

from __future__ import annotations

import re
from textwrap import wrap

_COMMAND = re.compile(r"`[^`\n]+`")
_BLANK = "\x00"
"""Stands for a blank at which no line may end; no printable text holds it."""


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

    lines = wrap(
        _COMMAND.sub(held, text),
        width,
        initial_indent=first,
        subsequent_indent=rest,
        break_on_hyphens=False,
        break_long_words=False,
    )
    return "\n".join(lines).replace(_BLANK, " ")
