"""Covering arrays of strength 2 over the values of a grid's axes and the bins of its free axes.

A free axis has three bins of equal probability.  Two of them are its benign value, as in a random draw
(`FreeAxis.drawn`), so the arms that leave the choice to chance are off the benign values about equally often.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from functools import partial
from importlib import import_module
from typing import TYPE_CHECKING, Any

from scaloft_fi.sim.situation import DEVIATES
from scaloft_fi.streams import key_words

if TYPE_CHECKING:
    from scaloft_fi.sim.grid import Grid

BINS = round(1 / DEVIATES)
OFF = BINS - 1
"""The bin off the benign value."""
STRENGTH = 2
Share = Callable[[str, str], float]
"""The share 0 <= share < 1 of an axis' `level` or `number`, as `at_shares` takes it."""
Row = dict[str, int]
"""The value of each axis, and the bin of each free axis."""


def array(grid: Grid, seed: int, number: int) -> Iterator[Share]:
    """The shares of the situations of an array that has every pair of values and bins that some situation has.

    Args:
        grid: the grid.
        seed: seed of the search.
        number: which array of the search; each breaks ties in its own way.
    """
    sizes = {axis.id: len(axis.values) for axis in grid.axes}

    def share(place: int, row: Row, axis: str, what: str) -> float:
        if what == "level":
            return (row[axis] + 0.5) / sizes[axis]
        inside = (key_words("search or chance", "2-way", seed, number, place, axis)[0] >> 11) / 2**53
        return min((row[axis] + inside) / BINS, 1 - 2**-53)

    return (partial(share, place, row) for place, row in enumerate(_rows(grid, f"{seed}-{number}")))


def _rows(grid: Grid, salt: str) -> list[Row]:
    factors = {axis.id: list(range(len(axis.values))) for axis in grid.axes}
    factors |= {axis.id: list(range(BINS)) for axis in grid.free}
    make = import_module("covertable").make
    rows: list[Row] = make(factors, strength=STRENGTH, salt=salt, tolerance=0, constraints=list(_constraints(grid)))
    return rows


def _constraints(grid: Grid) -> Iterator[dict[str, Any]]:
    """In the library's words: no excluded combination, and a free axis off its benign value only where it may be."""
    for constraint in grid.constraints:
        axes = [(axis, constraint.excluded[axis.id]) for axis in grid.axes if axis.id in constraint.excluded]
        yield _any(_is(axis.id, value.id) for axis, out in axes for value in axis.values if value.id not in out)
    for free in grid.free:
        for other, values in free.only_with.items():
            yield _any([{**_is(free.id, OFF), "operator": "ne"}, *(_is(other, value) for value in sorted(values))])


def _any(conditions: Iterable[dict[str, Any]]) -> dict[str, Any]:
    return {"operator": "or", "conditions": list(conditions)}


def _is(axis: str, value: int) -> dict[str, Any]:
    return {"operator": "eq", "left": axis, "value": value}
