"""The situation grid: the product of the axes without the excluded points, and the world of each situation."""

from __future__ import annotations

import fnmatch
import itertools
import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from scaloft_fi.document import Item, load
from scaloft_fi.errors import InputError
from scaloft_fi.sim.constraint import Constraint, read_constraints
from scaloft_fi.sim.mine import Mine, read_mine
from scaloft_fi.sim.patch import patched
from scaloft_fi.sim.situation import Axis, Situation, read_axis
from scaloft_fi.sim.world import World, read_world

MOST_POINTS = 1_000_000
"""Largest product of the axes; all points are held in memory."""
MOST_AXES = 100


@dataclass(frozen=True, eq=False)
class Grid:
    """All situations.

    Attributes:
        axes: the axes in the order of the key.
        aliases: keys by other names, such as the numbers of the paper.
        document: the document of the world, which the axes change.
        constraints: combinations of values that the grid excludes.
    """

    axes: tuple[Axis, ...]
    aliases: Mapping[str, str]
    document: Item
    constraints: tuple[Constraint, ...] = ()

    @cached_property
    def situations(self) -> tuple[Situation, ...]:
        """Every situation; the last axis varies fastest."""
        return self._feasible(itertools.product(*([value.id for value in axis.values] for axis in self.axes)))

    def _feasible(self, points: Iterable[tuple[int, ...]]) -> tuple[Situation, ...]:
        """The situations of the points that no constraint excludes."""
        names = [axis.id for axis in self.axes]
        every = (dict(zip(names, point, strict=True)) for point in points)
        return tuple(Situation.of(levels) for levels in every if self._excluding(levels) is None)

    def _excluding(self, levels: Mapping[str, int]) -> Constraint | None:
        """The constraint that excludes a point; None when the point is a situation."""
        return next((constraint for constraint in self.constraints if constraint.forbids(levels)), None)

    @cached_property
    def by_key(self) -> Mapping[str, Situation]:
        """Situations by key."""
        return {situation.key: situation for situation in self.situations}

    def __len__(self) -> int:
        return len(self.situations)

    def situation(self, name: str) -> Situation:
        """The situation of a key or an alias.

        Raises:
            InputError: there is no such situation; the message names the nearest key.
        """
        situation = self.by_key.get(self.aliases.get(name, name))
        if situation is None:
            raise InputError(self.miss(name))
        return situation

    def select(self, patterns: Iterable[str]) -> tuple[Situation, ...]:
        """The situations that match a pattern (key, alias or glob such as `T1*H?`), in the grid's order.

        Without patterns, all situations.

        Raises:
            InputError: a pattern matches nothing; the message names the nearest key.
        """
        wanted: set[str] = set()
        patterns = tuple(patterns)
        for pattern in patterns:
            if any(mark in pattern for mark in "*?["):
                matches = {key for key in self.by_key if fnmatch.fnmatchcase(key, pattern)}
                if not matches:
                    raise InputError(self.miss(pattern))
                wanted |= matches
            else:
                wanted.add(self.situation(pattern).key)
        return tuple(situation for situation in self.situations if not patterns or situation.key in wanted)

    def gray_order(self) -> tuple[Situation, ...]:
        """Every situation once; each differs from its predecessor in one axis by one step (reflected Gray code).

        Where constraints exclude points, the step is longer.
        """
        walks: list[tuple[int, ...]] = [()]
        for axis in self.axes:
            ids = [value.id for value in axis.values]
            walks = [(*walk, level) for i, walk in enumerate(walks) for level in (ids if i % 2 == 0 else ids[::-1])]
        return self._feasible(walks)

    def titles(self, situation: Situation) -> tuple[str, ...]:
        """The titles of the situation's values, one for each axis."""
        return tuple(axis.value(situation[axis.id]).title for axis in self.axes)

    def aliases_of(self, situation: Situation) -> tuple[str, ...]:
        """The other names of a situation."""
        return tuple(alias for alias, key in self.aliases.items() if key == situation.key)

    def world(self, levels: Iterable[tuple[str, int]]) -> World:
        """The world with these axis values.

        Raises:
            InputError: a change names an unknown path or sets a value that is not allowed.
        """
        document = self.document
        axes = {axis.id: axis for axis in self.axes}
        for name, level in levels:
            for path, value in axes[name].value(level).changes.items():
                document = patched(document, path, value)
        unchanged = document.mapping().get("mine") is self.document.mapping().get("mine")
        return read_world(document, self._mine if unchanged else None)

    @cached_property
    def _mine(self) -> Mine:
        """The mine of every world whose situation does not change it; reading a mesh takes seconds."""
        return read_mine(self.document.need("mine"))

    def miss(self, name: str) -> str:
        """The error message for a name without a situation: the constraint that excludes it, or the nearest key."""
        written = {axis.lower(): int(level) for axis, level in re.findall(r"([A-Za-z][a-z]*)(\d+)", name)}
        levels = {axis.id: written.get(axis.id.lower(), -1) for axis in self.axes}
        why = self._excluding(levels) if Situation.of(levels).key == name else None
        if why is not None:
            return f"situation {name!r} is excluded by {why.place}: {why.reason}"
        near = min(self.situations, key=lambda other: sum(levels[axis] != level for axis, level in other.levels))
        shape = "".join(f"{axis.id}0" for axis in self.axes)
        return f"no situation {name!r} in keys like {shape!r}; did you mean {near.key!r}?"


