"""The situation grid: the product of the axes, and the scenario of each point."""

from __future__ import annotations

import difflib
import fnmatch
import itertools
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property

from scaloft_fi.document import Item
from scaloft_fi.errors import InputError
from scaloft_fi.sim.patch import patched
from scaloft_fi.sim.raster import Camera
from scaloft_fi.sim.scenario import Scenario
from scaloft_fi.sim.situation import Axis, Situation, read_axis
from scaloft_fi.sim.world import World, read_world


@dataclass(frozen=True, eq=False)
class Grid:
    """All situations.

    Attributes:
        axes: in the order of the key.
        aliases: keys by other names, as the numbers of the paper.
        document: the world's document that the axes change.
        camera: the depth camera, which decides when a person comes into view.
    """

    axes: tuple[Axis, ...]
    aliases: Mapping[str, str]
    document: Item
    camera: Camera
    _scenarios: dict[str, Scenario] = field(default_factory=dict, repr=False)

    @cached_property
    def situations(self) -> tuple[Situation, ...]:
        """Every situation, the last axis counting fastest."""
        names = [axis.id for axis in self.axes]
        ids = [[value.id for value in axis.values] for axis in self.axes]
        return tuple(Situation.of(dict(zip(names, levels, strict=True))) for levels in itertools.product(*ids))

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
        """Every situation once, each differing from the one before in one axis by one step (reflected Gray code)."""
        walks: list[tuple[int, ...]] = [()]
        for axis in self.axes:
            ids = [value.id for value in axis.values]
            walks = [(*walk, level) for i, walk in enumerate(walks) for level in (ids if i % 2 == 0 else ids[::-1])]
        names = [axis.id for axis in self.axes]
        return tuple(Situation.of(dict(zip(names, walk, strict=True))) for walk in walks)

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

    def scenario(self, situation: Situation) -> Scenario:
        """All that stands before a flight in the situation, made once.

        Raises:
            InputError: the values of the axes do not go together.
        """
        if situation.key not in self._scenarios:
            self._scenarios[situation.key] = Scenario(situation, self.world(situation.levels), self.camera)
        return self._scenarios[situation.key]

    def miss(self, name: str) -> str:
        """The sentence for a name that is none of a situation."""
        shape = "".join(f"{axis.id}0" for axis in self.axes)
        near = difflib.get_close_matches(name.replace("*", ""), self.by_key, n=1, cutoff=0.0)
        return f"no situation {name!r} in keys like {shape!r}; did you mean {near[0]!r}?"


def read_grid(item: Item, world_document: Item, camera: Camera) -> Grid:
    """Read the axes and check each of their values by itself.

    Raises:
        InputError: a value is not allowed, a key or path unknown, or a value makes a world that cannot be.
    """
    axes = tuple(read_axis(name, entry) for name, entry in item.need("axes").mapping().items())
    if not axes:
        raise InputError(f"{item.place}: axes must name at least one axis")
    alias_item = item.get("aliases")
    alias_items = alias_item.mapping() if alias_item else {}
    item.close()
    aliases = {alias: _completed(entry.text(), axes) for alias, entry in alias_items.items()}
    grid = Grid(axes, aliases, world_document, camera)
    for alias, entry in alias_items.items():
        if aliases[alias] not in grid.by_key:
            raise InputError(f"{entry.place}: alias {alias!r}: {grid.miss(entry.text())}")
    for axis in axes:
        for value in axis.values:
            grid.world([(axis.id, value.id)])
    return grid


def _completed(key: str, axes: Iterable[Axis]) -> str:
    """The key with the benign value of every axis that it leaves out, so that aliases outlive a new axis."""
    levels = dict(re.findall(r"([A-Z][a-z]*)(\d+)", key))
    known = {axis.id for axis in axes}
    if "".join(f"{axis}{level}" for axis, level in levels.items()) != key or not known.issuperset(levels):
        return key
    return "".join(f"{axis.id}{levels.get(axis.id, 0)}" for axis in axes)
