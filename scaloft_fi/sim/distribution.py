"""Distributions of a number between two ends, by their quantiles.

The quantiles are closed forms, because `scipy.stats` takes longer to import than a verb that reads results may take;
the tests compare them with `scipy.stats`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import StrEnum

from scaloft_fi.document import Item

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
