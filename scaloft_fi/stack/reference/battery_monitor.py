"""Battery fail-safe: return when low, land when critical, as PX4's low-battery actions do."""

from __future__ import annotations

from dataclasses import dataclass

from scaloft_fi.stack.messages import Battery
from scaloft_fi.stack.reference.messages import Failsafe


@dataclass(frozen=True)
class BatteryConfig:
    """Thresholds of the battery monitor.

    Attributes:
        low_charge: state of charge at which to return (PX4 BAT_LOW_THR 0.15).
        critical_charge: state of charge at which to land (PX4 BAT_CRIT_THR 0.07).
        empty_cell_v: voltage of an empty cell [V]; below it the pack counts as empty, whatever the gauge reads.
        lost_s: after this time without telemetry the pack counts as empty [s].
    """

    low_charge: float
    critical_charge: float
    empty_cell_v: float
    lost_s: float


class BatteryMonitor:
    """Watches the telemetry and requests each action once."""

    def __init__(self, config: BatteryConfig) -> None:
        self.config = config
        self._received_s = 0.0
        self._requested = ""

    def update(self, now_s: float, battery: Battery | None) -> Failsafe | None:
        """Process the telemetry of one tick; returns a new request to the mission, None when there is none."""
        config = self.config
        action = ""
        if battery is not None:
            self._received_s = now_s
            cell_v = battery.voltage_v / max(1, battery.cells)
            if cell_v < config.empty_cell_v or battery.charge <= config.critical_charge:
                action = "land"
            elif battery.charge <= config.low_charge:
                action = "return"
        elif now_s - self._received_s > config.lost_s:
            action = "land"
        if not action or action == self._requested or self._requested == "land":
            return None
        self._requested = action
        return Failsafe(now_s, action)
