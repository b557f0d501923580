"""Errors, one class per exit code, and the exit codes.  Each message is one sentence that says what to change."""

from __future__ import annotations

import difflib
from collections.abc import Callable, Iterable, Sequence
from enum import IntEnum
from importlib import import_module
from itertools import islice
from typing import Any, ParamSpec

P = ParamSpec("P")


class ExitCode(IntEnum):
    """How a verb ended; `meaning` says it in a sentence.

    >>> ExitCode.BAD_INPUT.value, ExitCode(3).name
    (2, 'BELOW')
    """

    DONE = 0
    BAD_INPUT = 2
    BELOW = 3
    GATE = 4
    INTERNAL = 70
    INTERRUPTED = 130

    @property
    def meaning(self) -> str:
        """What the code means, in a sentence."""
        return _MEANINGS[self]


_MEANINGS = {
    ExitCode.DONE: "The verb did what was asked; violations, survivors and red baselines are results, not failures.",
    ExitCode.BAD_INPUT: "An option, a file or the environment was refused: one sentence on standard error says where, "
    "what is allowed and what to change; no result was written.",
    ExitCode.BELOW: "The score is below `--fail-under`, `--fail-on-lost` found a fault that is lost, or `--ratchet` "
    "found a survivor that nobody accepted or an acceptance that has expired.",
    ExitCode.GATE: "A gate failed, so the campaign gives no valid score: PLACEBO or a repeated flight differs, a "
    "control shows nothing, the stack raises in a baseline, a baseline never leaves the ground, no pair of a flown "
    "situation is steady, or the harness failed in too many flights.",
    ExitCode.INTERNAL: "An error of scaloft-fi or of a plugin, whatever was typed; SCALOFT_DEBUG=1 shows where.",
    ExitCode.INTERRUPTED: "Ctrl-C or a signal ended the verb; flights that had ended are saved, and the same command "
    "resumes.",
}


_LONGEST_SENTENCE = 1_600


class ScaloftError(Exception):
    """Base class of the errors that this package raises."""

    exit_code = 70

    def __str__(self) -> str:
        """The sentence; one that quotes pages of input is shortened in the middle."""
        text = super().__str__()
        return text if len(text) <= _LONGEST_SENTENCE else f"{text[: _LONGEST_SENTENCE // 2]} [...] {text[-200:]}"


class DeclaredError(ScaloftError):
    """What somebody declared does not do what it declares.  declared_in: the module that declares it."""

    def __init__(self, sentence: str, declared_in: str = "") -> None:
        super().__init__(sentence)
        self.declared_in = declared_in


class InputError(ScaloftError):
    """The user's input is invalid; the message gives place, name=value, allowed values, the nearest valid name."""

    exit_code = 2


class FaultsError(InputError):
    """A document has several faults; the message tells the first.  faults: all of them, in the document's order."""

    def __init__(self, faults: Sequence[InputError]) -> None:
        more = len(faults) - 1
        super().__init__(f"{faults[0]} (and {more} more fault{'s' * (more > 1)}: `scaloft-fi check`)")
        self.faults = tuple(faults)


class GateError(ScaloftError):
    """A gate failed, so the campaign gives no valid score.

    PLACEBO or a repeated flight differs, too many flights are invalid, a control survives, no baseline is green, or in
    a baseline the stack raises or the drone never leaves the ground.
    """

    exit_code = 4


class Faults:
    """Collects what is wrong with a document, so that one reading tells all of it."""

    def __init__(self) -> None:
        self._found: dict[str, InputError] = {}

    def __bool__(self) -> bool:
        """Whether something is wrong."""
        return bool(self._found)

    def collecting(self) -> Faults:
        """As `with faults.collecting():` keep the error that ends the block."""
        return self

    def __enter__(self) -> None:
        """Begin a block."""

    def __exit__(self, _kind: object, error: BaseException | None, _trace: object) -> bool:
        """Keep the error of the block."""
        if isinstance(error, InputError):
            self.add(error)
        return isinstance(error, InputError)

    def add(self, *errors: InputError) -> None:
        """Keep errors, the same sentence once."""
        for error in errors:
            for fault in error.faults if isinstance(error, FaultsError) else (error,):
                self._found.setdefault(str(fault), fault)

    def end(self) -> None:
        """Raise what was kept, if anything.

        Raises:
            InputError: the one fault, or a `FaultsError` of several.
        """
        found = tuple(self._found.values())
        if found:
            raise FaultsError(found) if len(found) > 1 else found[0]


def needed(module: str, needs: str, extra: str) -> Any:
    """A module of an extra of this package.

    Args:
        module: its name.
        needs: what needs which package, as the refusal begins.
        extra: the extra that brings it.

    Raises:
        InputError: it is not installed.
    """
    try:
        return import_module(module)
    except ImportError as error:
        raise InputError(f"{needs}: pip install 'scaloft-fi[{extra}]'") from error


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


def refused(work: Callable[P, object], *args: P.args, **named: P.kwargs) -> InputError | None:
    """Call a function: the error with which it refuses its arguments, or None."""
    try:
        work(*args, **named)
    except InputError as error:
        return error
    return None


def did_you_mean(name: str, allowed: Iterable[str]) -> str:
    """The hint after an unknown name: the nearest allowed name, else all allowed names if they are few.

    >>> did_you_mean("LATE-humna", ["LATE-human", "MORE-goal"])
    "; did you mean 'LATE-human'?"
    >>> did_you_mean("zzz", ["a", "b"])
    "; allowed: 'a', 'b'"
    """
    names = list(islice(map(str, allowed), _MOST_NAMES))
    if not (hint := nearest(name, names)) and 0 < len(names) <= 24:
        return "; allowed: " + ", ".join(map(repr, sorted(names)))
    return hint


def nearest(name: str, known: Iterable[str]) -> str:
    """The hint at the nearest name that is known; nothing where none is near.

    >>> nearest("velcmt", ["velcmd", "human"]), nearest("zzz", ["velcmd"])
    ("; did you mean 'velcmd'?", '')
    """
    names = sorted(islice(map(str, known), _MOST_NAMES))
    near = difflib.get_close_matches(str(name)[:_LONGEST_NAME], names, n=1, cutoff=0.5)
    return f"; did you mean {near[0]!r}?" if near else ""
