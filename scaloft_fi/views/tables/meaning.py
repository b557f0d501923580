"""The colours of words that a reader looks for: what is well, what is not, what is not known.  The words say it too."""

from __future__ import annotations

import re

from scaloft_fi.console import Style, styled

_GOOD = ("detected", "held", "steady", "accepted")
_BAD = ("not detected", "violated", "red", "invalid", "expired", "uncovered")
_DOUBT = ("undecided", "not tested", "unsteady", "vacuous", "open", "stale", "untested")
_STYLES = {
    word: style for words, style in ((_GOOD, Style.GOOD), (_BAD, Style.BAD), (_DOUBT, Style.DOUBT)) for word in words
}
_FIRST = re.compile(rf"({'|'.join(sorted(_STYLES, key=len, reverse=True))})(?=$|[,;:]| at | in )", re.IGNORECASE)
_COMMAND = re.compile(r"`[^`\n]+`")


def style_of(text: str) -> Style | None:
    """The style of a text that is, or begins with, a word with a meaning; None for any other text.

    >>> style_of("Not detected"), style_of("violated at 8.10 s"), style_of("redrawn")
    (<Style.BAD: '31'>, <Style.BAD: '31'>, None)
    """
    found = _FIRST.match(text)
    return _STYLES[found[1].lower()] if found else None


def commands(text: str, *, marked: bool) -> str:
    """The text with its commands, which stand between backticks, marked if wanted."""
    return _COMMAND.sub(lambda command: styled(command[0], Style.COMMAND), text) if marked else text
