"""How far the hull is from each surface, as the physics server measures it.

The server looks at every triangle within the distance that it is asked for, so it is asked for no more than needed:
a clearance grows by no more than the hull has moved.
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
"""Far more than the rounding of poses and distances [m]."""


class Clearances:
    """The clearances of one vehicle from the surfaces of a world.

    Args:
        client: physics server.
        ids: of the surfaces.
        body: the vehicle's number.
        vehicle: what flies.
        world: with the surfaces.

    Attributes:
        gaps_m: by name, from a ball about the hull to the surface's bounding box: no clearance is smaller [m].
    """

    def __init__(self, client: int, ids: BodyIds, body: int, vehicle: Vehicle, world: World) -> None:
        import pybullet

        self._client, self._ids, self._body, self._closest = client, ids.by_name, body, pybullet.getClosestPoints
        self._radius_m = 0.5 * math.hypot(*vehicle.hull_m)
        meshes = {WALL: world.mine.wall, GROUND: world.mine.ground, **{body.name: body.mesh for body in world.present}}
        self._names, self._boxes = tuple(meshes), np.array([_bounds(mesh.vertices) for mesh in meshes.values()])
        self.gaps_m: Mapping[str, float] = {}
        self._pose: Sequence[float] = (0.0,) * 7
        self._moved_m = math.inf
        self._before: Mapping[str, float] = {}
        self._measured: dict[str, float] = {}

    def look(self, pose: Sequence[float]) -> None:
        """Take the vehicle to be at `pose`, the first 7 numbers of its state, from now on."""
        distances = np.empty(len(self._boxes))
        outside(self._boxes, pose[0], pose[1], pose[2], distances)
        radius_m = self._radius_m
        self.gaps_m = {name: d - radius_m for name, d in zip(self._names, distances.tolist(), strict=True)}
        self._before, self._measured = self._measured, {}
        self._moved_m = moved_m(self._pose, pose, radius_m)
        self._pose = pose

    def measure(self, name: str) -> float:
        """From the hull to the surface `name` [m], at most 1; a little below 0 where Bullet's margins overlap."""
        if self.gaps_m.get(name, math.inf) >= CLEARANCE_CAP_M:
            return CLEARANCE_CAP_M
        known_m = self._before.get(name, math.inf) + self._moved_m + SLACK_M
        for within_m in {min(CLEARANCE_CAP_M, known_m): None, CLEARANCE_CAP_M: None}:
            points = self._closest(self._body, self._ids[name], within_m, physicsClientId=self._client)
            clearance_m = min((point[8] for point in points), default=CLEARANCE_CAP_M)
            # How deep bodies overlap depends on how far the server is asked to look.
            if points and clearance_m > 0.0:
                break
        self._measured[name] = clearance_m
        return clearance_m


def moved_m(before: Sequence[float], after: Sequence[float], radius_m: float) -> float:
    """How far at most a point moved that is within `radius_m` of the centre, between two poses [m].

    Args:
        before, after: position [m] and attitude quaternion, 7 numbers.
        radius_m: [m].
    """
    x, y, z, qx, qy, qz, qw = before
    u, v, w, rx, ry, rz, rw = after
    half_cos = qx * rx + qy * ry + qz * rz + qw * rw
    half_sin = math.sqrt(max(0.0, 1.0 - half_cos * half_cos))
    return math.hypot(u - x, v - y, w - z) + 2.0 * radius_m * half_sin


def _bounds(vertices: Array) -> tuple[float, ...]:
    """Least x, y, z, then greatest [m]."""
    return tuple(map(float, (*vertices.min(axis=0), *vertices.max(axis=0))))
