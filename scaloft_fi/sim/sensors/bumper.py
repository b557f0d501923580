"""Touch sensor: whether hull or landing gear touched anything since it was last read."""

from __future__ import annotations

from collections.abc import Iterable

from scaloft_fi.sim.contact import Contact
from scaloft_fi.stack.messages import Bumper


class BumperSensor:
    """Remembers touches between two readings."""

    def __init__(self) -> None:
        self._hull = self._gear = False

    def feel(self, contacts: Iterable[Contact]) -> None:
        """Take in the touches of one physics step."""
        for contact in contacts:
            self._gear |= contact.gear
            self._hull |= not contact.gear

    def measure(self, stamp_s: float) -> Bumper:
        """The reading; it starts anew afterwards."""
        reading = Bumper(stamp_s, self._hull, self._gear)
        self._hull = self._gear = False
        return reading
