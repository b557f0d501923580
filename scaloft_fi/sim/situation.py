"""Situations and the axes that span their grid: values, ranges cut into bins, excluded combinations, free axes.

The quantiles are closed forms, because `scipy.stats` takes longer to import than a verb that reads results may take;
the tests compare them with `scipy.stats`.

A number has at most four significant digits and is written so in the key of a situation: the written number is the
number that is flown.

At its benign value a free axis changes nothing and is left out of the key, so `T1O0W0D0H1` names the same flight with
and without it.  Another number stands at the end of the key: `T1O0W0D0H1Cs=0.871`.

An axis replaces single values of YAML documents by dotted path, or adds entries; a new value keeps its own place.
"""

from __future__ import annotations

import math
import re
from bisect import bisect_right
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from decimal import ROUND_FLOOR, Decimal
from enum import StrEnum
from functools import cached_property
from itertools import pairwise
from math import inf, isfinite, nextafter
from statistics import NormalDist
from typing import Annotated, Any, ClassVar

from scaloft_fi.document import Item
from scaloft_fi.errors import InputError, did_you_mean
from scaloft_fi.marks import Bounds, Called, Either, Examples, Given, Key, MoreThanZero, Reads, Size, Whole
from scaloft_fi.model import attributes_of

LEAST_MASS = 1e-6
"""A normal distribution must leave this much of itself between the ends; with less, quantiles are inexact."""


class Shape(StrEnum):
    """The known distributions."""

    UNIFORM = "uniform"
    LOG_UNIFORM = "log-uniform"
    NORMAL = "normal"
    TRIANGULAR = "triangular"


DIGITS = 4
"""Significant digits of a number."""
MOST_BINS = 100


def number_text(number: float) -> str:
    """The number with at most four significant digits, as in keys.

    >>> [number_text(number) for number in (0.871, -12.0, 0.000012, 123400.0)]
    ['0.871', '-12', '1.2e-05', '1.234e05']
    """
    return f"{number + 0.0:.{DIGITS}g}".replace("e+", "e")  # -0.0 + 0.0 is 0.0


def cut(number: float) -> float:
    """The greatest number with at most four significant digits that is not greater than `number`.

    >>> cut(0.73339), cut(-0.73331), cut(0.871)
    (0.7333, -0.7334, 0.871)
    """
    exact = Decimal(repr(number))
    return float(exact.quantize(Decimal(1).scaleb(exact.adjusted() - DIGITS + 1), ROUND_FLOOR)) if exact else 0.0


def short(item: Item) -> float:
    """A finite number with at most four significant digits.

    Raises:
        InputError: the value is none.
    """
    number = item.number()
    if float(number_text(number)) != number:
        raise item.error(f"a number with at most {DIGITS} significant digits, such as {number_text(number)}")
    return number + 0.0


def _reads(read: Callable[[Item], Any], **schema: Any) -> Reads:
    """A value that a function reads, with its JSON Schema."""
    return Reads(read, lambda _names: schema)


Short = Annotated[float, _reads(short, type="number")]
_PATH = {"type": "string", "minLength": 1, "examples": ["mission.cruise_mps"]}
Path = Annotated[str, _reads(lambda item: qualified(item.text(), item), **_PATH)]


_TAKES = dict.fromkeys(Shape, ()) | {Shape.NORMAL: ("mean", "sd"), Shape.TRIANGULAR: ("mode",)}
"""What each distribution needs besides its ends."""


