"""t-way combinations: which combinations of the values of t axes a set of situations has.

Kuhn, Kacker, Lei, "Combinatorial Coverage Measurement", NISTIR 7878 (2012).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import combinations
from math import prod

import numpy as np
from numpy.typing import NDArray

from scaloft_fi.analysis.ratio import Ratio
from scaloft_fi.judge.space import Space

Levels = NDArray[np.int64]
"""(points, axes): the place of each value on its axis, 0 = benign."""
Ids = NDArray[np.int64]


@dataclass(frozen=True)
class TWay:
    """Coverage of the combinations of `strength` axes.

    Attributes:
        strength: how many axes.
        axes: per choice of that many axes, the combinations covered, of those that some situation of the grid has.
    """

    strength: int
    axes: tuple[Ratio, ...]

    @property
    def total(self) -> Ratio:
        """Combinations covered, over all choices of axes."""
        return Ratio(sum(one.part for one in self.axes), sum(one.whole for one in self.axes))

    def complete(self, share: float) -> Ratio:
        """(p, t)-completeness: choices of axes with at least the share p of their combinations covered, of all."""
        return Ratio(sum(one.part >= share * one.whole for one in self.axes), len(self.axes))


def t_way(flown: Iterable[str], space: Space, strength: int) -> TWay:
    """Coverage by the situations with these keys; a combination that no situation of the grid has does not count."""
    return t_ways(flown, space, [strength])[0]


def t_ways(flown: Iterable[str], space: Space, strengths: Iterable[int]) -> tuple[TWay, ...]:
    """The same for several strengths."""
    chosen, whole = levels_of(flown, space), grid_levels(space)

    def of(axes: tuple[int, ...], size: int) -> Ratio:
        possible = size if whole is None else _distinct(ids(whole, space, axes), size)
        return Ratio(_distinct(ids(chosen, space, axes), size), possible)

    return tuple(TWay(t, tuple(of(axes, size) for axes, size in choices(space, t))) for t in strengths)


def _distinct(numbers: Ids, size: int) -> int:
    """How many different numbers there are, all of them from 0 to `size` - 1."""
    seen = np.zeros(size, bool)
    seen[numbers] = True
    return int(seen.sum())


def choices(space: Space, strength: int) -> Iterator[tuple[tuple[int, ...], int]]:
    """Each choice of `strength` axes, and how many combinations their values have."""
    for axes in combinations(range(len(space.axes)), strength):
        yield axes, prod(len(space.values[axis]) for axis in axes)


def ids(levels: Levels, space: Space, axes: tuple[int, ...]) -> Ids:
    """(points,): the number of each point's combination of values on `axes`, in mixed radix."""
    number = np.zeros(len(levels), np.int64)
    for axis in axes:
        number = number * len(space.values[axis]) + levels[:, axis]
    return number


def table(levels: Levels, space: Space, strength: int) -> tuple[Ids, int]:
    """All combinations of all points: (points, choices of axes), numbered from 0 over all choices; and how many."""
    columns, first = [], 0
    for axes, size in choices(space, strength):
        columns.append(ids(levels, space, axes) + first)
        first += size
    return np.stack(columns, axis=1) if columns else np.zeros((len(levels), 0), np.int64), first


def levels_of(keys: Iterable[str], space: Space) -> Levels:
    """The points of situations, in the order of `keys`."""
    place = [{value: number for number, value in enumerate(values)} for values in space.values]
    rows = [[at[value] for at, value in zip(place, space.point[key], strict=True)] for key in keys]
    return np.array(rows, np.int64).reshape(len(rows), len(space.axes))


def grid_levels(space: Space) -> Levels | None:
    """The points of a grid that lacks some of the product of its axes; None when every combination is there."""
    if len(space.points) == prod(map(len, space.values)):
        return None
    return levels_of((key for key, _ in space.points), space)
