"""The situation space for results: axes, their values with short names, the points of the grid."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from scaloft_fi.document import load
from scaloft_fi.errors import InputError
from scaloft_fi.judge.stl import Formula, FormulaError, Signals

if TYPE_CHECKING:
    from scaloft_fi.sim.grid import Grid
    from scaloft_fi.sim.situation import AxisValue

Point = tuple[str, ...]
"""One value per axis, in the axes' order."""


@dataclass(frozen=True)
class Space:
    """A grid of situations.

    Attributes:
        axes: names of the axes.
        values: per axis its values, the benign one first.
        words: per axis a short name of each value, such as `light`, `dark`.
        points: key and point of each situation, in the grid's order.
    """

    axes: tuple[str, ...]
    values: tuple[tuple[str, ...], ...]
    words: tuple[tuple[str, ...], ...]
    points: tuple[tuple[str, Point], ...]

    @classmethod
    def of(cls, grid: Grid) -> Space:
        """The space of a grid; the short names are the titles of the values."""
        return cls(
            axes=tuple(axis.id for axis in grid.axes),
            values=tuple(tuple(str(value.id) for value in axis.values) for axis in grid.axes),
            words=tuple(tuple(value.title for value in axis.values) for axis in grid.axes),
            points=tuple((s.key, tuple(str(s[axis.id]) for axis in grid.axes)) for s in grid.situations),
        )

    @cached_property
    def point(self) -> Mapping[str, Point]:
        """Point by key of the situation."""
        return dict(self.points)

    @cached_property
    def order(self) -> Mapping[str, int]:
        """Index in the grid by key of the situation."""
        return {key: place for place, (key, _) in enumerate(self.points)}

    def word(self, axis: int, value: str) -> str:
        """The short name of a value of the axis with this index."""
        return self.words[axis][self.values[axis].index(value)]

    def rank(self, key: str) -> tuple[int, str]:
        """Sort key of a situation: the grid's order; unknown situations are last."""
        return self.order.get(key, len(self.points)), key


@dataclass(frozen=True)
class Realisation:
    """Judges whether a flight met the values of its situation.

    Attributes:
        space: the grid.
        predicates: by axis and value a formula over the log; None for the benign value, which is met if no other is.
    """

    space: Space
    predicates: tuple[tuple[Formula | None, ...], ...] = field(repr=False)

    @classmethod
    def read(cls, grid: Grid, path: Path, signals: Collection[str]) -> Realisation:
        """Read the predicates of the grid's values, and check them against the names of the log's signals.

        Args:
            grid: grid of the study.
            path: file of the grid, for the place of an error.
            signals: names of the log's signals.

        Raises:
            InputError: a predicate is no formula over these signals; the message names file and line.
        """
        predicates = tuple(
            tuple(_predicate(axis.id, value, path, signals) for value in axis.values) for axis in grid.axes
        )
        return cls(Space.of(grid), predicates)

    def of(self, situation: str, signals: Signals) -> tuple[tuple[str, bool], ...]:
        """By axis, whether a flight with these signals, (T,) each at 20 Hz, met the situation's value.

        Raises:
            ValueError: a signal is not finite.
        """
        point = self.space.point[situation]
        return tuple(
            (axis, self._came_true(number, point[number], signals)) for number, axis in enumerate(self.space.axes)
        )

    def _came_true(self, axis: int, value: str, signals: Signals) -> bool:
        by_value = dict(zip(self.space.values[axis], self.predicates[axis], strict=True))
        predicate = by_value[value]
        if predicate is not None:
            return predicate.robustness(signals)[0] >= 0
        return all(other.robustness(signals)[0] < 0 for other in by_value.values() if other is not None)


def _predicate(axis: str, value: AxisValue, path: Path, signals: Collection[str]) -> Formula | None:
    if not value.realised:
        return None
    try:
        return Formula.parse(value.realised, signals)
    except FormulaError as error:
        place = load(path).need("axes").need(axis).need("values").items()[value.id].need("realised").place
        raise InputError(f"{place}: realised {error}") from error
