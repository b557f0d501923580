"""Battery: the rotors drain it, its voltage sags under load, and it sends telemetry once per second."""

from __future__ import annotations

import math
from dataclasses import dataclass

from scaloft_fi.document import Item
from scaloft_fi.sim.sensors.sensor import SENSORS, FlightSetting, Moment, SensorKind
from scaloft_fi.stack.declaration import TICK_S
from scaloft_fi.stack.messages import Battery
from scaloft_fi.streams import Array

PERIOD_TICKS = 20
"""Ticks from one telemetry message to the next: 1 Hz."""


@dataclass(frozen=True)
class BatteryConfig:
    """Settings of the battery.

    Attributes:
        cells: number of cells in series.
        capacity_ah: charge of a full pack [A h].
        charge: state of charge at take-off, 0..1.
        full_cell_v, empty_cell_v: open-circuit voltage of a full and of an empty cell [V]; linear in between.
        resistance_ohm: resistance of the whole pack [ohm].
        hover_w_per_n15: power of a rotor per thrust^1.5 [W/N^1.5].
        idle_w: power of all other consumers [W].
    """

    cells: int
    capacity_ah: float
    charge: float
    full_cell_v: float
    empty_cell_v: float
    resistance_ohm: float
    hover_w_per_n15: float
    idle_w: float

    @classmethod
    def read(cls, item: Item) -> BatteryConfig:
        """Read the `battery` of `sensors.yaml`."""
        empty_cell_v = item.need("empty_cell_v").number(least=1e-3)
        config = cls(
            cells=item.need("cells").whole(least=1, most=1_000),
            capacity_ah=item.need("capacity_ah").number(least=1e-3),
            charge=item.need("charge").number(least=0.0, most=1.0),
            full_cell_v=item.need("full_cell_v").number(above=empty_cell_v),
            empty_cell_v=empty_cell_v,
            resistance_ohm=item.need("resistance_ohm").number(least=0.0),
            hover_w_per_n15=item.need("hover_w_per_n15").number(least=0.0),
            idle_w=item.need("idle_w").number(least=0.0),
        )
        item.close()
        return config


class BatteryGauge:
    """Tracks the charge and sends telemetry."""

    def __init__(self, config: BatteryConfig, flight: FlightSetting) -> None:
        self._config = config
        self._charge = config.charge

    def drain(self, thrusts: Array, seconds: float) -> float:
        """Drain the pack by the power for `thrusts` (4,) [N] over `seconds` [s]; returns the terminal voltage [V]."""
        config = self._config
        rest_v = config.cells * (config.empty_cell_v + (config.full_cell_v - config.empty_cell_v) * self._charge)
        work: float = sum(n * math.sqrt(n) for n in thrusts.tolist())
        power_w = config.idle_w + config.hover_w_per_n15 * work
        current_a = power_w / rest_v
        self._charge = max(0.0, self._charge - current_a * seconds / (3600.0 * config.capacity_ah))
        return rest_v - current_a * config.resistance_ohm

    def measure(self, moment: Moment) -> Battery | None:
        """Drain the pack at every tick; returns a telemetry message once per second, else None."""
        voltage_v = self.drain(moment.thrusts, TICK_S)
        if moment.tick % PERIOD_TICKS:
            return None
        return Battery(moment.now_s, self._charge, voltage_v, self._config.cells)


SENSORS.declare("battery", SensorKind(BatteryGauge, Battery, read=BatteryConfig.read, required=True))
