"""Light meter of the colour camera: measures the exposure error, + for underexposed, - for overexposed."""

from __future__ import annotations

import math
from dataclasses import dataclass

from scaloft_fi.document import Item
from scaloft_fi.sim.sensors.sensor import SENSORS, FlightSetting, Moment, SensorKind
from scaloft_fi.stack.messages import Exposure, Metering
from scaloft_fi.streams import Table

LIMIT_EV = 16.0
"""End of the meter's scale."""


@dataclass(frozen=True)
class MeteringConfig:
    """Settings of the light meter.

    Attributes:
        mid: brightness of a correctly exposed picture, 0..1.
        sigma_ev: standard deviation of a reading [EV].
    """

    mid: float
    sigma_ev: float

    @classmethod
    def read(cls, item: Item) -> MeteringConfig:
        """Read the `metering` of `sensors.yaml`."""
        config = cls(
            mid=item.need("mid").number(least=1e-6, most=1.0),
            sigma_ev=item.need("sigma_ev").number(least=0.0),
        )
        item.close()
        return config

    def error_ev(self, light: float, exposure: Exposure) -> float:
        """Exposure error of the picture [EV], + when too dark."""
        if light <= 0.0 or not math.isfinite(exposure.ev):
            return LIMIT_EV
        return min(LIMIT_EV, max(-LIMIT_EV, math.log2(self.mid / light) - exposure.ev))


class LightMeter:
    """Measures the exposure error."""

    def __init__(self, config: MeteringConfig, flight: FlightSetting) -> None:
        self._config = config
        self._noise = Table(1, *flight.stream, "metering")

    def measure(self, moment: Moment) -> Metering:
        """The reading at the current exposure."""
        noise_ev = self._config.sigma_ev * float(self._noise.row(moment.tick)[0])
        return Metering(moment.now_s, self._config.error_ev(moment.around.light, moment.exposure) + noise_ev)


SENSORS.declare("metering", SensorKind(LightMeter, Metering, read=MeteringConfig.read, required=True))
