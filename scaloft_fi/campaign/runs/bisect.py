"""Which magnitude to fly next: a pure function of what the magnitudes flown so far say."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from scaloft_fi.analysis.margin import Scale, margin_of
from scaloft_fi.analysis.tried import Reaction, Tried

WIDENINGS = 3
"""How many magnitudes beyond either end of the ladder are tried, each half or twice the one before.

Beyond its severe end a fault soon becomes another one, and below its mild end none at all.
"""
DIGITS = range(3, 7)
"""Significant digits of a magnitude: as few as it takes to be between two others, as many as an id holds."""


@dataclass(frozen=True)
class Search:
    """What is searched and how finely.

    Attributes:
        scale: order of the magnitudes.
        ladder: of the study, mild to severe; all of it is flown, so that a response that is not monotone shows.
        allowed: whether the operator takes a magnitude.
        least, most: bounds of the operator in the ladder's unit.
        tolerance: widest interval [the ladder's unit] that is not bisected; None = a tenth of its severe end.
    """

    scale: Scale
    ladder: Sequence[float]
    allowed: Callable[[float], bool] = lambda _magnitude: True
    least: float = -math.inf
    most: float = math.inf
    tolerance: float | None = None

    def asks(self, tried: Mapping[float, Tried]) -> tuple[float, ...]:
        """The magnitudes to fly next in a situation where `tried` is known; none when the search is over.

        Where most flights violate, the search goes on as if the magnitude were killed, whether or not they decide.
        """
        missing = tuple(rung for rung in self.ladder if rung not in tried)
        if missing:
            return missing
        if all(entry.reaction is Reaction.UNTESTED for entry in tried.values()):
            return ()
        margin = margin_of(self.scale, tried.values())
        if margin.end is None:
            candidates = self._severer(tried) if margin.survives is not None else iter(())
        elif margin.survives is None:
            candidates = self._milder(tried, margin.end)
        elif self._narrow(margin.survives, margin.end):
            return ()
        else:
            candidates = self._between(margin.survives, margin.end)
        return next(((m,) for m in candidates if m not in tried and self._fits(m)), ())

    def _narrow(self, survives: float, end: float) -> bool:
        if self.tolerance is None:
            return self.scale.close(survives, end)
        return abs(end - survives) <= self.tolerance * (1 + 1e-9)

    def _fits(self, magnitude: float) -> bool:
        return math.isfinite(magnitude) and self.allowed(magnitude)

    def _between(self, survives: float, end: float) -> Iterator[float]:
        """The middle, in as few digits as lie between; twice the survivor where the severe end is infinite."""
        middle = survives + (end - survives) / 2
        if math.isinf(end):
            middle = 2 * survives
        low, high = sorted((survives, end))
        # a whole-number operator takes neither half nor quarter, but the number below
        rounded = [float(f"{middle:.{digits}g}") for digits in DIGITS] + [float(math.floor(middle))]
        return (m for m in rounded if low < m < high)

    def _severer(self, tried: Mapping[float, Tried]) -> Iterator[float]:
        """Beyond the severe end: twice as far from no fault, or half of what gets worse as it shrinks."""
        end = max(tried, key=self.scale.severity)
        if self._beyond(tried, self.ladder[-1], 1) >= WIDENINGS:
            return iter(())
        if self.scale.sign < 0:
            return iter(_short(max(end / 2, self.least)))
        start = self.scale.neutral or 0.0
        return iter(_short(min(start + 2 * (end - start), self.most)))

    def _milder(self, tried: Mapping[float, Tried], end: float) -> Iterator[float]:
        """Below the mild end: half as far from no fault; twice of what is harmless only at infinity."""
        if self._beyond(tried, self.ladder[0], -1) >= WIDENINGS:
            return iter(())
        if self.scale.neutral is not None:
            return iter(_short(self.scale.neutral + (end - self.scale.neutral) / 2))
        return iter(_short(max(end / 2, self.least) if self.scale.sign > 0 else min(2 * end, self.most)))

    def _beyond(self, tried: Mapping[float, Tried], end: float, way: int) -> int:
        return sum(way * (self.scale.severity(m) - self.scale.severity(end)) > 0 for m in tried)


def _short(magnitude: float) -> list[float]:
    """Three digits, and the whole number below for operators that count."""
    if not math.isfinite(magnitude):
        return []
    return [float(f"{magnitude:.3g}"), float(math.floor(magnitude))]