@dataclass(frozen=True)
class Drawn:
    """A number between two ends.

    Attributes:
        path: path of the number, such as mission.cruise_mps of world.yaml, vehicle.mass_kg, sensors.battery.charge.
        low: lower end, at most four significant digits.
        high: upper end, at most four significant digits.
        unit: unit of the number.
        benign: the number of a situation in which the axis is 0; of a free axis the one that the documents have.
        shape: how the number is distributed: uniform, log-uniform, normal or triangular.
        mean: of a normal distribution before it is cut off at both ends.
        sd: standard deviation of a normal distribution before it is cut off.
        mode: the likeliest number of a triangular distribution, between both ends.
        item: the entry `set`, for the places of errors.
    """

    path: Annotated[Path, Called("set")]
    low: Annotated[Short, Called("from")]
    high: Annotated[Short, Called("to")]
    unit: Annotated[str, Examples("m/s")]
    benign: Short
    shape: Annotated[Shape, Called("distribution")]
    mean: float | None = field(default=None, kw_only=True)
    sd: MoreThanZero | None = field(default=None, kw_only=True)
    mode: float | None = field(default=None, kw_only=True)
    item: Annotated[Item, Given(lambda item: item.need("set"))] = field(kw_only=True)
    CONDITIONS: ClassVar[Mapping[str, object]] = {
        "allOf": [
            {
                "if": {"properties": {"distribution": {"const": shape.value}}, "required": ["distribution"]},
                "then": {
                    "required": list(takes),
                    "properties": {key: False for key in ("mean", "sd", "mode") if key not in takes},
                },
            }
            for shape, takes in _TAKES.items()
        ]
    }

    def quantile(self, share: float) -> float:
        """The number that a draw falls below with the probability `share`, 0 to 1."""
        if share <= 0.0 or share >= 1.0:
            return self.low if share <= 0.0 else self.high
        low, width = self.low, self.high - self.low
        match self.shape:
            case Shape.UNIFORM:
                number = low + share * width
            case Shape.LOG_UNIFORM:
                number = low * math.exp(share * math.log(self.high / low))
            case Shape.TRIANGULAR:
                below = ((self.mode or 0.0) - low) / width  # the share of the draws below the mode
                if share <= below:
                    number = low + math.sqrt(share * below) * width
                else:
                    number = self.high - math.sqrt((1.0 - share) * (1.0 - below)) * width
            case Shape.NORMAL:
                normal = NormalDist(self.mean or 0.0, self.sd or 1.0)
                first, last = normal.cdf(low), normal.cdf(self.high)
                number = normal.inv_cdf(first + share * (last - first))
        return min(max(number, self.low), self.high)

    def contradictions(self, item: Item) -> Iterator[InputError]:
        """Refuse ends that are none, and a distribution that lacks a number or leaves nothing between them."""
        if self.low >= self.high:
            yield item.need("to").error(f"> {number_text(self.low)}, which is 'from'")
            return
        takes = _TAKES[self.shape]
        for key in ("mean", "sd", "mode"):
            entry = item.get(key)
            if key in takes and entry is None:
                yield InputError(f"{item.place}: {item.name} lacks the key {key!r}: {attributes_of(Drawn)[key]}")
            elif key not in takes and entry is not None:
                yield InputError(f"{entry.place}: unknown key {key!r} in {item.name}: it is {self.shape.value}")
        if self.shape is Shape.LOG_UNIFORM and self.low <= 0.0:
            yield item.need("from").error("> 0, because the distribution is log-uniform")
        if self.mode is not None and not self.low <= self.mode <= self.high:
            yield item.need("mode").error(f">= {self.low:g} and <= {self.high:g}")
        if self.shape is Shape.NORMAL and self.mean is not None and self.sd is not None:
            normal = NormalDist(self.mean, self.sd)
            if normal.cdf(self.high) - normal.cdf(self.low) < LEAST_MASS:
                left = f"nearer: sd={self.sd:g} leaves less than {LEAST_MASS:g} of the distribution in the range"
                yield item.need("mean").error(left)


@dataclass(frozen=True)
class Range(Drawn):
    """A range of one number.

    Attributes:
        bins: number of parts of the same probability, each one value of the grid.  The bin of the benign number has the
            id 0, the other bins have 1, 2, ... from the lowest to the highest.
    """

    bins: Annotated[int, Bounds(least=2, most=MOST_BINS), Examples(4)]

    @cached_property
    def edges(self) -> tuple[float, ...]:
        """Ends of the bins, ascending, one more than bins; a bin holds its lower end, the last bin both ends."""
        shares = (place / self.bins for place in range(self.bins + 1))
        return tuple(float(number_text(self.quantile(share))) for share in shares)

    def contradictions(self, item: Item) -> Iterator[InputError]:
        """Refuse bins that are empty, and a benign number outside the range."""
        faults = list(super().contradictions(item))
        yield from faults
        if faults:
            return
        if any(above <= below for below, above in pairwise(self.edges)):
            yield item.need("bins").error(f"less: two ends of bins are equal at {DIGITS} significant digits")
        if not self.low <= self.benign <= self.high:
            within = f"{number_text(self.low)} to {number_text(self.high)}"
            yield item.need("benign").error(f"{within}, within the range")

    @property
    def ids(self) -> tuple[int, ...]:
        """The ids of the bins, from the lowest to the highest bin."""
        benign = self._place(self.benign)
        return tuple(0 if place == benign else place + (place < benign) for place in range(len(self.edges) - 1))

    def ends(self, bin_: int) -> tuple[float, float]:
        """The ends of the bin with this id."""
        place = self.ids.index(bin_)
        return self.edges[place], self.edges[place + 1]

    def bin(self, number: float) -> int | None:
        """The id of the bin that holds a number; None for a number outside the range."""
        return self.ids[self._place(number)] if self.edges[0] <= number <= self.edges[-1] else None

    def _place(self, number: float) -> int:
        return min(bisect_right(self.edges, number), len(self.edges) - 1) - 1

    def draw(self, bin_: int, share: float) -> float:
        """The number of a bin below which the share `share` of the bin's draws falls, 0 <= share < 1."""
        low, high = self.ends(bin_)
        place, bins = self.ids.index(bin_), len(self.edges) - 1
        most = high if place == bins - 1 else nextafter(high, -inf)
        return cut(min(max(self.quantile((place + share) / bins), low), most))

    def middle(self, bin_: int) -> float:
        """The number of a bin in the grid: the median of the bin, or the benign number."""
        return self.benign if bin_ == 0 else self.draw(bin_, 0.5)

    def title(self, bin_: int) -> str:
        """The bin in words, such as `0.5 to 0.7333 m/s`."""
        low, high = self.ends(bin_)
        return f"{number_text(low)} to {number_text(high)} {self.unit}"

    def told(self, number: float) -> str:
        """A number with its unit."""
        return f"{number_text(number)} {self.unit}"

    def value(self, bin_: int, number: float, title: str, realised: str, place: str) -> AxisValue:
        """The value of an axis that sets the number, which `realised` calls `number`."""
        formula = _NUMBER.sub(f"{Decimal(number_text(number)):f}", realised)
        return AxisValue(bin_, title, {self.path: replace(self.item, value=number)}, formula, place)


