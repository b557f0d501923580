"""Choose the next magnitudes of a margin search: a pure function of the results so far."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from scaloft_fi.analysis.margin import Scale, margin_of
from scaloft_fi.analysis.survivor import Reaction, Tried

WIDENINGS = 3
"""Greatest number of magnitudes beyond each end of the ladder; each is half or twice the one before.

Far beyond its strong end a fault becomes another fault; far below its mild end it has no effect.
"""
DIGITS = range(3, 7)
"""Significant digits of a magnitude: as few as separate it from its neighbours, at most as many as an id holds."""


@dataclass(frozen=True)
class Search:
    """A margin search.

    Attributes:
        scale: order of the magnitudes.
        ladder: ladder of the study, mild to strong; all of it is flown, to detect a response that is not monotone.
        allowed: whether the operator accepts a magnitude.
        least, most: bounds of the operator in the ladder's unit.
        tolerance: greatest width of the final interval [the ladder's unit]; None = a tenth of its strong end.
    """

    scale: Scale
    ladder: Sequence[float]
    allowed: Callable[[float], bool] = lambda _magnitude: True
    least: float = -math.inf
    most: float = math.inf
    tolerance: float | None = None

    def asks(self, tried: Mapping[float, Tried]) -> tuple[float, ...]:
        """The magnitudes to fly next in a situation with the results `tried`; none when the search is over.

        A magnitude with a violation in most flights counts as killed for the search, even if it is undecided.
        """
        missing = tuple(rung for rung in self.ladder if rung not in tried)
        if missing:
            return missing
        if all(entry.reaction is Reaction.UNTESTED for entry in tried.values()):
            return ()
        margin = margin_of(self.scale, tried.values())
        if margin.end is None:
            candidates = self._stronger(tried) if margin.survives is not None else iter(())
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
        """The middle of the interval in as few digits as possible; twice the survivor if the end is infinite."""
        middle = survives + (end - survives) / 2
        if math.isinf(end):
            middle = 2 * survives
        low, high = sorted((survives, end))
        # an operator with a whole-number argument accepts only the number rounded down
        rounded = [float(f"{middle:.{digits}g}") for digits in DIGITS] + [float(math.floor(middle))]
        return (m for m in rounded if low < m < high)

    def _stronger(self, tried: Mapping[float, Tried]) -> Iterator[float]:
        """Beyond the strong end: twice the distance from the neutral magnitude, or half where smaller is stronger."""
        end = max(tried, key=self.scale.strength)
        if self._beyond(tried, self.ladder[-1], 1) >= WIDENINGS:
            return iter(())
        if self.scale.sign < 0:
            return iter(_short(max(end / 2, self.least)))
        start = self.scale.neutral or 0.0
        return iter(_short(min(start + 2 * (end - start), self.most)))

    def _milder(self, tried: Mapping[float, Tried], end: float) -> Iterator[float]:
        """Below the mild end: half the distance from the neutral magnitude; twice the magnitude if smaller is worse."""
        if self._beyond(tried, self.ladder[0], -1) >= WIDENINGS:
            return iter(())
        if self.scale.neutral is not None:
            return iter(_short(self.scale.neutral + (end - self.scale.neutral) / 2))
        return iter(_short(max(end / 2, self.least) if self.scale.sign > 0 else min(2 * end, self.most)))

    def _beyond(self, tried: Mapping[float, Tried], end: float, way: int) -> int:
        return sum(way * (self.scale.strength(m) - self.scale.strength(end)) > 0 for m in tried)


def _short(magnitude: float) -> list[float]:
    """The magnitude with three digits, and rounded down for operators with a whole-number argument."""
    if not math.isfinite(magnitude):
        return []
    return [float(f"{magnitude:.3g}"), float(math.floor(magnitude))]
