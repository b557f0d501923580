"""Which way a ladder gets worse, and where on it there is no fault: what a search for the least magnitude needs."""

from __future__ import annotations

from enum import StrEnum
from itertools import pairwise

from scaloft_fi.hazop.cell import Magnitude


class Worse(StrEnum):
    """In which direction a fault gets worse."""

    LARGER = "larger"
    SMALLER = "smaller"
    UNORDERED = "unordered"
    """Names, places in a list: no magnitude is more than another."""


def worse(magnitude: Magnitude) -> Worse:
    """What the study says, else what the ladder shows: ladders run from mild to severe.

    >>> worse(Magnitude("delay_s", "s", (0.5, 1.0), 1.0)), worse(Magnitude("axis", "", ("x", "y"), "x"))
    (<Worse.LARGER: 'larger'>, <Worse.UNORDERED: 'unordered'>)
    """
    if magnitude.worse:
        return Worse(magnitude.worse)
    numbers = [rung for rung in magnitude.ladder if not isinstance(rung, str)]
    if len(numbers) < 2 or len(numbers) < len(magnitude.ladder):
        return Worse.UNORDERED
    if all(milder < severer for milder, severer in pairwise(numbers)):
        return Worse.LARGER
    return Worse.SMALLER if all(milder > severer for milder, severer in pairwise(numbers)) else Worse.UNORDERED


def neutral(magnitude: Magnitude) -> float | None:
    """The magnitude at which nothing is wrong, and which therefore need not be flown; None where none is known.

    What the study says, else 1 of a factor (unit x), 0 of what gets worse as it grows, all of a share that shrinks.

    >>> neutral(Magnitude("delay_s", "s", (0.5, 1.0), 1.0)), neutral(Magnitude("factor", "x", (0.9, 0.5), 0.5))
    (0.0, 1.0)
    >>> neutral(Magnitude("share", "%", (90.0, 50.0), 50.0)), neutral(Magnitude("period_s", "s", (60.0, 5.0), 5.0))
    (100.0, None)
    """
    if magnitude.neutral is not None:
        return magnitude.neutral
    direction = worse(magnitude)
    if direction is Worse.UNORDERED:
        return None
    if magnitude.unit == "x":
        return 1.0
    if direction is Worse.LARGER:
        return 0.0
    return 100.0 if magnitude.unit == "%" else None


def mild_to_severe(magnitude: Magnitude) -> tuple[float, ...]:
    """The ladder from mild to severe; empty where it has no order."""
    direction = worse(magnitude)
    numbers = (rung for rung in magnitude.ladder if not isinstance(rung, str))
    return () if direction is Worse.UNORDERED else tuple(sorted(numbers, reverse=direction is Worse.SMALLER))
