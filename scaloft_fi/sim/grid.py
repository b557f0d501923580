"""The grids of a study: its own, further ones in `sim/grids/`, its own with the situations that a search found.

A grid is the product of its axes without the excluded points, or a list of situations, with the world of each.
What searches found, `sim/found.yaml`, are situations that show mutants, and those that break the unmutated drone.
"""

from __future__ import annotations

import fnmatch
import itertools
import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Annotated, ClassVar

from scaloft_fi import marks
from scaloft_fi.document import Item, is_file, is_there, load
from scaloft_fi.errors import Faults, InputError, did_you_mean, refused, shown
from scaloft_fi.marks import (
    ByName,
    Called,
    Examples,
    Given,
    Key,
    Listed,
    NotNegative,
    OneOrMore,
    Otherwise,
    Pattern,
    Place,
    Share,
    Size,
    Whole,
)
from scaloft_fi.model import read
from scaloft_fi.sim.happenings import signals_of
from scaloft_fi.sim.log import clearance_name
from scaloft_fi.sim.mine import Mine, read_mine
from scaloft_fi.sim.situation import (
    AXIS_ID,
    PARTS,
    Axis,
    AxisModel,
    AxisValue,
    FreeAxis,
    Situation,
    ValueIds,
    added,
    found,
    number_text,
    overlap,
    patched,
)
from scaloft_fi.sim.world import World, read_world, without_rock

MOST_CONSTRAINTS = 100
"""Each is compared with every point of the grid."""


MOST_FREE = 50


@dataclass(frozen=True)
class Constraint:
    """A combination of axis values that is impossible or of no interest; the grid leaves it out.

    Attributes:
        excluded: values of two or more axes that do not go together, by axis.
        reason: why no situation has the combination.
        place: `file:line` of the constraint.
    """

    excluded: Annotated[Mapping[str, ValueIds], Called("exclude")]
    reason: str
    place: Place

    def contradictions(self, item: Item) -> Iterator[InputError]:
        """Refuse a combination of fewer than two axes."""
        if len(self.excluded) < 2:
            sentence = "must name the values of at least 2 axes; to exclude a single value, remove it from its axis"
            yield InputError(f"{item.need('exclude').place}: exclude {sentence}")

    def forbids(self, levels: Mapping[str, int]) -> bool:
        """Whether the constraint excludes a point with these values.

        >>> Constraint({"T": frozenset({0}), "W": frozenset({1, 2})}, "no room", "").forbids({"T": 0, "W": 2, "H": 0})
        True
        """
        return all(levels[axis] in values for axis, values in self.excluded.items())


def unknown_values(item: Item, chosen: Mapping[str, frozenset[int]], axes: Mapping[str, Axis]) -> Iterator[InputError]:
    """An error for each axis, or value of one, that an entry names and the grid does not have.

    Args:
        item: the entry.
        chosen: values by axis, as they were read from it.
        axes: the axes by id.
    """
    for name, entry in item.mapping().items():
        if name not in axes:
            yield InputError(f"{entry.place}: {item.name} names the unknown axis {name!r}{did_you_mean(name, axes)}")
        elif max(chosen[name]) >= len(axes[name].values):
            yield entry.error(f"values of axis {name!r}, 0 to {len(axes[name].values) - 1}")


def lonely_values(
    axes: Sequence[Axis], situations: Sequence[Situation], constraints: Sequence[Constraint]
) -> Iterator[InputError]:
    """An error for each value of which the constraints exclude every situation."""
    if not constraints:
        return
    left = {level for situation in situations for level in situation.levels}
    for axis in axes:
        for value in axis.values:
            if (axis.id, value.id) not in left:
                wanted = f"constraints must leave every value a situation, {axis.id}{value.id} has none"
                yield InputError(f"{constraints[0].place}: {wanted}")


