"""What a terminal can show: how wide it is, and whether it gets colours."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from enum import StrEnum
from typing import TextIO

PIPED = 100
"""Width of a text that goes to no terminal [characters]."""
LEAST = 40
"""Texts are laid out for no less than this [characters]."""
PROSE = 100
"""Sentences are no longer than this on a wider terminal [characters]."""


class Style(StrEnum):
    """A way to mark a text on a terminal, as the number that ANSI has for it.  A style never says what no word says."""

    STRONG = "1"
    BAD = "31"
    GOOD = "32"
    DOUBT = "33"
    COMMAND = "36"


class Marked(str):
    """A text with the marks of styles; every text that came from elsewhere was made printable before."""

    __slots__ = ()


def width() -> int:
    """How wide texts may be: $COLUMNS, else the width of the terminal, else `PIPED` [characters]."""
    told = os.environ.get("COLUMNS", "")
    columns = int(told) if told.isdecimal() and len(told) < 5 else 0
    if not columns:
        try:
            columns = os.get_terminal_size(sys.stdout.fileno()).columns
        except (OSError, ValueError):  # ValueError: the stream has no descriptor
            columns = 0
    return max(LEAST, columns) if columns else PIPED


def coloured(stream: TextIO | None = None) -> bool:
    """Whether a stream gets colours; standard output when None.

    $NO_COLOR forbids them (https://no-color.org), $FORCE_COLOR and $CLICOLOR_FORCE demand them even where no terminal
    is; else a terminal gets them that is not dumb.
    """
    said = os.environ.get
    if said("NO_COLOR"):
        return False
    if any(said(name, "0") not in ("", "0") for name in ("FORCE_COLOR", "CLICOLOR_FORCE")):
        return True
    return (stream or sys.stdout).isatty() and said("TERM") != "dumb" and said("CLICOLOR") != "0"


def styled(text: str, style: Style) -> str:
    r"""The text with the marks of a style.

    >>> styled("killed", Style.BAD)
    '\x1b[31mkilled\x1b[0m'
    """
    return f"\x1b[{style}m{text}\x1b[0m" if text else text


def joined(texts: Sequence[str]) -> str:
    """Texts below each other; marked if any of them is, and then the others must be printable."""
    text = "\n".join(texts)
    return Marked(text) if any(isinstance(each, Marked) for each in texts) else text
