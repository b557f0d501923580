"""Touch sensor: whether hull or landing gear had a contact since the last reading."""

from __future__ import annotations

from scaloft_fi.sim.sensors.sensor import SENSORS, FlightSetting, Moment, SensorKind
from scaloft_fi.stack.messages import Bumper


class BumperSensor:
    """Reports contacts of hull and landing gear."""

    def __init__(self, config: None, flight: FlightSetting) -> None:
        pass

    def measure(self, moment: Moment) -> Bumper:
        """Whether hull and landing gear had a contact since the last reading."""
        hull = gear = False
        for contact in moment.contacts:
            gear |= contact.gear
            hull |= not contact.gear
        return Bumper(moment.now_s, hull, gear)


SENSORS.declare("bumper", SensorKind(BumperSensor, Bumper, required=True))