def common_paths(axes: Sequence[Axis], situations: Sequence[Situation]) -> Iterator[InputError]:
    """An error for each two values of two axes that set one path, or a path and a part of it, in a situation."""
    for first, second in itertools.combinations(axes, 2):
        for one, other in itertools.product(first.values, second.values):
            twice = next((path for path in other.changes for set_ in one.changes if overlap(path, set_)), None)
            pair = {(first.id, one.id), (second.id, other.id)}
            if twice is None or not (both := [s.key for s in situations if pair.issubset(s.levels)]):
                continue
            names = f"{first.id}{one.id} and {second.id}{other.id}"
            sentence = f"{other.changes[twice].place}: {names} both set {twice}, in situation {both[0]}"
            yield InputError(f"{sentence}; {remedy((first.id, one.id), (second.id, other.id))}")


def remedy(*levels: tuple[str, int]) -> str:
    """The constraint that excludes a combination of values, as advice.

    >>> remedy(("T", 1), ("W", 2))
    'exclude them under constraints: {exclude: {T: 1, W: 2}, reason: ...}'
    """
    values = ", ".join(f"{axis}: {level}" for axis, level in levels)
    return f"exclude them under constraints: {{exclude: {{{values}}}, reason: ...}}"


def misfit_free_axes(
    free: Sequence[FreeAxis], item: Item, axes: Iterable[Axis], documents: Mapping[str, Item]
) -> Iterator[InputError]:
    """An error for each free axis that does not fit the grid.

    Its name is that of another axis, a value of another axis does not exist, the benign value is not that of the
    documents, or two axes set one path.

    Args:
        free: the free axes.
        item: their mapping.
        axes: the axes that span the grid.
        documents: the documents that the axes change.
    """
    spanning = {axis.id: axis for axis in axes}
    for number, axis in enumerate(free):
        entry = item.need(axis.id)
        if axis.id in spanning:
            own = "a name of its own: a capital letter, then small ones"
            yield InputError(f"{entry.place}: free axis {axis.id!r} must have {own}")
        strange = list(unknown_values(only, axis.only_with, spanning)) if (only := entry.get("only_with")) else []
        yield from strange
        now = found(documents, axis.path)
        if now is None:
            yield InputError(f"{axis.item.place}: no path {axis.path!r} in the study")
        elif now.value != axis.benign:
            yield entry.need("benign").error(f"{now.plain()!r}, what the study has at {now.place}")
        if strange:
            continue
        for other in spanning.values():
            for value in other.values:
                # with values of other axes with which a number of this one goes
                only_with = {name: min(values) for name, values in axis.only_with.items()}
                if axis.goes_with({**dict.fromkeys(spanning, -1), **only_with, other.id: value.id}):
                    yield from _common(axis, value.changes, f"{other.id}{value.id}")
        for before in free[:number]:
            if not _apart(axis, before):
                yield from _common(axis, before.value(before.benign).changes, before.id)


def numbers_off(free: Iterable[FreeAxis], levels: Mapping[str, int], numbers: Mapping[str, float]) -> dict[str, float]:
    """The numbers of free axes that are off their benign values, in the order of the axes.

    Args:
        free: the free axes.
        levels: the values of the axes that span the grid.
        numbers: numbers by axis; those of axes in `levels` are left out.

    Raises:
        InputError: a free axis is unknown, does not go with these values, or does not hold its number.
    """
    known = {axis.id: axis for axis in free}
    for name, number in numbers.items():
        if name in levels:
            continue
        if name not in known:
            raise InputError(f"there is no free axis {name!r}{did_you_mean(name, known)}")
        axis, text = known[name], f"{name}={number_text(number)}"
        if not axis.goes_with(levels):
            wanted = " and ".join(f"{other}={sorted(values)}" for other, values in axis.only_with.items())
            raise InputError(f"{axis.item.place}: {text} goes only with {wanted}")
        if not axis.holds(number) and number != axis.benign:
            low, high = number_text(axis.low), number_text(axis.high)
            raise InputError(f"{axis.item.place}: {text} must be {low} to {high}")
    return {axis.id: numbers[axis.id] for axis in known.values() if numbers.get(axis.id, axis.benign) != axis.benign}


def _apart(axis: FreeAxis, other: FreeAxis) -> bool:
    """Whether no situation has numbers of both."""
    theirs = other.only_with
    return any(not values & theirs[name] for name, values in axis.only_with.items() if name in theirs)


