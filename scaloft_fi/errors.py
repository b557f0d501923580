"""Errors, one class per exit code.  Every message is one sentence that tells the user what to change."""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from itertools import islice

_LONGEST_SENTENCE = 1_600


class ScaloftError(Exception):
    """Base class of the errors that this package raises."""

    exit_code = 70

    def __str__(self) -> str:
        """The sentence; one that quotes pages of input is shortened in the middle."""
        text = super().__str__()
        return text if len(text) <= _LONGEST_SENTENCE else f"{text[: _LONGEST_SENTENCE // 2]} [...] {text[-200:]}"


class InputError(ScaloftError):
    """The user's input is invalid; the message gives place, name=value, allowed values, the nearest valid name."""

    exit_code = 2


class GateError(ScaloftError):
    """A gate failed, so the campaign gives no valid score.

    PLACEBO or a repeated flight differs, too many flights are invalid, a control survives, no baseline is green, or in
    a baseline the stack raises or the drone never leaves the ground.
    """

    exit_code = 4


_MOST_NAMES, _LONGEST_NAME = 2_000, 200
"""What the search for a near name compares at most; its time grows with the square of the length."""
_LONGEST_SHOWN = 80


def shown(value: object) -> str:
    """A value of the user as a message shows it: `repr`, shortened in the middle.

    >>> shown("x" * 100)
    "'xxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxx...xxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxx'"
    """
    text = repr(value)
    half = (_LONGEST_SHOWN - 3) // 2
    return text if len(text) <= _LONGEST_SHOWN else f"{text[: half + 1]}...{text[-half:]}"


def did_you_mean(name: str, allowed: Iterable[str]) -> str:
    """The hint after an unknown name: the nearest allowed name, else all allowed names if they are few.

    >>> did_you_mean("LATE-humna", ["LATE-human", "MORE-goal"])
    "; did you mean 'LATE-human'?"
    >>> did_you_mean("zzz", ["a", "b"])
    "; allowed: 'a', 'b'"
    """
    names = sorted(islice(map(str, allowed), _MOST_NAMES))
    near = difflib.get_close_matches(str(name)[:_LONGEST_NAME], names, n=1, cutoff=0.5)
    if near:
        return f"; did you mean {near[0]!r}?"
    if 0 < len(names) <= 24:
        return "; allowed: " + ", ".join(map(repr, names))
    return ""
