"""Positioning system of the mine, 20 Hz: position and heading of the vehicle, with latency."""

from __future__ import annotations

import math
from dataclasses import dataclass

from scaloft_fi.document import Item
from scaloft_fi.sim.sensors.sensor import LONGEST_S, SENSORS, FlightSetting, Moment, SensorKind
from scaloft_fi.stack.messages import Fix
from scaloft_fi.streams import Table


@dataclass(frozen=True)
class PositioningConfig:
    """Errors of the positioning system.

    Attributes:
        sigma_m: standard deviation per axis [m].
        yaw_sigma_rad: standard deviation of the heading [rad].
        latency_s: from measurement to delivery [s].
    """

    sigma_m: float
    yaw_sigma_rad: float
    latency_s: float

    @classmethod
    def read(cls, item: Item) -> PositioningConfig:
        """Read the `positioning` of `sensors.yaml`."""
        config = cls(
            sigma_m=item.need("sigma_m").number(least=0.0),
            yaw_sigma_rad=math.radians(item.need("yaw_sigma_deg").number(least=0.0)),
            latency_s=item.need("latency_s").number(least=0.0, most=LONGEST_S),
        )
        item.close()
        return config


class Positioning:
    """Measures position and heading."""

    def __init__(self, config: PositioningConfig, flight: FlightSetting) -> None:
        self._config = config
        self._noise = Table(4, *flight.stream, "fix")

    def measure(self, moment: Moment) -> Fix:
        """The fix of this tick."""
        noise, state = self._noise.row(moment.tick), moment.state
        x, y, z, w = state[3:7].tolist()
        yaw_rad = math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
        return Fix(
            moment.stamps.fix_s,
            state[:3] + moment.around.drift_m + self._config.sigma_m * noise[:3],
            yaw_rad + self._config.yaw_sigma_rad * float(noise[3]),
        )


SENSORS.declare(
    "positioning",
    SensorKind(
        Positioning,
        Fix,
        read=PositioningConfig.read,
        latency_s=lambda config: config.latency_s,
        required=True,
    ),
)
