"""Part of a whole.  The wholes here are closed lists (cells, mutants, situations), samples of nothing: no intervals."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Ratio:
    """`part` of `whole`; 0 of 0 is not a number and prints as n/a.

    >>> str(Ratio(8, 15)), Ratio(8, 15).short, str(Ratio(0, 0))
    ('8/15 = 53 %', '8/15', '0/0 = n/a')
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
    def short(self) -> str:
        """Without the share, which part and whole say: `8/15`."""
        return f"{self.part}/{self.whole}"

    def __str__(self) -> str:
        return f"{self.short} = " + ("n/a" if self.value is None else f"{100 * self.value:.0f} %")