def _common(axis: FreeAxis, changes: Mapping[str, Item], name: str) -> Iterator[InputError]:
    """An error for each path that both change, unless both give it the same value."""
    for path, item in axis.value(axis.benign).changes.items():
        for other, theirs in changes.items():
            if overlap(path, other) and not (path == other and path != axis.path and item.value == theirs.value):
                sentence = f"{axis.item.place}: {axis.id} and {name} both set {other}"
                yield InputError(f"{sentence}; name under only_with of {axis.id} the values that it goes with")


MOST_POINTS = 1_000_000
"""Largest product of the axes; all points are held in memory."""
MOST_AXES = 100
_AXIS = "a capital letter, then small ones"
ALL = "all"
"""All situations of the grid are flown."""


@dataclass(frozen=True, eq=False)
class Grid:
    """All situations.

    Attributes:
        axes: the axes in the order of the key.
        aliases: keys by other names, such as the numbers of the paper.
        documents: the documents that the axes change, by the names in `PARTS`.
        constraints: combinations of values that the grid excludes.
        name: name of the grid.
        further: whether it is not the study's own grid.
        choose: how a run chooses situations when nobody says it, as for `run --choose`.
        chosen_at: the place of that, for errors.
        item: the file of the grid; None for a grid without a file.
        free: the free axes, which span no grid.
        listed: the situations of a grid that is a list; None for all combinations of the values.
        selected: keys of situations that a search found because of verdicts; none of the study's own grid.
    """

    axes: tuple[Axis, ...]
    aliases: Mapping[str, str]
    documents: Mapping[str, Item]
    constraints: tuple[Constraint, ...] = ()
    name: str = ""
    further: bool = False
    choose: str = ALL
    chosen_at: str = ""
    item: Item | None = None
    free: tuple[FreeAxis, ...] = ()
    listed: tuple[Situation, ...] | None = None
    selected: frozenset[str] = frozenset()
    of_tests: ClassVar[bool] = False
    """Whether one's own tests stand where situations do."""

    @cached_property
    def situations(self) -> tuple[Situation, ...]:
        """Every situation; the last axis varies fastest."""
        if self.listed is not None:
            return self.listed
        points = itertools.product(*([(axis.id, value.id) for value in axis.values] for axis in self.axes))
        return tuple(Situation.of(levels) for levels in map(dict, points) if self._excluding(levels) is None)

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
        """The situation of a key or an alias; the key may have numbers drawn from ranges.

        Raises:
            InputError: there is no such situation; the message names the nearest key, or the bin of the number.
        """
        key = self.aliases.get(name, name)
        situation = self.by_key.get(key) or self._drawn(key)
        if situation is None:
            raise InputError(self.miss(name))
        return situation

    def _drawn(self, name: str) -> Situation | None:
        """The situation of a key with drawn numbers; None for a key without, or in no bins of the grid.

        Raises:
            InputError: a number lies outside its bin, or is not written as keys write it.
        """
        drawn = Situation.parse(name)
        if drawn is None or not drawn.numbers or drawn.point.key not in self.by_key:
            return None
        proper = self.at(dict(drawn.levels), dict(drawn.numbers))
        if proper.key != name:
            raise InputError(f"situation {name!r} must be written {proper.key!r}")
        ranges = {axis.id: axis.range for axis in self.axes}
        for axis, number in drawn.numbers:
            if axis not in ranges:
                continue
            range_ = ranges[axis]
            if range_ is None:
                raise InputError(f"situation {name!r} has a number for axis {axis!r}, which is no range")
            bin_, place = range_.bin(number), range_.item.place
            if bin_ is None:
                low, high = number_text(range_.edges[0]), number_text(range_.edges[-1])
                raise InputError(f"{place}: {axis}={number_text(number)} of {name!r} must be {low} to {high}")
            if bin_ != drawn[axis]:
                right = f"{axis}{bin_}={number_text(number)}"
                raise InputError(f"{place}: situation {name!r} must have {right!r}, the bin of that number")
        return drawn

    def at(self, levels: Mapping[str, int], numbers: Mapping[str, float]) -> Situation:
        """The situation with these values and numbers; benign numbers of free axes are left out.

        Raises:
            InputError: a free axis is unknown, does not go with these values, or does not hold its number.
        """
        off = numbers_off(self.free, levels, numbers)
        return Situation.of(levels, {axis: numbers[axis] for axis in levels if axis in numbers} | off)

    def select(self, patterns: Iterable[str]) -> tuple[Situation, ...]:
        """The situations that match a pattern (key, alias, or a glob over both such as `T1*H?`), in the grid's order.

        Without patterns, all situations of the grid.  A glob matches no drawn numbers; a key with drawn numbers
        selects its situation, which follows the one of its bins.

        Raises:
            InputError: a pattern matches nothing; the message names the nearest key.
        """
        wanted: dict[str, Situation] = {}
        patterns = tuple(patterns)
        for pattern in patterns:
            if any(mark in pattern for mark in "*?["):
                names = [name for name in (*self.by_key, *self.aliases) if fnmatch.fnmatchcase(name, pattern)]
                matches = {one.key: one for one in map(self.situation, names)}
                if not matches:
                    raise InputError(self.miss(pattern))
                wanted |= matches
            else:
                situation = self.situation(pattern)
                wanted[situation.key] = situation
        if not patterns:
            return self.situations
        places = {key: place for place, key in enumerate(self.by_key)}
        # a situation has its own place, else that of its bins
        return tuple(sorted(wanted.values(), key=lambda s: (places.get(s.key, places.get(s.point.key, 0)), s.numbers)))

    def titles(self, situation: Situation) -> tuple[str, ...]:
        """The titles of the situation's values, one for each axis; of a drawn number the number with its unit.

        Numbers of free axes follow, benign ones left out.
        """
        return tuple(value.title for value in self.values(situation).values())

    def aliases_of(self, situation: Situation) -> tuple[str, ...]:
        """The other names of a situation."""
        return tuple(alias for alias, key in self.aliases.items() if key == situation.key)

    def values(self, situation: Situation) -> dict[str, AxisValue]:
        """The value of each axis, and of each free axis that is not at its benign value."""
        numbers = dict(situation.numbers)
        values = {axis.id: axis.value(situation[axis.id], numbers.get(axis.id)) for axis in self.axes}
        return values | {axis.id: axis.value(numbers[axis.id]) for axis in self.free if axis.id in numbers}

    @property
    def proved_values(self) -> tuple[AxisValue, ...]:
        """The values with which the study is checked when it is read: each value, and both ends of each number."""
        own = (value for axis in self.axes for value in (*axis.values, *axis.extremes))
        return *own, *(value for axis in self.free for value in axis.extremes)

    def documents_with(self, values: Iterable[AxisValue]) -> Mapping[str, Item]:
        """The documents with these values of axes.

        Raises:
            InputError: a change names an unknown path.
        """
        documents = self.documents
        for value in values:
            documents = patched(documents, value.changes)
        return documents

    def world(self, situation: Situation | None = None) -> World:
        """The world of a situation; without one, the world that no axis changes.

        Raises:
            InputError: a change names an unknown path or sets a value that is not allowed.
        """
        return self.world_of(self.documents_with(self.values(situation).values() if situation else ()))

    def world_of(self, documents: Mapping[str, Item]) -> World:
        """The world of documents that a situation may have changed.

        Raises:
            InputError: a value is not allowed.
        """
        document, own = documents["world"], self.documents["world"]
        unchanged = document.mapping().get("mine") is own.mapping().get("mine")
        return read_world(document, self.mine if unchanged else None)

    @cached_property
    def recorded(self) -> World:
        """The world that no axis changes, without its rock: what flights record has the names of its bodies."""
        return without_rock(self.documents["world"])

    @cached_property
    def mine(self) -> Mine:
        """The mine of every world whose situation does not change it; reading a mesh takes seconds."""
        return read_mine(self.documents["world"].need("mine"))

    @cached_property
    def passing_signals(self) -> tuple[str, ...]:
        """Names of the signals of happenings and optional bodies, which only flights with these record."""
        values = [*(value for axis in self.axes for value in axis.values), *(axis.extremes[1] for axis in self.free)]
        worlds = [self.world_of(self.documents_with([value])) for value in values]
        optional = (clearance_name(body.name) for world in worlds for body in world.present if body.optional)
        return tuple(dict.fromkeys([*(name for world in worlds for name in signals_of(world.happenings)), *optional]))

    def miss(self, name: str) -> str:
        """The error message for a name without a situation: the constraint that excludes it, or the nearest key."""
        written = {axis.lower(): int(level) for axis, level in re.findall(r"([A-Za-z][a-z]*)(\d+)", name)}
        levels = {axis.id: written.get(axis.id.lower(), -1) for axis in self.axes}
        read = Situation.parse(name)
        why = self._excluding(levels) if read and read.point == Situation.of(levels) else None
        if why is not None:
            return f"situation {name!r} is excluded by {why.place}: {why.reason}"
        near = min(self.situations, key=lambda other: sum(levels[axis] != level for axis, level in other.levels))
        shape = "".join(f"{axis.id}0" for axis in self.axes)
        return f"no situation {name!r} in keys like {shape!r}; did you mean {near.key!r}?"


