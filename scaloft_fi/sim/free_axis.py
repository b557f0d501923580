"""Free axes: numbers that vary around the situations of a grid, and span no grid themselves.

At its benign value a free axis changes nothing and is left out of the key, so `T1O0W0D0H1` names the same flight with
and without it.  Another number stands at the end of the key: `T1O0W0D0H1Cs=0.871`.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from scaloft_fi.document import Item
from scaloft_fi.errors import InputError, did_you_mean
from scaloft_fi.sim.constraint import read_values
from scaloft_fi.sim.distribution import Distribution, read_distribution
from scaloft_fi.sim.patch import found, overlap, qualified
from scaloft_fi.sim.range import cut, number_text, short
from scaloft_fi.sim.situation import AXIS_ID, Axis, AxisValue

MOST_FREE = 50
DEVIATES = 1 / 3
"""The chance that a free axis is off its benign value in a situation drawn at random: else nearly all would be off."""


@dataclass(frozen=True)
class FreeAxis:
    """A number that is benign or anywhere in its range.

    Attributes:
        id: a capital letter, then small letters, as in the key.
        title: name of the axis in tables.
        category: category of the axis in the operational domain model.
        path: dotted path of the number, which begins with `world`, `vehicle` or `sensors`.
        unit: its unit.
        distribution: its distribution off the benign value.
        benign: the number that the documents have.
        also: what else a number off the benign value sets, such as that a happening is active.
        only_with: values of other axes without which the number has no effect or cannot be.
        item: the entry `set`, for the places of errors.
    """

    id: str
    title: str
    category: str
    path: str
    unit: str
    distribution: Distribution
    benign: float
    also: tuple[tuple[str, Item], ...]
    only_with: tuple[tuple[str, frozenset[int]], ...]
    item: Item

    def holds(self, number: float) -> bool:
        """Whether the number is in the range."""
        return self.distribution.low <= number <= self.distribution.high

    def goes_with(self, levels: Mapping[str, int]) -> bool:
        """Whether a situation with these values may have a number of this axis."""
        return all(levels.get(axis) in values for axis, values in self.only_with)

    def at(self, share: float) -> float:
        """The number below which the share `share` of the draws falls, 0 <= share < 1."""
        return max(cut(self.distribution.quantile(share)), self.distribution.low)

    def drawn(self, share: float) -> float | None:
        """The number of a situation drawn at random; None, the benign value, for most shares 0 <= share < 1."""
        return self.at((share - 1 + DEVIATES) / DEVIATES) if share >= 1 - DEVIATES else None

    def told(self, number: float) -> str:
        """A number in words, such as `cruise speed 0.871 m/s`."""
        return f"{self.title} {number_text(number)} {self.unit}"

    def value(self, number: float) -> AxisValue:
        """What a number off the benign value sets."""
        item = Item(self.item.path, self.item.line, self.item.name, number)
        return AxisValue(0, self.told(number), {self.path: item, **dict(self.also)}, "", self.item.place)

    @property
    def extremes(self) -> tuple[AxisValue, AxisValue]:
        """The values at both ends."""
        return self.value(self.distribution.low), self.value(self.distribution.high)


def read_free_axes(item: Item | None, axes: Iterable[Axis], documents: Mapping[str, Item]) -> tuple[FreeAxis, ...]:
    """Read the mapping under `free`; an absent one gives no axes.

    Args:
        item: the mapping.
        axes: the axes that span the grid.
        documents: the documents that the axes change.

    Raises:
        InputError: a value is not allowed, a key or path is unknown, the benign value is not that of the documents, or
            two axes set one path.
    """
    spanning = {axis.id: axis for axis in axes}
    read = tuple(
        _read(name, entry, spanning, documents)
        for name, entry in (item.mapping(most=MOST_FREE) if item else {}).items()
    )
    for number, axis in enumerate(read):
        for other in spanning.values():
            for value in other.values:
                if axis.goes_with({**dict.fromkeys(spanning, -1), **_first(axis), other.id: value.id}):
                    _refuse_common(axis, value.changes, f"{other.id}{value.id}")
        for before in read[:number]:
            if not _apart(axis, before):
                _refuse_common(axis, before.value(before.benign).changes, before.id)
    return read


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
            wanted = " and ".join(f"{other}={sorted(values)}" for other, values in axis.only_with)
            raise InputError(f"{axis.item.place}: {text} goes only with {wanted}")
        if not axis.holds(number) and number != axis.benign:
            low, high = number_text(axis.distribution.low), number_text(axis.distribution.high)
            raise InputError(f"{axis.item.place}: {text} must be {low} to {high}")
    return {axis.id: numbers[axis.id] for axis in known.values() if numbers.get(axis.id, axis.benign) != axis.benign}


def _read(name: str, item: Item, axes: Mapping[str, Axis], documents: Mapping[str, Item]) -> FreeAxis:
    if not AXIS_ID.fullmatch(name) or name in axes:
        raise InputError(
            f"{item.place}: free axis {name!r} must have a name of its own: a capital letter, then small ones"
        )
    set_item, low_item, high_item = item.need("set"), item.need("from"), item.need("to")
    low, high = short(low_item), short(high_item)
    if low >= high:
        raise high_item.error(f"> {number_text(low)}, which is 'from'")
    path, benign_item = qualified(set_item.text(), set_item), item.need("benign")
    also, only_with = item.get("also"), item.get("only_with")
    axis = FreeAxis(
        id=name,
        title=item.need("title").text(),
        category=item.need("category").text(),
        path=path,
        unit=item.need("unit").text(),
        distribution=read_distribution(item, low, high),
        benign=short(benign_item),
        also=tuple(_also(key, entry) for key, entry in also.mapping().items()) if also else (),
        only_with=tuple(_condition(key, entry, axes) for key, entry in only_with.mapping().items())
        if only_with
        else (),
        item=set_item,
    )
    item.close()
    now = found(documents, path)
    if now is None:
        raise InputError(f"{set_item.place}: no path {path!r} in the study")
    if now.value != axis.benign:
        raise benign_item.error(f"{now.plain()!r}, what the study has at {now.place}")
    return axis


def _also(path: str, item: Item) -> tuple[str, Item]:
    if isinstance(item.value, dict | tuple):
        raise item.error("a single value")
    return qualified(path, item), item


def _condition(name: str, item: Item, axes: Mapping[str, Axis]) -> tuple[str, frozenset[int]]:
    if name not in axes:
        raise InputError(f"{item.place}: only_with names the unknown axis {name!r}{did_you_mean(name, axes)}")
    return name, read_values(axes[name], item)


def _first(axis: FreeAxis) -> dict[str, int]:
    """Values of other axes with which a number of this one goes."""
    return {name: min(values) for name, values in axis.only_with}


def _apart(axis: FreeAxis, other: FreeAxis) -> bool:
    """Whether no situation has numbers of both."""
    theirs = dict(other.only_with)
    return any(not values & theirs[name] for name, values in axis.only_with if name in theirs)


def _refuse_common(axis: FreeAxis, changes: Mapping[str, Item], name: str) -> None:
    """Refuse a path that both change, unless both give it the same value."""
    for path, item in axis.value(axis.benign).changes.items():
        for other, theirs in changes.items():
            if overlap(path, other) and not (path == other and path != axis.path and item.value == theirs.value):
                sentence = f"{axis.item.place}: {axis.id} and {name} both set {other}"
                raise InputError(f"{sentence}; name under only_with of {axis.id} the values that it goes with")
