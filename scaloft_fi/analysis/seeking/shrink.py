"""Shrink a situation that shows a fault: as many axes as possible at their benign values, numbers near them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING

from scaloft_fi.errors import InputError
from scaloft_fi.sim.range import cut
from scaloft_fi.sim.situation import Situation

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
    fault, else one of the first alone.  Then numbers are halved in the same way.

    Args:
        situation: shows the fault.
        grid: its grid.
        shows: asked for situations of the grid.
    """
    while (simpler := _round(situation, _resets(situation, grid), grid, shows)) != situation:
        situation = simpler
    for _ in range(HALVINGS):
        nearer = _round(situation, _halves(situation, grid), grid, shows)
        if nearer == situation:
            break
        situation = nearer
    return situation


def _round(situation: Situation, changed: Iterable[Situation], grid: Grid, shows: Shows) -> Situation:
    """The situation after one round of changes."""
    tried = list(dict.fromkeys(one for one in changed if one != situation))
    kept = [one for one, good in zip(tried, shows(tried, False) if tried else (), strict=True) if good]
    joint = _joined(situation, kept, grid)
    for one in dict.fromkeys([*([joint] if joint is not None else []), *kept[:ALONE]]):
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
    levels, numbers = dict(situation.levels), dict(situation.numbers)
    benign = {axis.id: axis.benign for axis in grid.free}
    benign |= {axis.id: axis.range.benign for axis in grid.axes if axis.range}
    ranges = {axis.id: axis.range for axis in grid.axes if axis.range}
    for axis, number in numbers.items():
        nearer = brief((number + benign[axis]) / 2)
        bin_ = ranges[axis].bin(nearer) if axis in ranges else None
        if nearer not in (number, benign[axis]):
            yield from _possible(grid, levels | ({} if bin_ is None else {axis: bin_}), numbers | {axis: nearer})


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
