"""Upper bound of the loss of clearance in a tick without contact, for any thrusts."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import product

import numpy as np

from scaloft_fi.sim.build import GRAVITY_MPS2
from scaloft_fi.sim.vehicle import RATE, VELOCITY, Vehicle
from scaloft_fi.stack.declaration import TICK_S

_GAINED_S2 = TICK_S**2 * 13.0 / 24.0
"""Distance per acceleration over 12 steps; each step first adds speed, then moves [s2]."""


class Reach:
    """Bounds on the loss of clearance by a vehicle's motion.

    Args:
        vehicle: what flies.
        wind_mps: greatest speed of the air [m/s].

    Attributes:
        any_turn_m: greatest loss of clearance by a rotation about the centre [m].
        gained_m, gained_rad: greatest distance and rotation that rotors, wind and weight can add in a tick [m, rad].
        tumble: greatest factor by which the angular rate can grow without torque.
    """

    def __init__(self, vehicle: Vehicle, wind_mps: float = 0.0) -> None:
        self._radius_m = 0.5 * math.hypot(*vehicle.hull_m)
        # In every attitude the hull lies in one ball about its centre and contains a smaller one.
        self.any_turn_m = self._radius_m - 0.5 * min(vehicle.hull_m)
        most_n = 4.0 * vehicle.max_thrust_n + vehicle.drag * wind_mps
        self.gained_m = _GAINED_S2 * (most_n / vehicle.mass_kg + GRAVITY_MPS2)
        most, least = max(vehicle.inertia), min(vehicle.inertia)
        # Without torque the energy of rotation is constant; the axis may change.
        self.tumble = math.sqrt(most / least)
        self.gained_rad = _GAINED_S2 * _greatest_torque(vehicle) / least

    def within_tick_m(self, truth: Sequence[float]) -> float:
        """Upper bound of the loss of any clearance during the coming tick [m]; NaN where `truth` has a NaN.

        Args:
            truth: the 13 numbers of the vehicle's state in the layout of `sim.vehicle`.
        """
        turn_m = self._radius_m * (TICK_S * self.tumble * math.hypot(*truth[RATE]) + self.gained_rad)
        return TICK_S * math.hypot(*truth[VELOCITY]) + self.gained_m + min(turn_m, self.any_turn_m)


def _greatest_torque(vehicle: Vehicle) -> float:
    """Greatest torque [N m]: torque is linear in the thrusts, so each rotor has either no thrust or full thrust."""
    torques = vehicle.max_thrust_n * vehicle.effect()[1:4]
    return max(float(np.linalg.norm(torques @ np.array(on))) for on in product((0.0, 1.0), repeat=4))
