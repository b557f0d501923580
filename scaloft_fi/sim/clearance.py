"""Distance of the hull from each surface, measured by the physics server.

The server examines every triangle within the search distance, so the search distance is kept small: a clearance grows
by at most the distance that the hull has moved.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from scaloft_fi.sim.build import BodyIds
from scaloft_fi.sim.geometry import outside
from scaloft_fi.sim.signals import CLEARANCE_CAP_M
from scaloft_fi.sim.vehicle import Array, Vehicle
from scaloft_fi.sim.world import GROUND, WALL, World

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
        import pybullet

        self._client, self._ids, self._body, self._closest = client, ids.by_name, body, pybullet.getClosestPoints
        self._radius_m = 0.5 * math.hypot(*vehicle.hull_m)
        meshes = {WALL: world.mine.wall, GROUND: world.mine.ground, **{body.name: body.mesh for body in world.present}}
        self._names, self._boxes = tuple(meshes), np.array([_bounds(mesh.vertices) for mesh in meshes.values()])
        self._at_rest = self._boxes.copy()
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
        distances = np.empty(len(self._boxes))
        outside(self._boxes, pose[0], pose[1], pose[2], distances)
        radius_m = self._radius_m
        self.gaps_m = {name: d - radius_m for name, d in zip(self._names, distances.tolist(), strict=True)}
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


def _bounds(vertices: Array) -> tuple[float, ...]:
    """Bounding box: least x, y, z, then greatest x, y, z [m]."""
    return tuple(map(float, (*vertices.min(axis=0), *vertices.max(axis=0))))