MOST_VALUES = 200
"""Most values of an axis; the world of each is read with the study."""

MET = "a formula over signals that says when a flight has met the value, as in eventually(light <= 0.05)"
"""What `realised` is, for those who left it out."""

AXIS_ID = "[A-Z][a-z]*"
_DRAWN = r"=(-?[0-9]+(?:\.[0-9]+)?(?:e-?[0-9]{1,3})?)"
_LEVEL = re.compile(rf"([A-Z][a-z]*)(?:([0-9]{{1,9}})(?:{_DRAWN})?|{_DRAWN})")
_NUMBER = re.compile(r"\bnumber\b")
"""The word in the formula of a range that stands for the number that is flown."""


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


Realised = Annotated[str, Examples("eventually(person_sight_m <= 3)")]
Formula = Annotated[str, Given(lambda item: (item.get("realised") or item).place)]
"""`file:line` of the formula, or of the entry without one."""
_STACK = {"pattern": "^(?!stack(\\.|$))"}
_CHANGES = {"propertyNames": _STACK, "examples": [{"bodies.person.present": True}, {"light": 0.003}]}
Changes = Annotated[
    Mapping[str, Item],
    _reads(lambda item: {qualified(path, at): at for path, at in item.mapping().items()}, type="object", **_CHANGES),
]


@dataclass(frozen=True, eq=False)
class AxisValue:
    """A value of an axis; ids count from 0, the benign value, which a flight meets that meets no other.

    Attributes:
        id: place in the list; it stands in keys, as in T1.
        title: name of the value in tables.
        changes: what the value changes: new values by path, such as mission.cruise_mps of world.yaml, vehicle.mass_kg.
        realised: formula over the flight log: whether a flight met the value; of every value but the benign one.
        place: `file:line` of the formula, or of the value without one.
    """

    id: Whole
    title: Annotated[str, Examples("dark")]
    changes: Annotated[Changes, Called("set")] = field(default_factory=dict)
    realised: Realised = ""
    place: Formula = ""
    CONDITIONS: ClassVar[Mapping[str, object]] = {
        "if": {"properties": {"id": {"const": 0}}},
        "then": {"properties": {"realised": False}},
        "else": {"required": ["realised"]},
    }


@dataclass(frozen=True, eq=False)
class Axis:
    """One axis of the situation grid.

    Attributes:
        id: a capital letter, then small letters, as in the key.
        title: name of the axis in tables.
        category: category of the axis in the operational domain model.
        values: values of the axis, of a range its bins; the benign value is first.
        range: the range of the axis; None for an axis with single values.
        realised: formula of the range, with the word `number` for the number that is flown; "" without a range.
        place: `file:line` of that formula.
    """

    id: str
    title: str
    category: str
    values: tuple[AxisValue, ...]
    range: Range | None = None
    realised: str = ""
    place: str = ""

    def value(self, level: int, number: float | None = None) -> AxisValue:
        """The value with this id; with a number the value of that number, which lies in the bin."""
        if self.range is not None and number is not None:
            return self.range.value(level, number, self.range.told(number), self.realised, self.place)
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
class _Named:
    """What every axis has.

    Attributes:
        title: name of the axis in tables.
        category: category of the operational design domain.
    """

    id: Key
    title: Annotated[str, Examples("lighting condition")]
    category: Annotated[str, Examples("environment, light level")]


