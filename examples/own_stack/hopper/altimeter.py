"""The sensor: height above the floor, 20 Hz, with noise."""

from hopper.messages import Height
from scaloft_fi.sim.sensors.sensor import SENSORS, SensorKind
from scaloft_fi.streams import Table


class Altimeter:
    """Measures straight down from the vehicle's centre."""

    def __init__(self, sigma_m, flight):
        self._sigma_m, self._noise = sigma_m, Table(1, *flight.stream, "altimeter")

    def measure(self, moment):
        """The height at this tick."""
        return Height(moment.now_s, moment.state[2] + self._sigma_m * self._noise.row(moment.tick)[0])


SENSORS.declare("altimeter", SensorKind(Altimeter, Height, read=lambda item: item.need("sigma_m").number(least=0.0)))
