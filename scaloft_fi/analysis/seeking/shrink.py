"""Shrink a situation that shows a fault: as many axes as possible at their benign values, numbers near them."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from itertools import repeat
from typing import TYPE_CHECKING

from scaloft_fi.errors import InputError
from scaloft_fi.sim.situation import Situation, cut

if TYPE_CHECKING:
    from scaloft_fi.sim.grid import Grid

HALVINGS = 3
"""Times that a number is halved towards its benign value."""

ALONE = 3
"""Changes that are tried alone in a round, where all of them together do not show the fault."""

Shows = Callable[[Sequence[Situation], bool], Sequence[bool]]
"""Whether each situation shows the fault: with the first seed of the search, or (True) with all of them."""
Numbers = dict[str, float]


def shrunk(situation: Situation, grid: Grid, shows: Shows) -> Situation:
    """The situation with axes reset and numbers halved towards benign values, as long as it shows the fault.

    In each round all axes are reset one by one; those that may be, are reset together where that still shows the
    fault, else one of the first alone.  Then numbers are halved in the same way.  At the end each axis is reset once
    more, all that may be tried alone, and each number that is left is rounded to one digit.

    Args:
        situation: shows the fault.
        grid: its grid.
        shows: asked for situations of the grid.
    """
    situation = _rounds(situation, _resets, grid, shows)
    situation = _rounds(situation, _halves, grid, shows, most=HALVINGS)
    situation = _rounds(situation, _resets, grid, shows, alone=None)
    return _rounds(situation, _rounded, grid, shows, alone=None)


def _rounds(
    situation: Situation,
    changes: Callable[[Situation, Grid], Iterable[Situation]],
    grid: Grid,
    shows: Shows,
    *,
    most: int | None = None,
    alone: int | None = ALONE,
) -> Situation:
    """The situation after rounds of changes, until none changes it."""
    for _ in repeat(None) if most is None else range(most):
        simpler = _round(situation, changes(situation, grid), grid, shows, alone)
        if simpler == situation:
            break
        situation = simpler
    return situation


def _round(
    situation: Situation, changed: Iterable[Situation], grid: Grid, shows: Shows, alone: int | None
) -> Situation:
    """The situation after one round of changes."""
    tried = list(dict.fromkeys(one for one in changed if one != situation))
    kept = [one for one, good in zip(tried, shows(tried, False) if tried else (), strict=True) if good]
    joint = _joined(situation, kept, grid)
    for one in dict.fromkeys([*([joint] if joint is not None else []), *kept[:alone]]):
        if all(shows([one], True)):
            return one
    return situation


def _joined(situation: Situation, changed: Sequence[Situation], grid: Grid) -> Situation | None:
    """The situation with the changes of all; None where they cannot be combined."""
    levels, numbers = dict(situation.levels), dict(situation.numbers)
    for one in changed:
        levels |= {axis: level for axis, level in one.levels if level != situation[axis]}
        theirs = dict(one.numbers)
        for axis, number in situation.numbers:
            if axis not in theirs:
                numbers.pop(axis, None)
            elif theirs[axis] != number and axis in numbers:
                numbers[axis] = theirs[axis]
    return _placed(grid, levels, numbers) if changed else None


def _resets(situation: Situation, grid: Grid) -> Iterable[Situation]:
    """The situation with one axis at its benign value."""
    levels, numbers = dict(situation.levels), dict(situation.numbers)
    for axis in numbers:
        rest = {other: number for other, number in numbers.items() if other != axis}
        yield from _possible(grid, levels | ({axis: 0} if axis in levels else {}), rest)
    for axis, level in levels.items():
        if level and axis not in numbers:
            benign = levels | {axis: 0}
            going = {free.id for free in grid.free if free.goes_with(benign)} | levels.keys()
            yield from _possible(grid, benign, {other: n for other, n in numbers.items() if other in going})


def _halves(situation: Situation, grid: Grid) -> Iterable[Situation]:
    """The situation with one number halfway to its benign value."""
    return _renumbered(situation, grid, lambda number, benign: brief((number + benign) / 2))


def _rounded(situation: Situation, grid: Grid) -> Iterable[Situation]:
    """The situation with one number rounded to one digit, away from its benign value."""
    return _renumbered(situation, grid, rounded_away)


def _renumbered(situation: Situation, grid: Grid, change: Callable[[float, float], float]) -> Iterable[Situation]:
    """The situation with one number changed; `change` is given the number and its benign value."""
    levels, numbers = dict(situation.levels), dict(situation.numbers)
    benign = {axis.id: axis.benign for axis in grid.free}
    benign |= {axis.id: axis.range.benign for axis in grid.axes if axis.range}
    ranges = {axis.id: axis.range for axis in grid.axes if axis.range}
    for axis, number in numbers.items():
        other = change(number, benign[axis])
        bin_ = ranges[axis].bin(other) if axis in ranges else None
        if other not in (number, benign[axis]):
            yield from _possible(grid, levels | ({} if bin_ is None else {axis: bin_}), numbers | {axis: other})


def _possible(grid: Grid, levels: dict[str, int], numbers: Numbers) -> Iterable[Situation]:
    placed = _placed(grid, levels, numbers)
    return () if placed is None else (placed,)


def _placed(grid: Grid, levels: dict[str, int], numbers: Numbers) -> Situation | None:
    """The situation of the grid with these values; None where it has none."""
    try:
        return grid.situation(grid.at(levels, numbers).key)
    except InputError:
        return None


def brief(number: float) -> float:
    """The number with two significant digits, as people say it.

    >>> brief(0.8713), brief(-12.34), brief(1.0)
    (0.87, -12.0, 1.0)
    """
    return cut(float(f"{number:.2g}"))


def rounded_away(number: float, benign: float) -> float:
    """The number with one significant digit, and no nearer to the benign value.

    >>> rounded_away(0.87, 0.5), rounded_away(0.33, 0.5), rounded_away(-0.0026, 0.0), rounded_away(5.0, 3.5)
    (0.9, 0.3, -0.003, 5.0)
    """
    if number == 0.0:
        return number
    unit = 10.0 ** math.floor(math.log10(abs(number)))
    steps = round(number / unit, 9)
    whole = math.ceil(steps) if number > benign else math.floor(steps)
    return cut(float(f"{whole * unit:.1g}"))
