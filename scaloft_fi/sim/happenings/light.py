"""Light that changes: a lamp fails, or goes on."""

from __future__ import annotations

from dataclasses import dataclass

from scaloft_fi.document import Item
from scaloft_fi.sim.happenings.happening import Effect, Surroundings
from scaloft_fi.sim.happenings.kinds import HAPPENINGS, HappeningKind


@dataclass(frozen=True)
class Light(Effect):
    """The visible light becomes `light`, 0..1."""

    light: float

    @classmethod
    def read(cls, item: Item) -> Light:
        """Read it."""
        return cls(item.need("light").number(least=0.0, most=1.0))

    def apply(self, around: Surroundings, since_s: float) -> None:
        """Set the light; of two that last at the same time, the later one in the file decides."""
        around.light = self.light


HAPPENINGS.declare("light", HappeningKind(Light.read))
