"""A range of one number: bins of equal probability for the grid, and numbers drawn from its distribution.

A number has at most four significant digits and is written so in the key of a situation: the written number is the
number that is flown.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from decimal import ROUND_FLOOR, Decimal
from itertools import pairwise
from math import inf, nextafter

from scaloft_fi.document import Item
from scaloft_fi.sim.distribution import Distribution, finite, read_distribution
from scaloft_fi.sim.patch import qualified

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