@dataclass(frozen=True)
class GridModel:
    """The axes of the study's own grid of situations.

    Attributes:
        axes: the axes by name, a capital letter, then small ones, in the order of the keys.
        choose: how a run chooses situations when nobody says it, as for `run --choose`; left out: all.
        constraints: combinations of values that the grid leaves out.
        free: numbers around the situations that span no grid; at the benign value left out of keys.
        aliases: other names of situations, by name.
        name: name of this grid, as for --grid; left out: situations.
    """

    axes: Annotated[Mapping[str, AxisModel], Size(1, MOST_AXES, "axes, at least one"), Pattern(AXIS_ID, _AXIS)]
    choose: Annotated[str, Examples("3-way", "random:20", "sobol:32")] = ""
    constraints: Annotated[tuple[Constraint, ...], Size(0, MOST_CONSTRAINTS)] = ()
    free: Annotated[tuple[FreeAxis, ...], ByName(), Size(0, MOST_FREE), Pattern(AXIS_ID, _AXIS)] = ()
    aliases: Mapping[str, Annotated[str, Examples("T0O0W0D0H1")]] = field(default_factory=dict)
    name: Annotated[str, Pattern("[A-Za-z0-9_-]{1,100}", "letters, digits, - and _"), Examples("paper")] = ""


