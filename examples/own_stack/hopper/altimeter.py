"""The sensor: height above the floor, 20 Hz, with noise."""

from dataclasses import dataclass

from hopper.messages import Height
from scaloft_fi.api import SENSORS, NotNegative, SensorKind, Table


@dataclass(frozen=True)
class AltimeterConfig:
    """A laser that measures the height.

    Attributes:
        sigma_m: standard deviation of the height [m].
    """

    sigma_m: NotNegative


class Altimeter:
    """Measures straight down from the vehicle's centre."""

    def __init__(self, config, flight):
        self._sigma_m, self._noise = config.sigma_m, Table(1, *flight.stream, "altimeter")

    def measure(self, moment):
        """The height at this tick."""
        return Height(moment.now_s, moment.state[2] + self._sigma_m * self._noise.row(moment.tick)[0])


SENSORS.declare("altimeter", SensorKind(Altimeter, Height, AltimeterConfig))
