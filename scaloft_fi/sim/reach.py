"""How near the hull can come in a tick, whatever the rotors do, as long as nothing is touched."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import product

import numpy as np

from scaloft_fi.sim.build import GRAVITY_MPS2
from scaloft_fi.sim.vehicle import RATE, VELOCITY, Vehicle
from scaloft_fi.stack.rates import TICK_S

_GAINED_S2 = TICK_S**2 * 13.0 / 24.0
"""Way per acceleration, where each of 12 steps first gains speed and then moves by it [s2]."""


class Reach:
    """Bounds on what a vehicle's motion takes from its clearances.

    Args:
        vehicle: what flies.

    Attributes:
        any_turn_m: no turn about the centre brings the hull nearer to anything by more than this [m].
        gained_m, gained_rad: way and turn of a tick that rotors and weight can add to those it is flying with.
        tumble: by this factor its rate may grow by itself.
    """

    def __init__(self, vehicle: Vehicle) -> None:
        self._radius_m = 0.5 * math.hypot(*vehicle.hull_m)
        # However the hull turns, it stays in a ball about its centre, and a smaller ball stays in it.
        self.any_turn_m = self._radius_m - 0.5 * min(vehicle.hull_m)
        self.gained_m = _GAINED_S2 * (4.0 * vehicle.max_thrust_n / vehicle.mass_kg + GRAVITY_MPS2)
        most, least = max(vehicle.inertia), min(vehicle.inertia)
        # Without torque the energy of rotation is kept, whichever axis it is about.
        self.tumble = math.sqrt(most / least)
        self.gained_rad = _GAINED_S2 * _greatest_torque(vehicle) / least

    def within_tick_m(self, truth: Sequence[float]) -> float:
        """How much less any clearance can be at any moment of the tick that begins [m]; NaN when `truth` is.

        Args:
            truth: the 13 numbers of the vehicle's state, as `sim.vehicle` lays them out.
        """
        turn_m = self._radius_m * (TICK_S * self.tumble * math.hypot(*truth[RATE]) + self.gained_rad)
        return TICK_S * math.hypot(*truth[VELOCITY]) + self.gained_m + min(turn_m, self.any_turn_m)


def _greatest_torque(vehicle: Vehicle) -> float:
    """The torque is linear in the thrusts, so that it is greatest where each rotor stands or gives all [N m]."""
    torques = vehicle.max_thrust_n * vehicle.effect()[1:4]
    return max(float(np.linalg.norm(torques @ np.array(on))) for on in product((0.0, 1.0), repeat=4))