@dataclass(frozen=True)
class AxisOfValues(_Named):
    """An axis with single values.

    Attributes:
        values: the values, the benign one first.
    """

    values: Annotated[tuple[AxisValue, ...], Size(0, MOST_VALUES)]

    def contradictions(self, item: Item) -> Iterator[InputError]:
        """Refuse ids that do not count from 0, and a value that no formula, or two, can tell from the benign one."""
        for number, (value, entry) in enumerate(zip(self.values, item.need("values"), strict=True)):
            if value.id != number:
                yield entry.need("id").error(f"{number}: ids count from 0, the benign value")
            elif number == 0 and value.realised:
                sentence = f"value {self.id}0 must not have the key 'realised': it changes nothing"
                yield InputError(f"{value.place}: {sentence}")
            elif number != 0 and not value.realised:
                yield InputError(f"{entry.place}: value {self.id}{number} lacks the key 'realised': {MET}")
        if len(self.values) < 2:
            yield InputError(f"{item.need('values').place}: axis {self.id!r} must have at least 2 values")

    @property
    def axis(self) -> Axis:
        """The axis."""
        return Axis(self.id, self.title, self.category, self.values)


@dataclass(frozen=True)
class AxisOfRange(_Named):
    """An axis that is a range of one number.

    Attributes:
        range: the range.
        realised: a formula over signals that says when a flight has met the number, which the word `number` stands for.
    """

    range: Range
    realised: Realised
    place: Formula

    @property
    def axis(self) -> Axis:
        """The axis."""
        own, formula = self.range, (self.realised, self.place)
        bins = tuple(own.value(bin_, own.middle(bin_), own.title(bin_), *formula) for bin_ in sorted(own.ids))
        return Axis(self.id, self.title, self.category, bins, own, *formula)


AxisModel = Annotated[AxisOfValues | AxisOfRange, Either("an axis with either 'values' or 'range'")]


def _value_ids(item: Item) -> frozenset[int]:
    """One id of a value, or a list of ids."""
    entries = item.items() if isinstance(item.value, tuple) else (item,)
    numbers = frozenset(entry.whole() for entry in entries)
    if not numbers:
        raise item.error("the id of a value, or a list of ids")
    return numbers


_ID: Mapping[str, Any] = {"type": "integer", "description": "id of a value", "minimum": 0, "examples": [1]}
_IDS = [_ID, {"type": "array", "items": _ID, "minItems": 1}]
ValueIds = Annotated[frozenset[int], _reads(_value_ids, description="id of a value, or a list of ids", anyOf=_IDS)]


def _single_values(item: Item) -> dict[str, Item]:
    for entry in item.mapping().values():
        if isinstance(entry.value, dict | tuple):
            raise entry.error("a single value")
    return {qualified(path, entry): entry for path, entry in item.mapping().items()}


_ALSO = _reads(_single_values, type="object", examples=[{"happenings.dust.active": True}])
DEVIATES = 1 / 3
"""The chance that a free axis is off its benign value in a situation drawn at random: else nearly all would be off."""


@dataclass(frozen=True, eq=False)
class FreeAxis(Drawn):
    """A number around the situations of the grid: benign, or anywhere in its range.

    Attributes:
        id: a capital letter, then small letters, as in the key.
        title: name of the axis in tables.
        category: category of the operational design domain.
        also: what else a number off the benign value sets, by path.
        only_with: values of other axes without which the number has no effect or cannot be, by axis.
    """

    id: Key
    title: Annotated[str, Examples("cruise speed")]
    category: str
    also: Annotated[Mapping[str, Item], _ALSO] = field(default_factory=dict, kw_only=True)
    only_with: Mapping[str, ValueIds] = field(default_factory=dict, kw_only=True)

    def holds(self, number: float) -> bool:
        """Whether the number is in the range."""
        return self.low <= number <= self.high

    def goes_with(self, levels: Mapping[str, int]) -> bool:
        """Whether a situation with these values may have a number of this axis."""
        return all(levels.get(axis) in values for axis, values in self.only_with.items())

    def at(self, share: float) -> float:
        """The number below which the share `share` of the draws falls, 0 <= share < 1."""
        return max(cut(self.quantile(share)), self.low)

    def drawn(self, share: float) -> float | None:
        """The number of a situation drawn at random; None, the benign value, for most shares 0 <= share < 1."""
        return self.at((share - 1 + DEVIATES) / DEVIATES) if share >= 1 - DEVIATES else None

    def told(self, number: float) -> str:
        """A number in words, such as `cruise speed 0.871 m/s`."""
        return f"{self.title} {number_text(number)} {self.unit}"

    def value(self, number: float) -> AxisValue:
        """What a number off the benign value sets."""
        item = replace(self.item, value=number)
        return AxisValue(0, self.told(number), {self.path: item, **self.also}, "", self.item.place)

    @property
    def extremes(self) -> tuple[AxisValue, AxisValue]:
        """The values at both ends."""
        return self.value(self.low), self.value(self.high)