@dataclass(frozen=True)
class FurtherGridModel(GridModel):
    """The axes of a further grid over the same world; `run --grid` flies it.

    Attributes:
        adds: what only this grid has: new entries of world, vehicle and sensors, as those documents have them.
        sources: the source of each number of this file by dotted path, as in sim/sources.yaml.
    """

    name: Annotated[str, Given(lambda item: item.path.stem)] = ""
    adds: Item | None = None
    sources: Item | None = None


def read_grid(item: Item, documents: Mapping[str, Item], name: str | None = None) -> Grid:
    """Read the axes, and check that they agree.

    Args:
        item: the file of the grid.
        documents: the documents that the axes change.
        name: name of a further grid; None for the study's own.

    Raises:
        InputError: a value is not allowed, a key is unknown, or there is one of the `contradictions`.
    """
    grid, faults = assembled(item, documents, name), Faults()
    faults.add(*contradictions(grid))
    faults.end()
    return grid


def assembled(item: Item, documents: Mapping[str, Item], name: str | None = None) -> Grid:
    """Read the axes, without the `contradictions` between them; arguments as `read_grid`.

    Raises:
        InputError: a value is not allowed, or a key is unknown.
    """
    model = read(FurtherGridModel if name else GridModel, item)
    documents = {part: documents[part] for part in PARTS}
    if isinstance(model, FurtherGridModel) and model.adds is not None:
        documents = added(documents, model.adds)
    entries, faults = item.need("axes"), Faults()
    axes = tuple(axis.axis for axis in model.axes.values())
    points = math.prod(len(axis.values) for axis in axes)
    if points > MOST_POINTS:
        raise InputError(f"{entries.place}: axes make {points} situations, they must make at most {MOST_POINTS}")
    by_id = {axis.id: axis for axis in axes}
    for constraint, entry in zip(model.constraints, item.get("constraints") or (), strict=True):
        faults.add(*unknown_values(entry.need("exclude"), constraint.excluded, by_id))
    if model.free:
        faults.add(*misfit_free_axes(model.free, item.need("free"), axes, documents))
    faults.end()
    choose = item.get("choose")
    return Grid(
        axes,
        {alias: _completed(key, axes) for alias, key in model.aliases.items()},
        documents,
        model.constraints,
        name=name or model.name or item.path.stem,
        further=name is not None,
        choose=model.choose or ALL,
        chosen_at=f"{choose.place}: choose" if choose else "",
        item=item,
        free=model.free,
    )


