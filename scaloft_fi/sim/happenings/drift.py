"""Localisation that drifts away from the truth."""

from __future__ import annotations

from dataclasses import dataclass

from scaloft_fi.document import Item
from scaloft_fi.sim.happenings.happening import Effect, Surroundings
from scaloft_fi.sim.happenings.kinds import HAPPENINGS, HappeningKind


@dataclass(frozen=True)
class Drift(Effect):
    """Every fix is off by `rate_mps` (3,) [m/s, world] times the time since the start; it jumps back at the end."""

    rate_mps: tuple[float, float, float]

    @classmethod
    def read(cls, item: Item) -> Drift:
        """Read it."""
        x, y, z = item.need("rate_mps").numbers(3)
        return cls((x, y, z))

    def apply(self, around: Surroundings, since_s: float) -> None:
        """Add to the error of the fixes."""
        x, y, z = (rate_mps * since_s for rate_mps in self.rate_mps)
        around.drift_m += (x, y, z)
        around.note(drift_x_m=x, drift_y_m=y, drift_z_m=z)


HAPPENINGS.declare("drift", HappeningKind(Drift.read, signals=("drift_x_m", "drift_y_m", "drift_z_m")))
