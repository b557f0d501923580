"""Where a signal stands in a record, and the values that were found there."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from scaloft_fi.errors import InputError, did_you_mean
from scaloft_fi.stack.messages import Array

MOST_MESSAGES = 5_000_000
"""Most messages, or rows, of a record that are read."""


@dataclass(frozen=True)
class Source:
    """Where a signal stands.

    Attributes:
        signal: name of the signal, for errors.
        column: of a table; "" where the signal stands in no table.
        topic, field: of a record with topics; a field may have parts and places, "pose.position.x", "q[0]".
    """

    signal: str
    column: str = ""
    topic: str = ""
    field: str = ""


@dataclass(frozen=True)
class Timing:
    """Which time the values of a record have.

    Attributes:
        column: of a table, with the time.
        unit_s: length of the unit of that column [s].
        stamped: whether a message has the time of its header's stamp; otherwise the time at which it was received.
        clock: topic with the simulated time; a received message has the last time that was told there.
    """

    column: str = ""
    unit_s: float = 1.0
    stamped: bool = False
    clock: str = ""


@dataclass(frozen=True, eq=False)
class Series:
    """The values of a signal.  times_s: (N,) [s], never decreasing; values: (N,), each finite."""

    times_s: Array
    values: Array


def lacks(path: Path, source: Source, noun: str, name: str, there: Iterable[str]) -> InputError:
    """The error for a record without the `noun` (a column, topic or field) of a signal."""
    hint = did_you_mean(name, there)
    return InputError(
        f"{path}: signal {source.signal!r} needs the {noun} {name!r}, which the record does not have{hint}"
    )


def number(path: Path, source: Source, place: str, value: Any) -> float:
    """A value of a record as a number.

    Raises:
        InputError: it is no number, or not finite; the message names `place`.
    """
    try:
        if isinstance(value, str | bytes):
            raise TypeError
        plain = float(value)
    except (TypeError, ValueError, OverflowError):
        kind = type(value).__name__
        raise InputError(f"{path}: {place}: signal {source.signal!r} must be a number, and is of type {kind}") from None
    if not math.isfinite(plain):
        raise InputError(f"{path}: {place}: signal {source.signal!r} must be a finite number, and is {plain}")
    return plain


def too_many(path: Path) -> InputError:
    """The error for a record that is too long."""
    return InputError(f"{path}: the record must have at most {MOST_MESSAGES:,} messages or rows")


def damaged(path: Path, error: Exception) -> InputError:
    """The error for a record that its library cannot read."""
    said = " ".join(str(error).split()) or type(error).__name__
    return InputError(f"{path}: the record is damaged or incomplete: {said}")


_PART = re.compile(r"([A-Za-z_]\w*)((?:\[\d+\])*)")


def steps(field: str) -> tuple[str | int, ...] | None:
    """The names and places on the way to a field; None where `field` is not written so.

    >>> steps("pose.covariance[3]")
    ('pose', 'covariance', 3)
    """
    way: list[str | int] = []
    for part in field.split("."):
        found = _PART.fullmatch(part)
        if found is None:
            return None
        way += [found[1], *map(int, re.findall(r"\d+", found[2]))]
    return tuple(way)
