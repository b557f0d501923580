"""The order of a ladder of magnitudes, and its neutral magnitude: the search for a margin needs both."""

from __future__ import annotations

from enum import StrEnum
from itertools import pairwise

from scaloft_fi.hazop.cell import Magnitude


class Worse(StrEnum):
    """The direction in which a fault gets worse."""

    LARGER = "larger"
    SMALLER = "smaller"
    UNORDERED = "unordered"
    """No magnitude is more than another: they are names, or places in a list."""


def worse(magnitude: Magnitude) -> Worse:
    """The direction that the study declares; without one, the direction of the ladder, which runs from mild to strong.

    >>> worse(Magnitude("delay_s", "s", (0.5, 1.0), 1.0)), worse(Magnitude("axis", "", ("x", "y"), "x"))
    (<Worse.LARGER: 'larger'>, <Worse.UNORDERED: 'unordered'>)
    """
    if magnitude.worse:
        return Worse(magnitude.worse)
    numbers = [rung for rung in magnitude.ladder if not isinstance(rung, str)]
    if len(numbers) < 2 or len(numbers) < len(magnitude.ladder):
        return Worse.UNORDERED
    if all(milder < stronger for milder, stronger in pairwise(numbers)):
        return Worse.LARGER
    return Worse.SMALLER if all(milder > stronger for milder, stronger in pairwise(numbers)) else Worse.UNORDERED


def neutral(magnitude: Magnitude) -> float | None:
    """The magnitude that changes nothing and need not be flown; None when there is no such magnitude.

    It is the one that the study declares; without one, 1 for a factor (unit x), 0 for a magnitude that gets worse as it
    grows, and 100 % for a share that gets worse as it shrinks.

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


def mild_to_strong(magnitude: Magnitude) -> tuple[float, ...]:
    """The ladder from mild to strong; empty when the ladder has no order."""
    direction = worse(magnitude)
    numbers = (rung for rung in magnitude.ladder if not isinstance(rung, str))
    return () if direction is Worse.UNORDERED else tuple(sorted(numbers, reverse=direction is Worse.SMALLER))
