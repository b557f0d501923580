"""The Karnaugh map for the page: how the grid is folded, and per mutant the terms of its condition."""

from __future__ import annotations

from collections.abc import Sequence
from math import prod
from typing import Any

from scaloft_fi.analysis.condition import Term, cover, term_text
from scaloft_fi.analysis.kill_matrix import MOST_CELLS, KillRow, cyclic, fold
from scaloft_fi.judge.space import Point, Space

LEAST_AXES = 2


def folding(space: Space) -> dict[str, Any]:
    """The axes that run down and across with the levels along each side, and where each situation lies.

    Returns:
        `reason`: why there is no map, in sentences, empty where there is one; then `down` and `across`, indices of
        axes; `rows` and `columns`, per place along that side a level of each of its axes; `cyclic`, whether the first
        and the last row are neighbours, and the same of columns; `keys`, (rows, columns) keys of situations, null
        where the grid has none.
    """
    if not foldable(space):
        return {"reason": _reason(space)}
    folded = fold(space)
    return {
        "reason": "",
        "down": list(folded.down),
        "across": list(folded.across),
        "rows": [_levels(space, folded.down, point) for point in folded.rows],
        "columns": [_levels(space, folded.across, point) for point in folded.columns],
        "cyclic": [cyclic(folded.rows), cyclic(folded.columns)],
        "keys": [list(keys) for keys in folded.keys],
    }


def foldable(space: Space) -> bool:
    """Whether the page has maps of this grid."""
    return not _reason(space)


def _reason(space: Space) -> str:
    """Why the page has no map of this grid; empty where it has one."""
    cells = prod(len(values) for values in space.values)
    if len(space.axes) < LEAST_AXES:
        return f"A Karnaugh map needs {LEAST_AXES} axes or more; this grid has {len(space.axes)}."
    if cells > MOST_CELLS:
        return f"A Karnaugh map of {cells} situations could not be read; at most {MOST_CELLS} are drawn."
    return ""


def terms(space: Space, row: KillRow) -> list[dict[str, Any]]:
    """The terms of a mutant's condition where its grid has a map: `levels` has those that it admits, for each axis."""
    if not foldable(space):
        return []
    covering = cover(space, row.killing, row.surviving)
    return [{"levels": _admitted(space, term), "words": term_text(space, term) or "everywhere"} for term in covering]


def _admitted(space: Space, term: Term) -> list[list[int]]:
    return [sorted(map(values.index, kept)) for values, kept in zip(space.values, term, strict=True)]


def _levels(space: Space, axes: Sequence[int], point: Point) -> list[int]:
    return [space.values[axis].index(value) for axis, value in zip(axes, point, strict=True)]
