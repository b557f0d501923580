"""Battery fail-safe: return when low, land when critical, as PX4's low-battery actions do."""

from __future__ import annotations

from dataclasses import dataclass

from scaloft_fi.stack.messages import Battery
from scaloft_fi.stack.reference.messages import Failsafe


@dataclass(frozen=True)
class BatteryConfig:
    """Thresholds.

    Attributes:
        low_charge: state of charge at which to return (PX4 BAT_LOW_THR 0.15).
        critical_charge: state of charge at which to land (PX4 BAT_CRIT_THR 0.07).
        empty_cell_v: voltage of an empty cell [V]; below it the pack counts as empty, whatever the gauge says.
        lost_s: no telemetry for so long counts as an empty pack [s].
    """

    low_charge: float
    critical_charge: float
    empty_cell_v: float
    lost_s: float


class BatteryMonitor:
    """Watches the telemetry; asks for each action once."""

    def __init__(self, config: BatteryConfig) -> None:
        self.config = config
        self._heard_s = 0.0
        self._asked = ""

    def hear(self, now_s: float, battery: Battery | None) -> Failsafe | None:
        """What to ask of the mission now."""
        config = self.config
        wanted = ""
        if battery is not None:
            self._heard_s = now_s
            cell_v = battery.voltage_v / max(1, battery.cells)
            if cell_v < config.empty_cell_v or battery.charge <= config.critical_charge:
                wanted = "land"
            elif battery.charge <= config.low_charge:
                wanted = "return"
        elif now_s - self._heard_s > config.lost_s:
            wanted = "land"
        if not wanted or wanted == self._asked or self._asked == "land":
            return None
        self._asked = wanted
        return Failsafe(now_s, wanted)
