"""The situation grid: the product of the axes without what is excluded, and the world of each point."""

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
from scaloft_fi.sim.patch import patched
from scaloft_fi.sim.situation import Axis, Situation, read_axis
from scaloft_fi.sim.world import World, read_world

MOST_POINTS = 1_000_000
"""Largest product of the axes: every point is held in memory, by its key."""


@dataclass(frozen=True, eq=False)
class Grid:
    """All situations.

    Attributes:
        axes: in the order of the key.
        aliases: keys by other names, as the numbers of the paper.
        document: the world's document that the axes change.
        constraints: combinations that no situation has.
    """

    axes: tuple[Axis, ...]
    aliases: Mapping[str, str]
    document: Item
    constraints: tuple[Constraint, ...] = ()

    @cached_property
    def situations(self) -> tuple[Situation, ...]:
        """Every situation, the last axis counting fastest."""
        return self._feasible(itertools.product(*([value.id for value in axis.values] for axis in self.axes)))

    def _feasible(self, points: Iterable[tuple[int, ...]]) -> tuple[Situation, ...]:
        """The situations of those points that no constraint forbids."""
        names = [axis.id for axis in self.axes]
        every = (dict(zip(names, point, strict=True)) for point in points)
        return tuple(Situation.of(levels) for levels in every if self._why_not(levels) is None)

    def _why_not(self, levels: Mapping[str, int]) -> Constraint | None:
        """The constraint that forbids a point; None when it is a situation."""
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
            InputError: there is none; names the nearest.
        """
        found = self.by_key.get(self.aliases.get(name, name))
        if found is None:
            raise InputError(self.miss(name))
        return found

    def select(self, patterns: Iterable[str]) -> tuple[Situation, ...]:
        """The situations that a key, an alias or a glob such as `T1*H?` names, in the grid's order; without any, all.

        Raises:
            InputError: a pattern matches nothing; names the nearest key.
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
        """Every situation once, each differing from the one before in one axis by one step (reflected Gray code).

        Where constraints leave points out the step is longer.
        """
        walks: list[tuple[int, ...]] = [()]
        for axis in self.axes:
            ids = [value.id for value in axis.values]
            walks = [(*walk, level) for i, walk in enumerate(walks) for level in (ids if i % 2 == 0 else ids[::-1])]
        return self._feasible(walks)

    def titles(self, situation: Situation) -> tuple[str, ...]:
        """The situation in words, one for each axis."""
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
        return read_world(document)

    def miss(self, name: str) -> str:
        """The sentence for a name that is none of a situation: why it is excluded, or the nearest key."""
        said = {axis.lower(): int(level) for axis, level in re.findall(r"([A-Za-z][a-z]*)(\d+)", name)}
        levels = {axis.id: said.get(axis.id.lower(), -1) for axis in self.axes}
        why = self._why_not(levels) if Situation.of(levels).key == name else None
        if why is not None:
            return f"situation {name!r} is excluded by {why.place}: {why.reason}"
        near = min(self.situations, key=lambda found: sum(levels[axis] != level for axis, level in found.levels))
        shape = "".join(f"{axis.id}0" for axis in self.axes)
        return f"no situation {name!r} in keys like {shape!r}; did you mean {near.key!r}?"


def load_grid(folder: Path) -> Grid:
    """Read the situations of a study's `sim` folder, and of the rest only the world that they change.

    Raises:
        InputError: as `read_grid`, or a file cannot be read.
    """
    return read_grid(load(folder / "situations.yaml"), load(folder / "world.yaml"))


def read_grid(item: Item, world_document: Item) -> Grid:
    """Read the axes and check each of their values by itself.

    Raises:
        InputError: a value is not allowed, a key or path unknown, a value makes a world that cannot be, or the
            constraints leave a value without a situation.
    """
    axes_item = item.need("axes")
    axes = tuple(read_axis(name, entry) for name, entry in axes_item.mapping().items())
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
    """Refuse constraints that leave a value without a situation."""
    if not grid.constraints:
        return
    left = {level for situation in grid.situations for level in situation.levels}
    for axis in grid.axes:
        for value in axis.values:
            if (axis.id, value.id) not in left:
                wanted = f"constraints must leave every value a situation, {axis.id}{value.id} has none"
                raise InputError(f"{grid.constraints[0].place}: {wanted}")


def _completed(key: str, axes: Iterable[Axis]) -> str:
    """The key with the benign value of every axis that it leaves out, so that aliases outlive a new axis."""
    levels = dict(re.findall(r"([A-Z][a-z]*)(\d+)", key))
    known = {axis.id for axis in axes}
    if "".join(f"{axis}{level}" for axis, level in levels.items()) != key or not known.issuperset(levels):
        return key
    return "".join(f"{axis.id}{levels.get(axis.id, 0)}" for axis in axes)
