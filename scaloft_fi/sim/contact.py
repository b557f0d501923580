"""What the vehicle touches in a physics step."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from scaloft_fi.sim.reach import Reach
from scaloft_fi.sim.vehicle import Array, Vehicle

GEAR_SHARE = 0.8
"""A contact lower than this share of the half height below the centre touches the landing gear, not the hull."""
SPARE_M = 0.05
"""More than Bullet's margins plus the motion in the step between detecting and reporting a contact [m]."""


class Contact(NamedTuple):
    """A contact of the vehicle.  struck: name of the touched body; gear: whether the landing gear touches it."""

    struck: str
    gear: bool


def contacts(
    client: int, vehicle: int, name_of: Mapping[int, str], state: Array, half_height_m: float
) -> tuple[Contact, ...]:
    """The contacts of the last physics step.

    Args:
        client: physics server.
        vehicle: body number of the vehicle.
        name_of: names of the bodies of the world by number.
        state: (13,) state of the vehicle.
        half_height_m: half the height of the hull [m].
    """
    import pybullet

    points = pybullet.getContactPoints(bodyA=vehicle, physicsClientId=client)
    if not points:
        return ()
    x, y, z, w = state[3], state[4], state[5], state[6]
    ux, uy, uz = 2.0 * (x * z + y * w), 2.0 * (y * z - x * w), 1.0 - 2.0 * (x * x + y * y)
    touched = set()
    for point in points:
        # Bullet also lists near points; in a contact the bodies overlap or a force acts.
        if point[8] <= 0.0 or point[9] > 0.0:
            px, py, pz = point[5]
            height_m = ux * (px - state[0]) + uy * (py - state[1]) + uz * (pz - state[2])
            touched.add(Contact(name_of[point[2]], bool(height_m < -GEAR_SHARE * half_height_m)))
    return tuple(sorted(touched))


class Feeler:
    """Finds contacts; calls the physics server only where a contact is possible.

    Args:
        client: physics server.
        number: body number of the vehicle.
        vehicle: what flies.
        name_of: names of the bodies of the world by number.
        wind_mps: greatest speed of the air [m/s].

    Attributes:
        out_of_reach: whether the vehicle can touch nothing in the tick after `look`.
    """

    def __init__(
        self, client: int, number: int, vehicle: Vehicle, name_of: Mapping[int, str], wind_mps: float = 0.0
    ) -> None:
        self.out_of_reach = False
        self._client, self._number, self._name_of = client, number, name_of
        self._half_height_m = vehicle.half_height_m
        self._reach = Reach(vehicle, wind_mps)
        self._x = self._y = self._z = 0.0
        self._free_square = -1.0

    def look(self, truth: Sequence[float], room_m: float) -> None:
        """Set the free distance around the hull; called before a tick.

        Args:
            truth: the 13 numbers of the vehicle's state.
            room_m: lower bound of the distance from the hull to any surface [m].
        """
        self._x, self._y, self._z = truth[:3]
        spare_m = room_m - SPARE_M
        self.out_of_reach = self._reach.within_tick_m(truth) < spare_m
        free_m = spare_m - self._reach.any_turn_m
        self._free_square = free_m * free_m if free_m > 0.0 else -1.0

    def feel(self, truth: Sequence[float], state: Array) -> tuple[Contact, ...]:
        """The contacts of the last physics step.

        Args:
            truth: the 13 numbers of the vehicle's state.
            state: (13,) the same numbers as an array.
        """
        dx, dy, dz = truth[0] - self._x, truth[1] - self._y, truth[2] - self._z
        if dx * dx + dy * dy + dz * dz < self._free_square:
            return ()
        return contacts(self._client, self._number, self._name_of, state, self._half_height_m)
