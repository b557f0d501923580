"""The situation space for results: axes, their values with short names, the points of the grid."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING

from scaloft_fi.errors import InputError
from scaloft_fi.judge.stl import Formula, FormulaError, Signals
from scaloft_fi.sim.situation import Situation

if TYPE_CHECKING:
    from scaloft_fi.sim.grid import Grid
    from scaloft_fi.sim.situation import Axis, AxisValue, FreeAxis, Range

MOST_LISTED = 256
"""Most situations of a grid that lists and tables show whole; of a larger grid they show what was flown."""
Point = tuple[str, ...]
"""One value per axis, in the axes' order; of a number drawn from a range its bin."""


Rank = tuple[int, tuple[float, ...], str]
"""Place in the grid, drawn numbers, key."""


class Points(Mapping[str, Point]):
    """Point by key of the situation; its keys are those of the grid, but it finds the point of drawn numbers too."""

    def __init__(
        self, points: Iterable[tuple[str, Point]], ranges: Mapping[str, Range], free: Mapping[str, FreeAxis]
    ) -> None:
        self._grid, self._drawn, self._ranges, self._free = dict(points), dict[str, Point](), ranges, free

    def __getitem__(self, key: str) -> Point:
        if key in self._grid:
            return self._grid[key]
        if key not in self._drawn:
            situation = Situation.parse(key) if isinstance(key, str) else None
            if situation is None or situation.key != key or not self._in_bins(situation):
                raise KeyError(key)
            self._drawn[key] = self._grid[situation.point.key]
        return self._drawn[key]

    def _in_bins(self, situation: Situation) -> bool:
        levels = dict(situation.levels)
        return situation.point.key in self._grid and all(
            axis in self._ranges and self._ranges[axis].bin(number) == levels[axis]
            if axis in levels
            else axis in self._free and self._free[axis].goes_with(levels) and self._free[axis].holds(number)
            for axis, number in situation.numbers
        )

    def __iter__(self) -> Iterator[str]:
        return iter(self._grid)

    def __len__(self) -> int:
        return len(self._grid)


@dataclass(frozen=True)
class Space:
    """A grid of situations.

    Attributes:
        axes: names of the axes.
        values: per axis its values, the benign one first.
        words: per axis a short name of each value, such as `light`, `dark`.
        points: key and point of each situation of the grid, in the grid's order.
        ranges: the ranges of the axes that have one, in the axes' order.
        drawn: keys of situations with drawn numbers, which `situations` lists too.
        free: the free axes, which span no grid and count in no coverage.
        selected: keys of situations that a search found because of verdicts.
        only: keys of the grid's situations that `situations` lists; None = all.
        grid: name of the grid, where it is a further grid of the study; else empty.
        of_tests: whether one's own tests stand where situations do.
    """

    axes: tuple[str, ...]
    values: tuple[tuple[str, ...], ...]
    words: tuple[tuple[str, ...], ...]
    points: tuple[tuple[str, Point], ...]
    ranges: tuple[tuple[str, Range], ...] = ()
    drawn: tuple[str, ...] = ()
    free: tuple[tuple[str, FreeAxis], ...] = ()
    selected: frozenset[str] = frozenset()
    only: frozenset[str] | None = None
    grid: str = ""
    of_tests: bool = False

    @classmethod
    def of(cls, grid: Grid) -> Space:
        """The space of a grid; the short names are the titles of the values."""
        return cls(
            axes=tuple(axis.id for axis in grid.axes),
            values=tuple(tuple(str(value.id) for value in axis.values) for axis in grid.axes),
            words=tuple(tuple(value.title for value in axis.values) for axis in grid.axes),
            points=tuple((s.key, tuple(str(s[axis.id]) for axis in grid.axes)) for s in grid.situations),
            ranges=tuple((axis.id, axis.range) for axis in grid.axes if axis.range is not None),
            free=tuple((axis.id, axis) for axis in grid.free),
            selected=grid.selected,
            grid=grid.name if grid.further else "",
            of_tests=grid.of_tests,
        )

    def holding(self, keys: Iterable[str]) -> Space:
        """The space that lists the situations with drawn numbers among `keys` too.

        Of a grid of more than `MOST_LISTED` situations it lists no others than `keys`.
        """
        held = frozenset(keys) | frozenset(self.drawn) | (self.only or frozenset())
        drawn = tuple(sorted(key for key in held if key not in self.order and key in self.point))
        return replace(self, drawn=drawn, only=held if len(self.points) > MOST_LISTED else None)

    @property
    def situations(self) -> tuple[tuple[str, Point], ...]:
        """Key and point of each listed situation; drawn numbers follow the situation of their bins, ascending."""
        points = self.points if self.only is None else tuple(entry for entry in self.points if entry[0] in self.only)
        if not self.drawn:
            return points
        drawn = ((key, self.point[key]) for key in self.drawn)
        return tuple(sorted((*points, *drawn), key=lambda entry: self.rank(entry[0])))

    @cached_property
    def point(self) -> Mapping[str, Point]:
        """Point by key of the situation."""
        return Points(self.points, dict(self.ranges), dict(self.free))

    @cached_property
    def order(self) -> Mapping[str, int]:
        """Index in the grid by key of the situation."""
        return {key: place for place, (key, _) in enumerate(self.points)}

    def word(self, axis: int, value: str) -> str:
        """The short name of a value of the axis with this index."""
        return self.words[axis][self.values[axis].index(value)]

    def words_of(self, key: str) -> tuple[str, ...]:
        """The short names of the situation's values, one for each axis; of a drawn number the number with its unit.

        Numbers of free axes follow, benign ones left out.

        Raises:
            KeyError: there is no such situation.
        """
        words = {axis: self.word(place, self.point[key][place]) for place, axis in enumerate(self.axes)}
        if situation := Situation.parse(key):
            told: dict[str, Range | FreeAxis] = {**dict(self.ranges), **dict(self.free)}
            words |= {axis: told[axis].told(number) for axis, number in situation.numbers}
        return tuple(words.values())

    def rank(self, key: str) -> Rank:
        """Sort key of a situation: the grid's order, then drawn numbers; unknown situations are last."""
        place = self.order.get(key)
        if place is not None:
            return place, (), key
        situation = Situation.parse(key) if key in self.point else None
        if situation is None:
            return len(self.points), (), key
        return self.order[situation.point.key], tuple(number for _, number in situation.numbers), key


