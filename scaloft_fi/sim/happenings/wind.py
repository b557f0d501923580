"""Wind: ventilation that blows all the time, or a gust."""

from __future__ import annotations

import math
from dataclasses import dataclass

from scaloft_fi.document import Item
from scaloft_fi.sim.happenings.happening import Effect, Surroundings
from scaloft_fi.sim.happenings.kinds import HAPPENINGS, HappeningKind

MOST_MPS = 30.0


@dataclass(frozen=True)
class Wind(Effect):
    """Wind, the same everywhere [m/s, world]; its force is the vehicle's drag times the velocity."""

    velocity_mps: tuple[float, float, float]

    @property
    def top_wind_mps(self) -> float:
        """The speed of the wind [m/s]."""
        return math.hypot(*self.velocity_mps)

    @classmethod
    def read(cls, item: Item) -> Wind:
        """Read it."""
        velocity = item.need("velocity_mps")
        x, y, z = velocity.numbers(3)
        if max(abs(x), abs(y), abs(z)) > MOST_MPS:
            raise velocity.error(f"3 numbers from -{MOST_MPS:g} to {MOST_MPS:g}")
        return cls((x, y, z))

    def apply(self, around: Surroundings, since_s: float) -> None:
        """Add to the wind."""
        x, y, z = self.velocity_mps
        around.wind_mps += self.velocity_mps
        around.note(wind_x_mps=x, wind_y_mps=y, wind_z_mps=z)


HAPPENINGS.declare("wind", HappeningKind(Wind.read, signals=("wind_x_mps", "wind_y_mps", "wind_z_mps")))
