"""What the vehicle touches in a physics step, how far it is from each surface, and how soon it could touch one.

The server examines every triangle within the search distance, so the search distance is kept small: a clearance grows
by at most the distance that the hull has moved.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import product
from typing import NamedTuple

import numpy as np

from scaloft_fi.sim.build import GRAVITY_MPS2, BodyIds, bullet, outside
from scaloft_fi.sim.log import CLEARANCE_CAP_M
from scaloft_fi.sim.vehicle import RATE, VELOCITY, Array, Vehicle
from scaloft_fi.sim.world import GROUND, WALL, World
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
        most_n = 4.0 * vehicle.max_thrust_n + vehicle.drag_ns_per_m * wind_mps
        self.gained_m = _GAINED_S2 * (most_n / vehicle.mass_kg + GRAVITY_MPS2)
        most, least = max(vehicle.inertia_kgm2), min(vehicle.inertia_kgm2)
        # Without torque the energy of rotation is constant; the axis may change.
        self.tumble = math.sqrt(most / least)
        # Torque is linear in the thrusts, so where it is greatest each rotor has either no thrust or full thrust.
        torques = vehicle.max_thrust_n * vehicle.effect()[1:4]
        most_nm = max(float(np.linalg.norm(torques @ np.array(on))) for on in product((0.0, 1.0), repeat=4))
        self.gained_rad = _GAINED_S2 * most_nm / least

    def within_tick_m(self, truth: Sequence[float]) -> float:
        """Upper bound of the loss of any clearance during the coming tick [m]; NaN where `truth` has a NaN.

        Args:
            truth: the 13 numbers of the vehicle's state in the layout of `sim.vehicle`.
        """
        turn_m = self._radius_m * (TICK_S * self.tumble * math.hypot(*truth[RATE]) + self.gained_rad)
        return TICK_S * math.hypot(*truth[VELOCITY]) + self.gained_m + min(turn_m, self.any_turn_m)


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
    points = bullet().getContactPoints(bodyA=vehicle, physicsClientId=client)
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


SLACK_M = 1e-3
"""Added to the search distance; far more than the rounding of poses and distances [m]."""
NO_SHIFTS: Mapping[str, Sequence[float]] = {}


class Clearances:
    """The clearances of one vehicle from the surfaces of a world.

    Args:
        client: physics server.
        ids: numbers of the surfaces.
        body: number of the vehicle.
        vehicle: what flies.
        world: holds the surfaces.

    Attributes:
        gaps_m: by name of the surface, a lower bound of its clearance: the distance from a ball around the hull to the
            bounding box of the surface [m].
    """

    def __init__(self, client: int, ids: BodyIds, body: int, vehicle: Vehicle, world: World) -> None:
        self._client, self._ids, self._body, self._closest = client, ids.by_name, body, bullet().getClosestPoints
        self._radius_m = 0.5 * math.hypot(*vehicle.hull_m)
        meshes = {WALL: world.mine.wall, GROUND: world.mine.ground, **{body.name: body.mesh for body in world.present}}
        corners = [mesh.vertices for mesh in meshes.values()]
        self._names, self._boxes = tuple(meshes), np.array([(*v.min(axis=0), *v.max(axis=0)) for v in corners])
        self._at_rest, self._distances = self._boxes.copy(), np.empty(len(corners))
        self.gaps_m: Mapping[str, float] = {}
        self._pose: Sequence[float] = (0.0,) * 7
        self._moved_m = math.inf
        self._before: Mapping[str, float] = {}
        self._measured: dict[str, float] = {}

    def look(self, pose: Sequence[float], shifts: Mapping[str, Sequence[float]] = NO_SHIFTS) -> None:
        """Set the pose of the vehicle, the first 7 numbers of its state, and the shifts of the bodies that can move."""
        for name, by_m in shifts.items():
            number = self._names.index(name)
            self._boxes[number] = self._at_rest[number] + (*by_m, *by_m)
        outside(self._boxes, pose[0], pose[1], pose[2], self._distances)
        radius_m = self._radius_m
        self.gaps_m = {name: d - radius_m for name, d in zip(self._names, self._distances.tolist(), strict=True)}
        self._before, self._measured = self._measured, {}
        self._moved_m = moved_m(self._pose, pose, radius_m)
        self._pose = pose

    def measure(self, name: str) -> float:
        """Distance from the hull to surface `name` [m], at most 1; slightly below 0 where Bullet's margins overlap."""
        if self.gaps_m.get(name, math.inf) >= CLEARANCE_CAP_M:
            return CLEARANCE_CAP_M
        known_m = self._before.get(name, math.inf) + self._moved_m + SLACK_M
        for within_m in {min(CLEARANCE_CAP_M, known_m): None, CLEARANCE_CAP_M: None}:
            points = self._closest(self._body, self._ids[name], within_m, physicsClientId=self._client)
            clearance_m = min((point[8] for point in points), default=CLEARANCE_CAP_M)
            # The depth of an overlap depends on the search distance.
            if points and clearance_m > 0.0:
                break
        self._measured[name] = clearance_m
        return clearance_m


def moved_m(before: Sequence[float], after: Sequence[float], radius_m: float) -> float:
    """Upper bound of the distance that a point within `radius_m` of the centre moves between two poses [m].

    Args:
        before, after: position [m] and attitude quaternion, 7 numbers.
        radius_m: greatest distance of the point from the centre [m].
    """
    x, y, z, qx, qy, qz, qw = before
    u, v, w, rx, ry, rz, rw = after
    half_cos = qx * rx + qy * ry + qz * rz + qw * rw
    half_sin = math.sqrt(max(0.0, 1.0 - half_cos * half_cos))
    return math.hypot(u - x, v - y, w - z) + 2.0 * radius_m * half_sin
