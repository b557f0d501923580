"""Dust in the air, which camera and detector see through less far."""

from __future__ import annotations

from dataclasses import dataclass

from scaloft_fi.document import Item
from scaloft_fi.sim.happenings.happening import Effect, Surroundings
from scaloft_fi.sim.happenings.kinds import HAPPENINGS, HappeningKind

MOST_PER_M = 10.0
"""Greatest extinction: at 10 per metre a wall half a metre away has less than 1 % of its contrast."""


@dataclass(frozen=True)
class Dust(Effect):
    """Dust: light falls to exp(-haze_per_m * distance) (Beer-Lambert; the contrast of a picture too, Koschmieder 1924).

    The distance of sight (5 % contrast) is 3 / haze_per_m.
    """

    haze_per_m: float

    @classmethod
    def read(cls, item: Item) -> Dust:
        """Read it."""
        return cls(item.need("haze_per_m").number(above=0.0, most=MOST_PER_M))

    def apply(self, around: Surroundings, since_s: float) -> None:
        """Add to the extinction of the air."""
        around.haze_per_m += self.haze_per_m
        around.note(haze_per_m=self.haze_per_m)


HAPPENINGS.declare("dust", HappeningKind(Dust.read, signals=("haze_per_m",)))
