"""The Karnaugh map for the page: how the grid is folded, told once, and per mutant the terms of its condition."""

from __future__ import annotations

from collections.abc import Sequence
from math import prod
from typing import Any

from scaloft_fi.analysis.condition import Term, cover, term_text
from scaloft_fi.analysis.kills.karnaugh import MOST_CELLS, fold
from scaloft_fi.analysis.kills.kill_matrix import Row
from scaloft_fi.judge.space import Point, Space

MOST_AXES = 6
"""8 x 8 situations: what fits on a screen, and on a sheet of paper."""
ANY = "-"


def folding(space: Space, titles: Sequence[str]) -> dict[str, Any]:
    """The axes that run down and across with the levels along each side, and where each situation lies.

    Args:
        space: the grid.
        titles: of its axes, as a reader knows them.

    Returns:
        `reason`: why there is no map, in sentences, empty where there is one; then `down` and `across`, indices of
        axes; `rows` and `columns`, per place along that side a level of each of its axes; `keys`, (rows, columns) keys
        of situations, null where the grid has none.
    """
    if not foldable(space):
        return {"reason": _reason(space, titles)}
    folded = fold(space)
    return {
        "reason": "",
        "down": list(folded.down),
        "across": list(folded.across),
        "rows": [_levels(space, folded.down, point) for point in folded.rows],
        "columns": [_levels(space, folded.across, point) for point in folded.columns],
        "keys": [list(keys) for keys in folded.keys],
    }


def foldable(space: Space) -> bool:
    """Whether the page has maps of this grid."""
    return 2 <= len(space.axes) <= MOST_AXES and all(len(values) == 2 for values in space.values)


def _reason(space: Space, titles: Sequence[str]) -> str:
    others = [f"{title!r} has {len(v)}" for title, v in zip(titles, space.values, strict=True) if len(v) != 2]
    if others:
        said = f"A Karnaugh map needs axes of two values each; of this grid's, {_and(others)}."
    else:
        said = f"A Karnaugh map shows 2 to {MOST_AXES} axes; this grid has {len(space.axes)}."
    if len(space.axes) > 1 and prod(len(values) for values in space.values) <= MOST_CELLS:
        said += "  `scaloft-fi kills MUTANT --output map.svg` draws the folded grid all the same."
    return said


def terms(space: Space, row: Row) -> list[dict[str, str]]:
    """The terms of a mutant's condition where its grid has a map: `levels` has a level, or `-`, for each axis."""
    if not foldable(space):
        return []
    found = cover(space, row.killing, row.surviving)
    return [{"levels": _pattern(space, term), "words": term_text(space, term) or "everywhere"} for term in found]


def _pattern(space: Space, term: Term) -> str:
    sides = zip(space.values, term, strict=True)
    return "".join(ANY if len(kept) == len(values) else str(values.index(next(iter(kept)))) for values, kept in sides)


def _levels(space: Space, axes: Sequence[int], point: Point) -> list[int]:
    return [space.values[axis].index(value) for axis, value in zip(axes, point, strict=True)]


def _and(texts: Sequence[str]) -> str:
    """A list in a sentence.

    >>> _and(["a"]), _and(["a", "b", "c"])
    ('a', 'a, b and c')
    """
    return texts[0] if len(texts) == 1 else f"{', '.join(texts[:-1])} and {texts[-1]}"
