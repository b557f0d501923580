"""Situations and the axes that span their grid."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from decimal import Decimal
from math import isfinite

from scaloft_fi.document import Item
from scaloft_fi.errors import InputError
from scaloft_fi.sim.patch import qualified
from scaloft_fi.sim.range import Range, number_text, read_range

MOST_VALUES = 200
"""Most values of an axis; the world of each is read with the study."""

MET = "a formula over signals that says when a flight has met the value, as in eventually(light <= 0.05)"
"""What `realised` is, for those who left it out."""

AXIS_ID = re.compile(r"[A-Z][a-z]*")
_DRAWN = r"=(-?[0-9]+(?:\.[0-9]+)?(?:e-?[0-9]{1,3})?)"
_LEVEL = re.compile(rf"([A-Z][a-z]*)(?:([0-9]{{1,9}})(?:{_DRAWN})?|{_DRAWN})")
_NUMBER = re.compile(r"\bnumber\b")
"""The word in the formula of a range that stands for the number that is flown."""


@dataclass(frozen=True, eq=False)
class AxisValue:
    """One value of an axis.

    Attributes:
        id: number in the key; 0 is the benign value.
        title: name of the value in tables.
        changes: new values by dotted path, which begins with `world`, `vehicle` or `sensors`.
        realised: STL formula over the flight log: whether the flight met this value; "" for a benign value, which a
            flight meets if it meets no other.
        place: `file:line` of the formula, or of the value without one.
    """

    id: int
    title: str
    changes: Mapping[str, Item]
    realised: str
    place: str


@dataclass(frozen=True, eq=False)
class Axis:
    """One axis of the situation grid.

    Attributes:
        id: a capital letter, then small letters, as in the key.
        title: name of the axis in tables.
        category: category of the axis in the operational domain model.
        values: values of the axis, of a range its bins; the benign value is first.
        range: the range of the axis; None for an axis with single values.
        realised: formula of the range, with the word `number` for the number that is flown; None without a range.
    """

    id: str
    title: str
    category: str
    values: tuple[AxisValue, ...]
    range: Range | None = None
    realised: Item | None = None

    def value(self, level: int, number: float | None = None) -> AxisValue:
        """The value with this id; with a number the value of that number, which lies in the bin."""
        if self.range is not None and self.realised is not None and number is not None:
            return _of_number(self.range, self.realised, level, number, self.range.told(number))
        return next(value for value in self.values if value.id == level)

    @property
    def extremes(self) -> tuple[AxisValue, ...]:
        """The values at both ends of the range; none without a range."""
        if self.range is None:
            return ()
        ids, edges = self.range.ids, self.range.edges
        return self.value(ids[0], edges[0]), self.value(ids[-1], edges[-1])

    def predicate(self, number: int) -> str:
        """STL formula: whether a flight met the value; a flight meets the benign value if it meets no other."""
        own = self.value(number).realised
        return own or " and ".join(f"(not ({value.realised}))" for value in self.values if value.realised)


@dataclass(frozen=True)
class Situation:
    """A point of the grid, or one with numbers drawn from ranges.

    Attributes:
        key: such as `T0O0W0D0H0`, with a drawn number `T0C2=0.871`, with a number of a free axis `T0H0Cs=0.871`.
        levels: value id by axis, in the order of the axes; of a drawn number the id of its bin.
        numbers: drawn number by axis; those of free axes, which have no level, are the last.
    """

    key: str
    levels: tuple[tuple[str, int], ...]
    numbers: tuple[tuple[str, float], ...] = ()

    @classmethod
    def of(cls, levels: Mapping[str, int], numbers: Mapping[str, float] | None = None) -> Situation:
        """The situation with these values and drawn numbers.

        >>> Situation.of({"T": 1, "C": 2, "H": 0}, {"C": 0.871}).key
        'T1C2=0.871H0'
        >>> Situation.of({"T": 1, "H": 0}, {"Cs": 0.871}).key
        'T1H0Cs=0.871'
        """
        numbers = numbers or {}
        drawn = {axis: number_text(numbers[axis]) for axis in levels if axis in numbers}
        key = "".join(f"{axis}{level}" + (f"={drawn[axis]}" if axis in drawn else "") for axis, level in levels.items())
        free = {axis: number_text(number) for axis, number in numbers.items() if axis not in levels}
        key += "".join(f"{axis}={text}" for axis, text in free.items())
        drawn |= free
        return cls(key, tuple(levels.items()), tuple((axis, float(text)) for axis, text in drawn.items()))

    @classmethod
    def parse(cls, text: str) -> Situation | None:
        """The situation that a text like a key names; None for another text.

        Its key differs from the text where the text does not write a number as keys do.

        >>> Situation.parse("T1C2=0.8710H0").key
        'T1C2=0.871H0'
        """
        parts = list(_LEVEL.finditer(text))
        levels = {part[1]: int(part[2]) for part in parts if part[2] is not None}
        numbers = {part[1]: float(part[3] or part[4]) for part in parts if part[3] or part[4]}
        if not parts or "".join(part[0] for part in parts) != text or len(levels.keys() | numbers) < len(parts):
            return None
        return cls.of(levels, numbers) if all(map(isfinite, numbers.values())) else None

    @property
    def point(self) -> Situation:
        """The situation of the grid in whose bins the drawn numbers lie."""
        return Situation.of(dict(self.levels)) if self.numbers else self

    def __getitem__(self, axis: str) -> int:
        return dict(self.levels)[axis]

    def __str__(self) -> str:
        return self.key


def read_axis(name: str, item: Item) -> Axis:
    """Read one axis.

    Raises:
        InputError: a value is not allowed, a key is unknown, the benign value is missing.
    """
    if not AXIS_ID.fullmatch(name):
        raise InputError(f"{item.place}: axis {name!r} must be named by a capital letter, then small ones")
    range_item = item.get("range")
    if range_item is None:
        axis = Axis(name, item.need("title").text(), item.need("category").text(), _values(name, item.need("values")))
    else:
        if (values := item.get("values")) is not None:
            raise InputError(f"{values.place}: axis {name!r} must have either 'values' or 'range', not both")
        range_, realised = read_range(range_item), item.need("realised", MET)
        realised.text()
        bins = tuple(
            _of_number(range_, realised, bin_, range_.middle(bin_), range_.title(bin_)) for bin_ in sorted(range_.ids)
        )
        axis = Axis(name, item.need("title").text(), item.need("category").text(), bins, range_, realised)
    item.close()
    return axis


def _values(name: str, values_item: Item) -> tuple[AxisValue, ...]:
    values: list[AxisValue] = []
    for entry in values_item.items(most=MOST_VALUES):
        number_item = entry.need("id")
        number = number_item.whole()
        if number != len(values):
            raise number_item.error(f"{len(values)}: ids count from 0, the benign value")
        changes, realised = entry.get("set"), entry.get("realised")
        if number == 0 and realised is not None:
            raise InputError(f"{realised.place}: value {name}0 must not have the key 'realised': it changes nothing")
        if number != 0 and realised is None:
            raise InputError(f"{entry.place}: value {name}{number} lacks the key 'realised': {MET}")
        values.append(
            AxisValue(
                id=number,
                title=entry.need("title").text(),
                changes={qualified(path, item): item for path, item in changes.mapping().items()} if changes else {},
                realised=realised.text() if realised else "",
                place=(realised or entry).place,
            )
        )
        entry.close()
    if len(values) < 2:
        raise InputError(f"{values_item.place}: axis {name!r} must have at least 2 values")
    return tuple(values)


def _of_number(range_: Range, realised: Item, bin_: int, number: float, title: str) -> AxisValue:
    """The value of an axis that sets the number of its range."""
    item = Item(range_.item.path, range_.item.line, range_.item.name, number)
    written = f"{Decimal(number_text(number)):f}"
    return AxisValue(bin_, title, {range_.path: item}, _NUMBER.sub(written, realised.text()), realised.place)
