"""Situations and the axes that span their grid: values, ranges cut into bins, excluded combinations, free axes.

The quantiles are closed forms, because `scipy.stats` takes longer to import than a verb that reads results may take;
the tests compare them with `scipy.stats`.

A number has at most four significant digits and is written so in the key of a situation: the written number is the
number that is flown.

At its benign value a free axis changes nothing and is left out of the key, so `T1O0W0D0H1` names the same flight with
and without it.  Another number stands at the end of the key: `T1O0W0D0H1Cs=0.871`.
"""

from __future__ import annotations

import math
import re
from bisect import bisect_right
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from decimal import ROUND_FLOOR, Decimal
from enum import StrEnum
from itertools import pairwise
from math import inf, isfinite, nextafter

from scaloft_fi.document import Item
from scaloft_fi.errors import InputError, did_you_mean
from scaloft_fi.sim.patch import found, overlap, qualified

LEAST_MASS = 1e-6
"""A normal distribution must leave this much of itself between the ends; with less, quantiles are inexact."""


class Shape(StrEnum):
    """The known distributions."""

    UNIFORM = "uniform"
    LOG_UNIFORM = "log-uniform"
    NORMAL = "normal"
    TRIANGULAR = "triangular"


@dataclass(frozen=True)
class Distribution:
    """A distribution between `low` and `high`.

    Attributes:
        shape: one of `Shape`.
        low, high: the ends, in the unit of the number.
        centre: mean of the normal distribution before it is truncated, mode of the triangular one.
        sd: standard deviation of the normal distribution before it is truncated.
    """

    shape: Shape
    low: float
    high: float
    centre: float = 0.0
    sd: float = 1.0

    def quantile(self, share: float) -> float:
        """The number that a draw falls below with the probability `share`, 0 to 1.

        >>> Distribution(Shape.TRIANGULAR, 0.0, 1.0, centre=1.0).quantile(0.25)
        0.5
        """
        if share <= 0.0 or share >= 1.0:
            return self.low if share <= 0.0 else self.high
        return min(max(self._inside(share), self.low), self.high)

    def _inside(self, share: float) -> float:
        low, width = self.low, self.high - self.low
        match self.shape:
            case Shape.UNIFORM:
                return low + share * width
            case Shape.LOG_UNIFORM:
                return low * math.exp(share * math.log(self.high / low))
            case Shape.TRIANGULAR:
                below = (self.centre - low) / width  # the share of the draws below the mode
                if share <= below:
                    return low + math.sqrt(share * below) * width
                return self.high - math.sqrt((1.0 - share) * (1.0 - below)) * width
            case Shape.NORMAL:
                from statistics import NormalDist

                normal = NormalDist(self.centre, self.sd)
                first, last = normal.cdf(low), normal.cdf(self.high)
                return normal.inv_cdf(first + share * (last - first))


def read_distribution(item: Item, low: float, high: float) -> Distribution:
    """Read the distribution of a range: `distribution`, and `mean` and `sd`, or `mode`.

    Raises:
        InputError: the distribution is unknown, lacks a number, or leaves nothing between the ends.
    """
    shape_item = item.need("distribution", f"one of {', '.join(Shape)}")
    shape = Shape(shape_item.choice(tuple(Shape)))
    if shape is Shape.LOG_UNIFORM and low <= 0.0:
        raise item.need("from").error("> 0, because the distribution is log-uniform")
    if shape is Shape.TRIANGULAR:
        return Distribution(shape, low, high, item.need("mode").number(least=low, most=high))
    if shape is not Shape.NORMAL:
        return Distribution(shape, low, high)
    mean_item, sd_item = item.need("mean"), item.need("sd")
    mean, sd = finite(mean_item), finite(sd_item)
    if sd <= 0.0:
        raise sd_item.error("> 0")
    from statistics import NormalDist

    normal = NormalDist(mean, sd)
    if normal.cdf(high) - normal.cdf(low) < LEAST_MASS:
        raise mean_item.error(f"nearer: sd={sd:g} leaves less than {LEAST_MASS:g} of the distribution in the range")
    return Distribution(shape, low, high, mean, sd)


def finite(item: Item) -> float:
    """A finite number.

    Raises:
        InputError: the value is none.
    """
    number = item.number()
    if not math.isfinite(number):
        raise item.error("a finite number")
    return number


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


@dataclass(frozen=True)
class Range:
    """A range of one number.

    Attributes:
        path: dotted path of the number, which begins with `world`, `vehicle` or `sensors`.
        unit: its unit.
        distribution: its distribution.
        edges: ends of the bins, ascending, one more than bins; a bin holds its lower end, the last bin both ends.
        benign: the benign number; its bin has the id 0, the other bins have 1, 2, ... from the lowest to the highest.
        item: the entry `set`, for the places of errors.
    """

    path: str
    unit: str
    distribution: Distribution
    edges: tuple[float, ...]
    benign: float
    item: Item

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
        return cut(min(max(self.distribution.quantile((place + share) / bins), low), most))

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


