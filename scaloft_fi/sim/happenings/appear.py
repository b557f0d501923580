"""A body that appears, such as a rock that falls."""

from __future__ import annotations

from dataclasses import dataclass

from scaloft_fi.document import Item
from scaloft_fi.sim.happenings.happening import Effect, Surroundings
from scaloft_fi.sim.happenings.kinds import HAPPENINGS, HappeningKind
from scaloft_fi.sim.happenings.walk import check_body

HIDDEN_M = (0.0, 0.0, -1000.0)
"""Shift of a body that has not appeared: under the mine, out of every sensor's range [m]."""


@dataclass(frozen=True)
class Appear(Effect):
    """The body `body` is not there before the start; it stays when the happening ends."""

    body: str

    @property
    def moved(self) -> str:
        """The body."""
        return self.body

    @classmethod
    def read(cls, item: Item) -> Appear:
        """Read it."""
        return cls(item.need("body").text())

    def prepare(self, around: Surroundings) -> None:
        """Hide the body at take-off."""
        around.shift(self.body, HIDDEN_M)

    def apply(self, around: Surroundings, since_s: float) -> None:
        """Put the body at its position."""
        around.shift(self.body, (0.0, 0.0, 0.0))


HAPPENINGS.declare(
    "appear", HappeningKind(Appear.read, check=lambda effect, world, item: check_body(effect.body, world, item))
)
