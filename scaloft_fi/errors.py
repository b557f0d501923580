"""What can go wrong, one class per exit code.  Every message is one sentence a user can act on."""

from __future__ import annotations

import difflib
from collections.abc import Iterable


class ScaloftError(Exception):
    """Base of every error this package raises on purpose."""

    exit_code = 70


class InputError(ScaloftError):
    """The user's input cannot be used: place, name=value, what is allowed, the nearest valid name."""

    exit_code = 2


class GateError(ScaloftError):
    """A gate failed, so that no score can be believed.

    PLACEBO or a repeat differs, too many flights are invalid, a control survives, no baseline is green, or without any
    fault the stack raises or the drone never leaves the ground.
    """

    exit_code = 4


def did_you_mean(name: str, allowed: Iterable[str]) -> str:
    """The tail of a miss: the nearest allowed name, or all of them when none is near and they are few.

    >>> did_you_mean("LATE-humna", ["LATE-human", "MORE-goal"])
    "; did you mean 'LATE-human'?"
    >>> did_you_mean("zzz", ["a", "b"])
    "; allowed: 'a', 'b'"
    """
    names = sorted(map(str, allowed))
    near = difflib.get_close_matches(str(name), names, n=1, cutoff=0.5)
    if near:
        return f"; did you mean {near[0]!r}?"
    if 0 < len(names) <= 24:
        return "; allowed: " + ", ".join(map(repr, names))
    return ""