@dataclass(frozen=True)
class Realisation:
    """Judges whether a flight met the values of its situation.

    Attributes:
        space: the grid.
        predicates: by axis and value a formula over the log; None for a benign value that is met if no other is.
        axes, signals: the axes of the grid and the names of the log's signals, for the formulas of drawn numbers.
    """

    space: Space
    predicates: tuple[tuple[Formula | None, ...], ...] = field(repr=False)
    axes: tuple[Axis, ...] = ()
    signals: tuple[str, ...] = ()

    @classmethod
    def read(cls, grid: Grid, signals: Collection[str]) -> Realisation:
        """Read the predicates of the grid's values, and check them against the names of the log's signals.

        Args:
            grid: grid of the study.
            signals: names of the log's signals.

        Raises:
            InputError: a predicate is no formula over these signals; the message names file and line.
        """
        predicates = tuple(tuple(_predicate(value, signals) for value in axis.values) for axis in grid.axes)
        return cls(Space.of(grid), predicates, grid.axes, tuple(signals))

    def of(self, situation: str, signals: Signals) -> tuple[tuple[str, bool], ...]:
        """By axis, whether a flight with these signals, (T,) each at 20 Hz, met the situation's value.

        Raises:
            ValueError: a signal is not finite.
        """
        point, drawn = self.space.point[situation], Situation.parse(situation)
        numbers = dict(drawn.numbers) if drawn else {}
        return tuple(
            (axis, self._came_true(place, point[place], numbers.get(axis), signals))
            for place, axis in enumerate(self.space.axes)
        )

    def _came_true(self, axis: int, value: str, number: float | None, signals: Signals) -> bool:
        by_value = dict(zip(self.space.values[axis], self.predicates[axis], strict=True))
        predicate = by_value[value]
        if number is not None:
            predicate = _predicate(self.axes[axis].value(int(value), number), self.signals)
        if predicate is not None:
            return _holds(predicate, signals)
        return not any(_holds(other, signals) for other in by_value.values() if other is not None)


def _holds(predicate: Formula, signals: Signals) -> bool:
    """Whether a formula holds; one over the signals of a happening holds in no flight without it."""
    return all(name in signals for name in predicate.names) and predicate.robustness(signals)[0] >= 0


def _predicate(value: AxisValue, signals: Collection[str]) -> Formula | None:
    if not value.realised:
        return None
    try:
        return Formula.parse(value.realised, signals)
    except FormulaError as error:
        raise InputError(f"{value.place}: realised {error}") from error
