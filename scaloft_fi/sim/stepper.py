"""Steppers make the physics steps of a flight: in the physics server, or in compiled code where no contact is possible.

Both steppers compute the same bits.
"""

from __future__ import annotations

from typing import Protocol

from scaloft_fi.sim.airframe import Airframe, Drive


class Stepper(Protocol):
    """Makes physics steps; each step includes inertial sensor, flight control and rotors."""

    def advance(self, first: int, count: int) -> float:
        """Make `count` steps, beginning with number `first`.

        Returns:
            The greatest square of the speed after a step [m2/s2].
        """
        ...


class ServerStepper:
    """Lets the physics server make the steps; Python calls sensor, stack and rotors before each step.

    Args:
        airframe: the vehicle.
        drive: sets force and torque of the vehicle before a step.
    """

    def __init__(self, airframe: Airframe, drive: Drive) -> None:
        self._airframe, self._drive = airframe, drive

    def advance(self, first: int, count: int) -> float:
        """Make the steps in the server; contacts are allowed."""
        return self._airframe.step(self._drive, first, count)
