"""Beliefs: numbers that a stack believes, logged at each sample of the flight log beside the ground truth."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Mark:
    """When a belief puts a mark into the recording of a flight, and on its map.

    Attributes:
        kind: one word for marks of this kind; a fault may strike at it, as at `#recoil`.
        text: label of the mark; `{}` stands for the value's name.
        first: whether only the first occurrence is marked.
        values: names of the values 0, 1, ...; with them each change is marked, without them each rise above 0.5.
        colour: on the map; "" keeps it off the map.
    """

    kind: str
    text: str
    first: bool = False
    values: tuple[str, ...] = ()
    colour: str = "#1d4ed8"


@dataclass(frozen=True)
class Belief:
    """A number that a stack believes.

    Attributes:
        name: unique among the signals of the log; requirements may speak of it.
        unit: "" for a plain number.
        meaning: of the number, in words.
        unknown: its value while the stack does not know it; NaN for a number that the stack always knows.
        mark: when the map of a flight shows a mark; None for never.
        most: its greatest value; a formula that compares it with a greater number is refused.
    """

    name: str
    unit: str
    meaning: str
    unknown: float = math.nan
    mark: Mark | None = None
    most: float = math.inf