PARTS = ("world", "vehicle", "sensors")
"""The documents that an axis may change."""


def qualified(path: str, value: Item) -> str:
    """The path with the name of its document in front; a path without one is a path of the world.

    Raises:
        InputError: the path belongs to the stack under test.
    """
    head = path.partition(".")[0]
    if head == "stack":
        sentence = f"{path!r} belongs to the stack under test; an axis may change {', '.join(PARTS)}"
        raise InputError(f"{value.place}: {sentence}")
    return path if head in PARTS else f"world.{path}"


def patched(documents: Mapping[str, Item], changes: Mapping[str, Item]) -> dict[str, Item]:
    """Replace values of documents by dotted paths such as `sensors.depth.latency_s`, each with its document's name.

    An entry of a list is addressed by its index.

    Raises:
        InputError: there is no such path; the message begins with the place of the value.
    """
    new = dict(documents)
    for path, value in changes.items():
        name, _, rest = path.partition(".")
        changed = _replaced(new[name], rest.split("."), value) if name in new and rest else None
        if changed is None:
            known = [f"{name}.{inner}" for name, document in documents.items() for inner, _ in leaves(document)]
            raise InputError(f"{value.place}: no path {path!r} in the study{did_you_mean(path, known)}")
        new[name] = changed
    return new


def found(documents: Mapping[str, Item], path: str) -> Item | None:
    """The value at a dotted path with its document's name; None where there is none."""
    name, _, rest = path.partition(".")
    if name not in documents:
        return None
    return next((item for inner, item in leaves(documents[name]) if inner == rest), None)


def overlap(first: str, second: str) -> bool:
    """Whether two paths are one, or one is a part of the other."""
    return f"{first}.".startswith(f"{second}.") or f"{second}.".startswith(f"{first}.")


def _replaced(item: Item, parts: Sequence[str], value: Item) -> Item | None:
    if not parts:
        return Item(value.path, value.line, item.name, value.value)
    if isinstance(item.value, dict):
        # A key may contain dots; the longest matching key wins.
        for length in range(len(parts), 0, -1):
            key = ".".join(parts[:length])
            if key in item.value:
                inner = _replaced(item.value[key], parts[length:], value)
                return inner and Item(item.path, item.line, item.name, {**item.value, key: inner})
    if isinstance(item.value, tuple) and parts[0].isdigit() and int(parts[0]) < len(item.value):
        number = int(parts[0])
        inner = _replaced(item.value[number], parts[1:], value)
        return inner and Item(item.path, item.line, item.name, (*item.value[:number], inner, *item.value[number + 1 :]))
    return None


def leaves(item: Item, path: str = "") -> Iterator[tuple[str, Item]]:
    """Yield the dotted path and the item of every scalar in a document."""
    if isinstance(item.value, dict):
        for key, entry in item.value.items():
            yield from leaves(entry, f"{path}.{key}" if path else key)
    elif isinstance(item.value, tuple):
        for number, entry in enumerate(item.value):
            yield from leaves(entry, f"{path}.{number}" if path else str(number))
    else:
        yield path, item


def added(documents: Mapping[str, Item], additions: Item) -> dict[str, Item]:
    """The documents with the entries of `additions`, a mapping of `PARTS` to entries; each keeps its own place.

    Raises:
        InputError: an entry belongs to another document, or exists already.
    """
    new = dict(documents)
    for name, entries in additions.mapping().items():
        if name not in PARTS:
            raise InputError(f"{entries.place}: no document {name!r} to add to{did_you_mean(name, PARTS)}")
        new[name] = _joined(new[name], entries, name)
    return new


def _joined(item: Item, more: Item, path: str) -> Item:
    entries = dict(item.mapping())
    for key, entry in more.mapping().items():
        inner = f"{path}.{key}"
        if key not in entries:
            entries[key] = entry
        elif isinstance(entries[key].value, dict) and isinstance(entry.value, dict):
            entries[key] = _joined(entries[key], entry, inner)
        else:
            raise InputError(f"{entry.place}: {inner} exists already; an axis changes it with `set`")
    return Item(item.path, item.line, item.name, entries)