def contradictions(grid: Grid) -> Iterator[InputError]:
    """What the axes of a grid cannot agree on, error by error.

    The constraints exclude every situation of a value, or leave one in which two axes set one path; an alias names no
    situation.
    """
    yield from lonely_values(grid.axes, grid.situations, grid.constraints)
    yield from common_paths(grid.axes, grid.situations)
    alias_item = grid.item.get("aliases") if grid.item else None
    for alias, entry in (alias_item.mapping() if alias_item else {}).items():
        if error := refused(grid.situation, grid.aliases[alias]):
            yield InputError(f"{entry.place}: alias {alias!r}: {error}")


def impossible_worlds(grid: Grid) -> Iterator[InputError]:
    """An error for each value that changes an unknown path, or makes an impossible world."""
    try:
        _ = grid.mine
    except InputError as error:
        yield error
        return  # every world would have it
    for value in grid.proved_values:
        try:
            grid.world_of(grid.documents_with([value]))
        except InputError as error:
            yield error


def _completed(key: str, axes: Iterable[Axis]) -> str:
    """Add the benign value of every axis that the key lacks, so that aliases stay valid after an axis is added."""
    read, known = Situation.parse(key), [axis.id for axis in axes]
    if read is None or read.key != key or not dict(read.levels).keys() <= set(known):
        return key
    levels = dict.fromkeys(known, 0) | dict(read.levels)
    return Situation.of(levels, dict(read.numbers)).key


FILE, FOLDER = "situations.yaml", "grids"
"""The file of the study's own grid, and the folder of further grids, in `sim/`."""
_NAME = re.compile(r"[A-Za-z0-9_-]{1,100}")
WITH_FOUND = "+found"
"""What the name of the study's own grid with the found situations ends with."""


def is_grid_name(name: str) -> bool:
    """Whether a file of this name, without its ending, is a further grid."""
    return _NAME.fullmatch(name) is not None


def own_name(folder: Path) -> str:
    """The name of the grid of `situations.yaml`; `situations` when it has none.

    Args:
        folder: the study's `sim` folder.
    """
    name = load(folder / FILE).get("name")
    if name is not None and not is_grid_name(name.text()):
        raise name.error("a name of letters, digits, - and _")
    return name.text() if name else Path(FILE).stem


def grid_names(folder: Path) -> tuple[str, ...]:
    """The names of a study's grids, its own first.

    Raises:
        InputError: a further grid has the name of the own grid.
    """
    own = own_name(folder)
    paths = sorted(path for path in (folder / FOLDER).glob("*.yaml") if is_grid_name(path.stem) and is_file(path))
    further = [path.stem for path in paths]
    if own in further:
        raise InputError(f"{folder / FOLDER / own}.yaml: the grid of {FILE} is called {own!r} already; rename one")
    return own, *further, *([own + WITH_FOUND] if is_there(folder / FOUND_FILE) else [])


def load_grid(folder: Path, name: str | None = None) -> Grid:
    """Read a grid of a study's `sim` folder and the documents that it changes.

    Args:
        folder: the `sim` folder.
        name: name of a file in `grids/`, or of the own grid with `+found`; None for the study's own grid.

    Raises:
        InputError: as `read_grid`, or a file cannot be read.
    """
    documents = {part: load(folder / f"{part}.yaml") for part in PARTS}
    if name is None:
        return read_grid(load(folder / FILE), documents)
    found = read_finds(folder)
    if found is not None and name.endswith(WITH_FOUND):
        return _with_found(load_grid(folder), searched_grid(folder, found), found, name, folder / FOUND_FILE)
    grid = read_grid(load(folder / FOLDER / f"{name}.yaml"), documents, name)
    if found is None or found.grid != name:
        return grid
    # a new search goes on without the finds whose situations the study has outgrown
    named = {name: key for name, key in found.named.items() if not refused(grid.situation, key)}
    return replace(grid, aliases={**grid.aliases, **named}, selected=_selected(found, load_grid(folder)))