def read_range(item: Item) -> Range:
    """Read one range.

    Raises:
        InputError: a value is not allowed, or a key is unknown.
    """
    set_item, low_item, high_item = item.need("set"), item.need("from"), item.need("to")
    path = qualified(set_item.text(), set_item)
    low, high = short(low_item), short(high_item)
    if low >= high:
        raise high_item.error(f"> {number_text(low)}, which is 'from'")
    unit = item.need("unit").text()
    distribution = read_distribution(item, low, high)
    bins_item = item.need("bins")
    bins = bins_item.whole()
    if not 2 <= bins <= MOST_BINS:
        raise bins_item.error(f"2 to {MOST_BINS}")
    edges = _edges(distribution, bins)
    if any(above <= below for below, above in pairwise(edges)):
        raise bins_item.error(f"less: two ends of bins are equal at {DIGITS} significant digits")
    benign_item = item.need("benign", "the number of a situation in which the axis is 0")
    benign = short(benign_item)
    if not low <= benign <= high:
        raise benign_item.error(f"{number_text(low)} to {number_text(high)}, within the range")
    item.close()
    return Range(path, unit, distribution, edges, benign, set_item)


def _edges(distribution: Distribution, bins: int) -> tuple[float, ...]:
    shares: Sequence[float] = [place / bins for place in range(bins + 1)]
    return tuple(float(number_text(distribution.quantile(share))) for share in shares)


def short(item: Item) -> float:
    """A finite number with at most four significant digits.

    Raises:
        InputError: the value is none.
    """
    number = finite(item)
    if float(number_text(number)) != number:
        raise item.error(f"a number with at most {DIGITS} significant digits, such as {number_text(number)}")
    return number + 0.0


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


MOST_CONSTRAINTS = 100
"""Each is compared with every point of the grid."""


@dataclass(frozen=True)
class Constraint:
    """A combination of axis values that is impossible or of no interest.

    Attributes:
        excluded: the excluded values by axis; a point is excluded if it has an excluded value on each of these axes.
        reason: why no situation has the combination.
        place: `file:line` of the constraint.
    """

    excluded: Mapping[str, frozenset[int]]
    reason: str
    place: str

    def forbids(self, levels: Mapping[str, int]) -> bool:
        """Whether the constraint excludes a point with these values.

        >>> Constraint({"T": frozenset({0}), "W": frozenset({1, 2})}, "no room", "").forbids({"T": 0, "W": 2, "H": 0})
        True
        """
        return all(levels[axis] in values for axis, values in self.excluded.items())


def read_constraints(item: Item | None, axes: Iterable[Axis]) -> tuple[Constraint, ...]:
    """Read the list under `constraints`; an absent list gives no constraints.

    Raises:
        InputError: a constraint names an unknown axis or value, names fewer than two axes, or lacks its reason.
    """
    known = {axis.id: axis for axis in axes}
    return tuple(_constraint(entry, known) for entry in item.items(most=MOST_CONSTRAINTS)) if item else ()


def _constraint(item: Item, axes: Mapping[str, Axis]) -> Constraint:
    excluded_item = item.need("exclude")
    excluded = {name: _excluded_values(name, entry, axes) for name, entry in excluded_item.mapping().items()}
    if len(excluded) < 2:
        raise InputError(
            f"{excluded_item.place}: exclude must name the values of at least 2 axes; "
            "to exclude a single value, remove it from its axis"
        )
    constraint = Constraint(excluded, item.need("reason").text(), item.place)
    item.close()
    return constraint


def _excluded_values(name: str, item: Item, axes: Mapping[str, Axis]) -> frozenset[int]:
    """The values of one axis in an `exclude`: one value or a list."""
    if name not in axes:
        raise InputError(f"{item.place}: exclude names the unknown axis {name!r}{did_you_mean(name, axes)}")
    return read_values(axes[name], item)


def read_values(axis: Axis, item: Item) -> frozenset[int]:
    """Values of an axis: one id or a list of ids.

    Raises:
        InputError: the axis has no such value.
    """
    last = len(axis.values) - 1
    entries = item.items() if isinstance(item.value, tuple) else (item,)
    numbers = frozenset(entry.whole() for entry in entries)
    if not numbers or max(numbers) > last:
        raise item.error(f"values of axis {axis.id!r}, 0 to {last}")
    return numbers


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
