"""Touch sensor: whether hull or landing gear touched anything since it was last read."""

from __future__ import annotations

from scaloft_fi.sim.sensors.sensor import SENSORS, FlightSetting, Moment, SensorKind
from scaloft_fi.stack.messages import Bumper


class BumperSensor:
    """Tells hull from landing gear."""

    def __init__(self, config: None, flight: FlightSetting) -> None:
        pass

    def measure(self, moment: Moment) -> Bumper:
        """What was touched since the last reading."""
        hull = gear = False
        for contact in moment.contacts:
            gear |= contact.gear
            hull |= not contact.gear
        return Bumper(moment.now_s, hull, gear)


SENSORS.declare("bumper", SensorKind(BumperSensor, Bumper, required=True))