def load_grid(folder: Path) -> Grid:
    """Read the situations of a study's `sim` folder and the world that they change, no other file.

    Raises:
        InputError: as `read_grid`, or a file cannot be read.
    """
    return read_grid(load(folder / "situations.yaml"), load(folder / "world.yaml"))


def read_grid(item: Item, world_document: Item) -> Grid:
    """Read the axes, and check the world of each single value.

    Raises:
        InputError: a value is not allowed, a key or path is unknown, a value makes an impossible world, or the
            constraints exclude every situation of a value.
    """
    axes_item = item.need("axes")
    axes = tuple(read_axis(name, entry) for name, entry in axes_item.mapping(most=MOST_AXES).items())
    if not axes:
        raise InputError(f"{item.place}: axes must name at least one axis")
    points = math.prod(len(axis.values) for axis in axes)
    if points > MOST_POINTS:
        raise InputError(f"{axes_item.place}: axes make {points} situations, they must make at most {MOST_POINTS}")
    constraints = read_constraints(item.get("constraints"), axes)
    alias_item = item.get("aliases")
    alias_items = alias_item.mapping() if alias_item else {}
    item.close()
    aliases = {alias: _completed(entry.text(), axes) for alias, entry in alias_items.items()}
    grid = Grid(axes, aliases, world_document, constraints)
    _check_values(grid)
    for alias, entry in alias_items.items():
        if aliases[alias] not in grid.by_key:
            raise InputError(f"{entry.place}: alias {alias!r}: {grid.miss(entry.text())}")
    for axis in axes:
        for value in axis.values:
            grid.world([(axis.id, value.id)])
    return grid


def _check_values(grid: Grid) -> None:
    """Refuse constraints that exclude every situation of a value."""
    if not grid.constraints:
        return
    left = {level for situation in grid.situations for level in situation.levels}
    for axis in grid.axes:
        for value in axis.values:
            if (axis.id, value.id) not in left:
                wanted = f"constraints must leave every value a situation, {axis.id}{value.id} has none"
                raise InputError(f"{grid.constraints[0].place}: {wanted}")


def _completed(key: str, axes: Iterable[Axis]) -> str:
    """Add the benign value of every axis that the key lacks, so that aliases stay valid after an axis is added."""
    levels = dict(re.findall(r"([A-Z][a-z]*)(\d+)", key))
    known = {axis.id for axis in axes}
    if "".join(f"{axis}{level}" for axis, level in levels.items()) != key or not known.issuperset(levels):
        return key
    return "".join(f"{axis.id}{levels.get(axis.id, 0)}" for axis in axes)
