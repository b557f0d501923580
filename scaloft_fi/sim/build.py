"""The world as bodies of a physics server, and the compiled geometry of its ground truth."""

from __future__ import annotations

import math
import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from scaloft_fi.sim.mesh import Mesh
from scaloft_fi.sim.mine import SLAB_M
from scaloft_fi.sim.world import GROUND, WALL, World
from scaloft_fi.stack.declaration import STEP_S
from scaloft_fi.stack.kernel import jit

Array = NDArray[np.float64]
Faces = NDArray[np.int64]
Segments = NDArray[np.int16]


@jit
def nearest(vertices: Array, faces: Faces, owner: Segments, body: int, point: Array, foot: Array) -> float:
    """Distance from `point` (3,) to the triangles of `body` [m]; writes the nearest point into `foot` (3,).

    Regions of the triangle after Ericson, Real-Time Collision Detection (2005), section 5.1.5.
    """
    best = np.inf
    for f in range(faces.shape[0]):
        if owner[f] != body:
            continue
        a, b, c = vertices[faces[f, 0]], vertices[faces[f, 1]], vertices[faces[f, 2]]
        d1, d2, d3, d4, d5, d6 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for k in range(3):
            ab, ac = b[k] - a[k], c[k] - a[k]
            d1 += ab * (point[k] - a[k])
            d2 += ac * (point[k] - a[k])
            d3 += ab * (point[k] - b[k])
            d4 += ac * (point[k] - b[k])
            d5 += ab * (point[k] - c[k])
            d6 += ac * (point[k] - c[k])
        va, vb, vc = d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2
        if d1 <= 0.0 and d2 <= 0.0:
            v, w = 0.0, 0.0
        elif d3 >= 0.0 and d4 <= d3:
            v, w = 1.0, 0.0
        elif vc <= 0.0 and d1 >= 0.0 and d3 <= 0.0:
            v, w = d1 / (d1 - d3), 0.0
        elif d6 >= 0.0 and d5 <= d6:
            v, w = 0.0, 1.0
        elif vb <= 0.0 and d2 >= 0.0 and d6 <= 0.0:
            v, w = 0.0, d2 / (d2 - d6)
        elif va <= 0.0 and d4 - d3 >= 0.0 and d5 - d6 >= 0.0:
            w = (d4 - d3) / ((d4 - d3) + (d5 - d6))
            v = 1.0 - w
        else:
            v, w = vb / (va + vb + vc), vc / (va + vb + vc)
        square = 0.0
        for k in range(3):
            square += (a[k] + v * (b[k] - a[k]) + w * (c[k] - a[k]) - point[k]) ** 2
        if square < best:
            best = square
            for k in range(3):
                foot[k] = a[k] + v * (b[k] - a[k]) + w * (c[k] - a[k])
    return math.sqrt(best)


@jit
def blocked(vertices: Array, faces: Faces, owner: Segments, spared: int, start: Array, end: Array) -> bool:
    """Whether a triangle of any body except `spared` intersects the line from `start` to `end` (3,) [m, world].

    Intersection after Moeller and Trumbore (1997), both sides.
    """
    dx, dy, dz = end[0] - start[0], end[1] - start[1], end[2] - start[2]
    for f in range(faces.shape[0]):
        if owner[f] == spared:
            continue
        a, b, c = vertices[faces[f, 0]], vertices[faces[f, 1]], vertices[faces[f, 2]]
        ux, uy, uz = b[0] - a[0], b[1] - a[1], b[2] - a[2]
        vx, vy, vz = c[0] - a[0], c[1] - a[1], c[2] - a[2]
        px, py, pz = dy * vz - dz * vy, dz * vx - dx * vz, dx * vy - dy * vx
        volume = ux * px + uy * py + uz * pz
        if volume == 0.0:
            continue
        sx, sy, sz = start[0] - a[0], start[1] - a[1], start[2] - a[2]
        u = (sx * px + sy * py + sz * pz) / volume
        if u < 0.0 or u > 1.0:
            continue
        qx, qy, qz = sy * uz - sz * uy, sz * ux - sx * uz, sx * uy - sy * ux
        v = (dx * qx + dy * qy + dz * qz) / volume
        if v < 0.0 or u + v > 1.0:
            continue
        t = (vx * qx + vy * qy + vz * qz) / volume
        if 0.0 < t < 1.0:
            return True
    return False