def searched_grid(folder: Path, found: Finds) -> Grid:
    """The grid that was searched; arguments as `load_grid`.

    Raises:
        InputError: the study has no such grid.
    """
    own, *further = grid_names(folder)
    if found.grid not in (own, *further) or found.grid.endswith(WITH_FOUND):
        place = f"{folder / FOUND_FILE}: grid={shown(found.grid)}"
        raise InputError(f"{place} must be a grid of the study{did_you_mean(found.grid, (own, *further))}")
    return load_grid(folder, None if found.grid == own else found.grid)


def _with_found(own: Grid, searched: Grid, found: Finds, name: str, place: Path) -> Grid:
    """The situations of the study's own grid, then those that show mutants, in the axes of the grid that was searched.

    Those that break the unmutated drone are left out: a situation whose baseline is red puts no mutant to the test.

    Raises:
        InputError: one of them is no situation of that grid.
    """
    aliases = {find.name: find.situation for find in found.finds}
    try:
        listed = {key: searched.situation(key) for key in (*own.by_key, *aliases.values())}
    except InputError as error:
        raise InputError(f"{place}: grid {searched.name!r}: {error}") from None
    aliases = {alias: key for alias, key in own.aliases.items() if key in listed} | aliases
    of_search = replace(searched, name=name, choose=ALL, selected=_selected(found, own))
    return replace(of_search, aliases=aliases, listed=tuple(listed.values()))


def _selected(found: Finds, own: Grid) -> frozenset[str]:
    """The found situations that the study's own grid does not have."""
    return frozenset(found.named.values()).difference(own.by_key)


FOUND_FILE = "found.yaml"
MOST_FINDS = 1_000


@dataclass(frozen=True)
class Again:
    """The evidence of a replication, from fresh seeds.

    Attributes:
        seed: the first seed.
        p: by the exact test of the one requirement, adjusted by Holm over all pairs that were replicated together.
        violated: flights of the mutant that violate the requirement.
        flights: flights of the mutant.
        held: baselines that hold the requirement with a robustness above their spread.
        baselines: baselines.
        mission: baselines that hold every operability requirement and meet the value of every axis.
    """

    seed: Whole
    p: Share
    violated: Whole
    flights: OneOrMore
    held: Whole
    baselines: OneOrMore
    mission: Whole


@dataclass(frozen=True)
class Evidence:
    """The evidence that a situation shows a mutant, from seeds that the search never flew.

    Attributes:
        requirement: the requirement that the mutant violates.
        candidate: which candidate of the mutant the situation was, from 1.
        p: by the score's own test.
        alpha: what p was compared with.
        violated: flights of the mutant that violate the requirement.
        flights: flights of the mutant, with the seeds from 0 on.
        held: baselines that hold the requirement with a robustness above `spread`.
        baselines: baselines, with the seeds from 0 on.
        margin: robustness that nine in ten baselines reach, in the requirement's unit.
        spread: standard deviation of the robustness over the baselines, in the requirement's unit.
        struck: the body that the first violating flight strikes; empty for none.
        mission: baselines that hold every operability requirement and meet the value of every axis.
        again: the evidence of a replication; null: not replicated.
    """

    requirement: Annotated[str, Examples("SR2")]
    candidate: OneOrMore
    p: Share
    alpha: Annotated[float, marks.Bounds(above=0.0, most=1.0)]
    violated: Whole
    flights: OneOrMore
    struck: Annotated[str, Otherwise(""), Examples("wall")]
    held: Whole
    baselines: OneOrMore
    margin: float
    spread: NotNegative
    mission: Whole
    again: Again | None = None


