"""Situations and the axes that span their grid."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass

from scaloft_fi.document import Item
from scaloft_fi.errors import InputError

MOST_VALUES = 200
"""Most values of an axis; the world of each is read with the study."""

AXIS_ID = re.compile(r"[A-Z][a-z]*")


@dataclass(frozen=True, eq=False)
class AxisValue:
    """One value of an axis.

    Attributes:
        id: number in the key; 0 is the benign value.
        title: name of the value in tables.
        changes: new values by dotted path in the world's document.
        realised: STL formula over the flight log: whether the flight met this value; "" for the benign value.
    """

    id: int
    title: str
    changes: Mapping[str, Item]
    realised: str


@dataclass(frozen=True, eq=False)
class Axis:
    """One axis of the situation grid.

    Attributes:
        id: a capital letter, then small letters, as in the key.
        title: name of the axis in tables.
        category: category of the axis in the operational domain model.
        values: values of the axis; the benign value is first.
    """

    id: str
    title: str
    category: str
    values: tuple[AxisValue, ...]

    def value(self, number: int) -> AxisValue:
        """The value with this id."""
        return next(value for value in self.values if value.id == number)

    def predicate(self, number: int) -> str:
        """STL formula: whether a flight met the value; a flight meets the benign value if it meets no other."""
        own = self.value(number).realised
        return own or " and ".join(f"(not ({value.realised}))" for value in self.values if value.realised)


@dataclass(frozen=True)
class Situation:
    """A point of the grid.  key: such as `T0O0W0D0H0`; levels: value id by axis, in the order of the axes."""

    key: str
    levels: tuple[tuple[str, int], ...]

    @classmethod
    def of(cls, levels: Mapping[str, int]) -> Situation:
        """The situation with these values.

        >>> Situation.of({"T": 1, "H": 0}).key
        'T1H0'
        """
        return cls("".join(f"{axis}{value}" for axis, value in levels.items()), tuple(levels.items()))

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
    values: list[AxisValue] = []
    values_item = item.need("values")
    for entry in values_item.items(most=MOST_VALUES):
        number_item = entry.need("id")
        number = number_item.whole()
        if number != len(values):
            raise number_item.error(f"{len(values)}: ids count from 0, the benign value")
        changes, realised = entry.get("set"), entry.get("realised")
        if (realised is None) != (number == 0):
            raise InputError(
                f"{entry.place}: value {name}{number} must {'not ' if number == 0 else ''}have the key 'realised'"
            )
        values.append(
            AxisValue(
                id=number,
                title=entry.need("title").text(),
                changes=changes.mapping() if changes else {},
                realised=realised.text() if realised else "",
            )
        )
        entry.close()
    if len(values) < 2:
        raise InputError(f"{values_item.place}: axis {name!r} must have at least 2 values")
    axis = Axis(name, item.need("title").text(), item.need("category").text(), tuple(values))
    item.close()
    return axis