@jit
def outside(boxes: Array, x: float, y: float, z: float, distances: Array) -> None:
    """Write the distance from (x, y, z) to each of `boxes` (N, 6) [least x, y, z, then greatest]; 0 inside a box."""
    for i in range(boxes.shape[0]):
        dx = max(boxes[i, 0] - x, 0.0, x - boxes[i, 3])
        dy = max(boxes[i, 1] - y, 0.0, y - boxes[i, 4])
        dz = max(boxes[i, 2] - z, 0.0, z - boxes[i, 5])
        distances[i] = math.sqrt(dx * dx + dy * dy + dz * dz)


GRAVITY_MPS2 = 9.81

RAY_GROUP, VEHICLE_GROUP, WORLD_GROUP = 1, 2, 4
"""Collision groups: the vehicle collides with the world; rays hit only the world."""


@dataclass(frozen=True)
class BodyIds:
    """Numbers of the bodies in the physics server.  by_name: the number of each surface that is present."""

    by_name: Mapping[str, int]

    @cached_property
    def name_of(self) -> dict[int, str]:
        """Names by number."""
        return {number: name for name, number in self.by_name.items()}


@cache
def bullet() -> Any:
    """PyBullet, imported where physics begins: its C code then writes to standard error, which is dropped."""
    saved, nowhere = os.dup(2), os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 2)
    try:
        import pybullet
    finally:
        os.dup2(saved, 2)
        os.close(saved)
        os.close(nowhere)
    return pybullet


_IDLE: list[int] = []


@contextmanager
def physics_server() -> Iterator[int]:
    """An empty physics server in this process, without a window; it is emptied for the next context at the end.

    To empty a server takes a fiftieth of the time that a new one takes.
    """
    client = _IDLE.pop() if _IDLE else int(bullet().connect(bullet().DIRECT))
    try:
        yield client
    finally:
        bullet().resetSimulation(physicsClientId=client)
        _IDLE.append(client)


def set_up(client: int) -> None:
    """Set gravity, time step and a fixed order of contact pairs in an empty physics server."""
    bullet().setGravity(0.0, 0.0, -GRAVITY_MPS2, physicsClientId=client)
    bullet().setPhysicsEngineParameter(fixedTimeStep=STEP_S, deterministicOverlappingPairs=1, physicsClientId=client)


def build(client: int, world: World) -> BodyIds:
    """Put the world into an empty physics server.

    The rock consists of the triangles that the camera sees.  Bullet adds a margin of 1 mm to them, so distances to rock
    are 1 mm too short.  Bodies are convex hulls; with Bullet's margin they have the surface that the camera sees.
    A level floor is a solid box under the same triangles.
    """
    set_up(client)
    floor = _slab if world.mine.ground_is_slab else _triangles
    shapes = {WALL: _triangles(client, world.mine.wall), GROUND: floor(client, world.mine.ground)}
    for body in world.present:
        vertices = body.core.vertices.tolist()
        shapes[body.name] = bullet().createCollisionShape(bullet().GEOM_MESH, vertices=vertices, physicsClientId=client)
    ids = {}
    for name, shape in shapes.items():
        ids[name] = number = bullet().createMultiBody(0.0, shape, physicsClientId=client)
        bullet().setCollisionFilterGroupMask(number, -1, WORLD_GROUP, VEHICLE_GROUP | RAY_GROUP, physicsClientId=client)
    return BodyIds(ids)


def place(client: int, ids: BodyIds, shifts: Mapping[str, Sequence[float]]) -> None:
    """Put bodies at their positions plus `shifts` (3,) [m, world]."""
    for name, by_m in shifts.items():
        bullet().resetBasePositionAndOrientation(ids.by_name[name], by_m, (0.0, 0.0, 0.0, 1.0), physicsClientId=client)


def _triangles(client: int, mesh: Mesh) -> int:
    corners, indices = mesh.vertices.tolist(), mesh.faces.ravel().tolist()
    flags = bullet().GEOM_FORCE_CONCAVE_TRIMESH
    return bullet().createCollisionShape(  # type: ignore[no-any-return]
        bullet().GEOM_MESH, vertices=corners, indices=indices, flags=flags, physicsClientId=client
    )


def _slab(client: int, plate: Mesh) -> int:
    low, high = plate.vertices.min(axis=0), plate.vertices.max(axis=0)
    (x, y, _), half = (0.5 * (low + high)).tolist(), 0.5 * (high - low)
    edges, middle = [float(half[0]), float(half[1]), 0.5 * SLAB_M], [x, y, float(high[2]) - 0.5 * SLAB_M]
    return bullet().createCollisionShape(  # type: ignore[no-any-return]
        bullet().GEOM_BOX, halfExtents=edges, collisionFramePosition=middle, physicsClientId=client
    )
