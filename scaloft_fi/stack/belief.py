"""Beliefs: what a stack believes at each sample of the flight log, beside the ground truth."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Mark:
    """When a belief puts a mark on the map of a flight.

    Attributes:
        kind: of the mark, one word.
        text: in words; `{}` stands for the value's name.
        first: whether only the first time counts.
        values: names of the values 0, 1, ...; with them each change is marked, without them each rise above 0.5.
    """

    kind: str
    text: str
    first: bool = False
    values: tuple[str, ...] = ()


@dataclass(frozen=True)
class Belief:
    """One number that a stack believes.

    Attributes:
        name: unique among the signals of the log; requirements may speak of it.
        unit: "" for a plain number.
        meaning: in words.
        unknown: what it reads where the stack does not know; NaN where it always knows.
        mark: when it is marked on the map.
        most: it is never greater than this, whatever the stack believes; a formula may not compare it with more.
    """

    name: str
    unit: str
    meaning: str
    unknown: float = math.nan
    mark: Mark | None = None
    most: float = math.inf
