"""What the vehicle touches in a physics step."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from scaloft_fi.sim.vehicle import Array

GEAR_SHARE = 0.8
"""A touch below this share of the hull's half height is one of the landing gear, not of the hull."""


class Contact(NamedTuple):
    """One touch.  struck: name of what is touched; gear: whether the vehicle's underside touches it."""

    struck: str
    gear: bool


def contacts(
    client: int, vehicle: int, name_of: Mapping[int, str], state: Array, half_height_m: float
) -> tuple[Contact, ...]:
    """The touches of the last physics step.

    Args:
        client: physics server.
        vehicle: the vehicle's body number.
        name_of: names of the world's bodies by number.
        state: (13,) state of the vehicle.
        half_height_m: of the hull [m].
    """
    import pybullet

    points = pybullet.getContactPoints(bodyA=vehicle, physicsClientId=client)
    if not points:
        return ()
    x, y, z, w = state[3], state[4], state[5], state[6]
    ux, uy, uz = 2.0 * (x * z + y * w), 2.0 * (y * z - x * w), 1.0 - 2.0 * (x * x + y * y)
    found = set()
    for point in points:
        # Bullet also lists near points; a touch overlaps or pushes.
        if point[8] <= 0.0 or point[9] > 0.0:
            px, py, pz = point[5]
            height_m = ux * (px - state[0]) + uy * (py - state[1]) + uz * (pz - state[2])
            found.add(Contact(name_of[point[2]], bool(height_m < -GEAR_SHARE * half_height_m)))
    return tuple(sorted(found))
