"""Who makes the physics steps of a flight: the physics server, or compiled code where nothing can be touched.

A flight has the same bits either way.
"""

from __future__ import annotations

from typing import Protocol

from scaloft_fi.sim.airframe import Airframe, Drive


class Stepper(Protocol):
    """Makes physics steps, each with inertial sensor, flight control and rotors."""

    def advance(self, first: int, count: int) -> float:
        """Make `count` steps from number `first` on.

        Returns:
            The greatest square of the speed after a step [m2/s2].
        """
        ...


class ServerStepper:
    """The physics server makes the steps, and Python calls sensor, stack and rotors before each.

    Args:
        airframe: the vehicle.
        drive: sets its force and torque before a step.
    """

    def __init__(self, airframe: Airframe, drive: Drive) -> None:
        self._airframe, self._drive = airframe, drive

    def advance(self, first: int, count: int) -> float:
        """Let the server make the steps; the vehicle may touch anything."""
        return self._airframe.step(self._drive, first, count)
