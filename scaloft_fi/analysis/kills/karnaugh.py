"""The shape of a Karnaugh map: the grid folded into a rectangle whose neighbours differ on one axis.

The first half of the axes runs down, the others run across, each side in the order of a reflected Gray code (Karnaugh,
"The map method for synthesis of combinational logic circuits", Trans. AIEE 72, 1953; for axes of any number of values
here).  With two values an axis the opposite edges are neighbours too.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from scaloft_fi.analysis.kills.gray import gray_words
from scaloft_fi.judge.space import Point, Space

MOST_CELLS = 512
"""A map of more situations than this would not be read."""


@dataclass(frozen=True)
class Fold:
    """A grid folded into a rectangle.

    Attributes:
        down, across: indices of the axes that run down, and across.
        rows, columns: values of those axes, in the order of the map.
        keys: (rows, columns) keys of the situations; None where the grid has none.
    """

    down: tuple[int, ...]
    across: tuple[int, ...]
    rows: tuple[Point, ...]
    columns: tuple[Point, ...]
    keys: tuple[tuple[str | None, ...], ...]


def fold(space: Space) -> Fold:
    """The grid as a rectangle: the first half of its axes down, the others across."""
    half = len(space.axes) // 2
    down, across = tuple(range(half)), tuple(range(half, len(space.axes)))
    rows, columns = _side(space, down), _side(space, across)
    key_of = {point: key for key, point in space.points}
    keys = tuple(tuple(key_of.get((*above, *beside)) for beside in columns) for above in rows)
    return Fold(down, across, rows, columns, keys)


def _side(space: Space, axes: tuple[int, ...]) -> tuple[Point, ...]:
    words = gray_words([len(space.values[axis]) for axis in axes])
    return tuple(tuple(space.values[axis][digit] for axis, digit in zip(axes, word, strict=True)) for word in words)


def cyclic(side: Sequence[Point]) -> bool:
    """Whether the last place of a side is a neighbour of the first.

    >>> cyclic([("0",), ("1",)]), cyclic([("0", "0"), ("0", "1"), ("1", "1"), ("1", "0"), ("2", "0"), ("2", "1")])
    (True, False)
    """
    return sum(a != b for a, b in zip(side[0], side[-1], strict=True)) <= 1
