"""Part of a whole, with Wilson's interval for display and Clopper and Pearson's for a safety case."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from scaloft_fi.results.scoring.exact import clopper_pearson

Z95 = 1.959963984540054
"""97.5 % quantile of the normal distribution: two-sided 95 %."""


def wilson(part: int, whole: int, z: float = Z95) -> tuple[float, float]:
    """Wilson's score interval of a share, within [0, 1] and around the estimate (Wilson, JASA 22, 1927).

    >>> [round(bound, 2) for bound in wilson(0, 10)]
    [0.0, 0.28]

    Raises:
        ValueError: not 0 <= part <= whole, or whole is 0.
    """
    if not 0 <= part <= whole or whole == 0:
        raise ValueError(f"{part} of {whole} is no share")
    share = part / whole
    scale = 1 + z * z / whole
    centre = (share + z * z / (2 * whole)) / scale
    half = z / scale * math.sqrt(share * (1 - share) / whole + z * z / (4 * whole * whole))
    return min(share, max(0.0, centre - half)), max(share, min(1.0, centre + half))


@dataclass(frozen=True)
class Ratio:
    """`part` of `whole`; 0 of 0 is not a number and prints as n/a.

    >>> str(Ratio(8, 15)), Ratio(8, 15).short, str(Ratio(0, 0))
    ('8/15 = 53 % [30, 75]', '8/15 [30, 75]', '0/0 = n/a')
    """

    part: int
    whole: int

    def __post_init__(self) -> None:
        if not 0 <= self.part <= self.whole:
            raise ValueError(f"{self.part} of {self.whole} is no share")

    @property
    def value(self) -> float | None:
        """The share 0..1, None for 0 of 0."""
        return self.part / self.whole if self.whole else None

    @property
    def interval(self) -> tuple[float, float] | None:
        """Wilson's 95 % interval, None for 0 of 0."""
        return wilson(self.part, self.whole) if self.whole else None

    @property
    def exact(self) -> tuple[float, float] | None:
        """Clopper and Pearson's 95 % interval, None for 0 of 0: it covers at least that often, whatever the share."""
        return clopper_pearson(self.part, self.whole) if self.whole else None

    @property
    def plain(self) -> str:
        """Without the interval: `8/15 = 53 %`, for a share of a closed list, which is no sample of anything."""
        return f"{self.part}/{self.whole} = " + ("n/a" if self.value is None else f"{100 * self.value:.0f} %")

    @property
    def short(self) -> str:
        """Without the share, which part and whole say: `8/15 [30, 75]`."""
        return f"{self.part}/{self.whole} {self._brackets}" if self.whole else self.plain

    def __str__(self) -> str:
        return f"{self.plain} {self._brackets}" if self.whole else self.plain

    @property
    def _brackets(self) -> str:
        low, high = self.interval or (0.0, 1.0)
        return f"[{100 * low:.0f}, {100 * high:.0f}]"


def share_json(ratio: Ratio) -> dict[str, int]:
    """Part and whole."""
    return {"part": ratio.part, "whole": ratio.whole}


def ratio_json(ratio: Ratio) -> dict[str, Any]:
    """A ratio with Wilson's interval, null for 0 of 0."""
    return {**share_json(ratio), "interval": list(ratio.interval) if ratio.interval else None}
