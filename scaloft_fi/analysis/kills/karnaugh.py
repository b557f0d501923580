"""A Karnaugh map of a mutant: the grid folded into a rectangle whose neighbours differ on one axis.

The first half of the axes runs down, the others run across, each side in the order of a reflected Gray code (Karnaugh,
"The map method for synthesis of combinational logic circuits", Trans. AIEE 72, 1953; for axes of any number of values
here).  With two values an axis the opposite edges are neighbours too.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import prod
from typing import Any

from scaloft_fi.analysis.condition import Term, admits, cover, term_text
from scaloft_fi.analysis.kills.gray import gray_words
from scaloft_fi.analysis.kills.kill_matrix import Row
from scaloft_fi.judge.space import Point, Space

MOST_CELLS = 512
"""A map of more situations than this would not be read."""


@dataclass(frozen=True)
class Block:
    """A term of the mutant's condition on the map.

    Attributes:
        words: as `human & light`.
        places: (row, column) of the map's situations that the term admits.
    """

    words: str
    places: frozenset[tuple[int, int]]


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


@dataclass(frozen=True)
class KarnaughMap(Fold):
    """A mutant's map.

    Attributes:
        mutant: id.
        condition: the whole condition; empty when it is killed nowhere.
        blocks: one per term of the condition.
    """

    mutant: str
    condition: str
    blocks: tuple[Block, ...]

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values."""
        return {
            "mutant": self.mutant,
            "condition": self.condition,
            "down": list(self.down),
            "across": list(self.across),
            "keys": [list(row) for row in self.keys],
            "blocks": [{"words": block.words, "places": sorted(map(list, block.places))} for block in self.blocks],
        }


def fold(space: Space) -> Fold:
    """The grid as a rectangle: the first half of its axes down, the others across."""
    half = len(space.axes) // 2
    down, across = tuple(range(half)), tuple(range(half, len(space.axes)))
    rows, columns = _side(space, down), _side(space, across)
    key_of = {point: key for key, point in space.points}
    keys = tuple(tuple(key_of.get((*above, *beside)) for beside in columns) for above in rows)
    return Fold(down, across, rows, columns, keys)


def karnaugh_map(space: Space, row: Row, condition: str) -> KarnaughMap:
    """The map of a mutant.

    Raises:
        ValueError: the grid has more than `MOST_CELLS` combinations, a sentence for the user.
    """
    cells = prod(len(values) for values in space.values)
    if cells > MOST_CELLS:
        raise ValueError(f"a Karnaugh map of {cells} situations would not be read; at most {MOST_CELLS} are drawn")
    folded = fold(space)
    terms = cover(space, row.killing, row.surviving)
    return KarnaughMap(
        folded.down,
        folded.across,
        folded.rows,
        folded.columns,
        folded.keys,
        mutant=row.id,
        condition=condition,
        blocks=tuple(_block(space, term, folded.rows, folded.columns) for term in terms),
    )


def _side(space: Space, axes: tuple[int, ...]) -> tuple[Point, ...]:
    words = gray_words([len(space.values[axis]) for axis in axes])
    return tuple(tuple(space.values[axis][digit] for axis, digit in zip(axes, word, strict=True)) for word in words)


def _block(space: Space, term: Term, rows: tuple[Point, ...], columns: tuple[Point, ...]) -> Block:
    places = frozenset(
        (r, c) for r, above in enumerate(rows) for c, beside in enumerate(columns) if admits(term, (*above, *beside))
    )
    return Block(term_text(space, term) or "everywhere", places)