@dataclass(frozen=True)
class Find:
    """A situation that shows mutants.

    Attributes:
        name: name of the situation.
        situation: its key in the grid of the search.
        words: the values that are not benign, in words.
        mutant: the mutant that it was found for.
        shows: the evidence for each mutant that it shows, the one that it was found for first.
        seed: seed of the search.
    """

    name: Key
    situation: Annotated[str, Examples("T1O0W0D0H1Cs=0.871")]
    words: tuple[str, ...]
    mutant: Annotated[str, Examples("LATE-pose@0.5s")]
    shows: Annotated[Mapping[str, Evidence], Size(1, MOST_FINDS), Listed("mutant", "id of the mutant")]
    seed: Whole

    def contradictions(self, item: Item) -> Iterator[InputError]:
        """Refuse a find without the evidence for its own mutant."""
        if self.mutant not in self.shows:
            place = item.need("shows").place
            yield InputError(f"{place}: shows must have the evidence for {self.mutant!r}, its own mutant")


@dataclass(frozen=True)
class Break:
    """A situation in which the unmutated drone violates a safety requirement.

    Attributes:
        name: name of the situation; it follows from requirement, struck, leg, near and belief.
        situation: its key in the grid of the search.
        words: the values that are not benign, in words.
        requirement: the requirement.
        struck: the body that is struck at the violation; empty for none.
        leg: between which places of the route, such as `corner to end`.
        near: the body that is struck; the nearer of the two places where none is.
        belief: the stage whose belief was the most wrong before the violation; empty where none was wrong.
        error: how far from the truth that belief was, in `unit`.
        unit: unit of the error.
        violated: flights that violate the requirement, more than half.
        flights: flights, with the seeds from 0 on.
        alike: flights that do so in the same way: they strike the same, on the same leg, after the same wrong belief.
        flight: seed of the flight that `leg`, `near`, `belief`, `error`, `t_s` and `place` tell of.
        t_s: time of the violation from take-off [s].
        place: (3,) centre of the vehicle then [m, world].
        seed: seed of the search.
    """

    name: Key
    situation: Annotated[str, Examples("T1O0W0D0H1Cs=0.871")]
    words: tuple[str, ...]
    requirement: Annotated[str, Examples("SR1")]
    struck: Annotated[str, Otherwise(""), Examples("bar")]
    leg: Annotated[str, Examples("corner to end")]
    near: Annotated[str, Examples("corner")]
    belief: Annotated[str, Otherwise(""), Examples("pose")]
    error: NotNegative
    unit: Annotated[str, Otherwise(""), Examples("m")]
    violated: Whole
    flights: OneOrMore
    alike: OneOrMore
    flight: Whole
    t_s: NotNegative
    place: tuple[float, float, float]
    seed: Whole

    def contradictions(self, item: Item) -> Iterator[InputError]:
        """Refuse counts of flights that contradict each other."""
        if not self.flights < 2 * self.violated <= 2 * self.flights:
            yield item.need("violated").error(f"more than half of flights={self.flights}, and no more than all")
        if self.alike > self.violated:
            yield item.need("alike").error(f"at most violated={self.violated}")


@dataclass(frozen=True)
class Finds:
    """The situations that searches found; `scaloft-fi seek` writes this file.

    Attributes:
        grid: name of the grid whose keys they have.
        finds: the situations that show mutants, by name.
        breaks: the situations that break the unmutated drone, by name.
    """

    grid: Annotated[str, Examples("search")]
    finds: Annotated[tuple[Find, ...], ByName(), Size(0, MOST_FINDS)]
    breaks: Annotated[tuple[Break, ...], ByName(), Size(0, MOST_FINDS)] = ()

    @property
    def named(self) -> dict[str, str]:
        """The key of each situation by its name."""
        shown = {find.name: find.situation for find in self.finds}
        return shown | {one.name: one.situation for one in self.breaks}


def read_finds(folder: Path) -> Finds | None:
    """The finds of a study; None without the file.

    Args:
        folder: the study's `sim` folder.

    Raises:
        InputError: a key is missing or unknown, or a value is not allowed; the message names the place.
    """
    path = folder / FOUND_FILE
    return read(Finds, load(path)) if is_there(path) else None
