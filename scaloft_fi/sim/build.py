"""The world as bodies of a physics server."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from scaloft_fi.sim.mesh import Mesh
from scaloft_fi.sim.mine import SLAB_M
from scaloft_fi.sim.world import GROUND, WALL, World
from scaloft_fi.stack.declaration import STEP_S

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


def connect() -> int:
    """Start a physics server in this process, without a window; returns its client number."""
    import pybullet

    return int(pybullet.connect(pybullet.DIRECT))


def set_up(client: int) -> None:
    """Set gravity, time step and a fixed order of contact pairs in an empty physics server."""
    import pybullet

    pybullet.setGravity(0.0, 0.0, -GRAVITY_MPS2, physicsClientId=client)
    pybullet.setPhysicsEngineParameter(fixedTimeStep=STEP_S, deterministicOverlappingPairs=1, physicsClientId=client)


def build(client: int, world: World) -> BodyIds:
    """Put the world into an empty physics server.

    The rock consists of the triangles that the camera sees.  Bullet adds a margin of 1 mm to them, so distances to rock
    are 1 mm too short.  Bodies are convex hulls; with Bullet's margin they have the surface that the camera sees.
    A level floor is a solid box under the same triangles.
    """
    import pybullet

    set_up(client)
    ground = world.mine.ground
    ids = {
        WALL: _fixed(client, pybullet, _triangles(client, pybullet, world.mine.wall)),
        GROUND: _fixed(
            client, pybullet, (_slab if world.mine.ground_is_slab else _triangles)(client, pybullet, ground)
        ),
    }
    for body in world.present:
        ids[body.name] = _fixed(client, pybullet, _hull(client, pybullet, body.core))
    return BodyIds(ids)


def place(client: int, ids: BodyIds, shifts: Mapping[str, Sequence[float]]) -> None:
    """Put bodies at their positions plus `shifts` (3,) [m, world]."""
    import pybullet

    for name, by_m in shifts.items():
        pybullet.resetBasePositionAndOrientation(ids.by_name[name], by_m, (0.0, 0.0, 0.0, 1.0), physicsClientId=client)


def _triangles(client: int, pybullet: Any, mesh: Mesh) -> int:
    return int(
        pybullet.createCollisionShape(
            pybullet.GEOM_MESH,
            vertices=mesh.vertices.tolist(),
            indices=mesh.faces.ravel().tolist(),
            flags=pybullet.GEOM_FORCE_CONCAVE_TRIMESH,
            physicsClientId=client,
        )
    )


def _hull(client: int, pybullet: Any, mesh: Mesh) -> int:
    return int(
        pybullet.createCollisionShape(pybullet.GEOM_MESH, vertices=mesh.vertices.tolist(), physicsClientId=client)
    )


def _slab(client: int, pybullet: Any, plate: Mesh) -> int:
    low, high = plate.vertices.min(axis=0), plate.vertices.max(axis=0)
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    return int(
        pybullet.createCollisionShape(
            pybullet.GEOM_BOX,
            halfExtents=[float(half[0]), float(half[1]), 0.5 * SLAB_M],
            collisionFramePosition=[float(middle[0]), float(middle[1]), float(high[2]) - 0.5 * SLAB_M],
            physicsClientId=client,
        )
    )


def _fixed(client: int, pybullet: Any, shape: int) -> int:
    number = int(pybullet.createMultiBody(baseMass=0.0, baseCollisionShapeIndex=shape, physicsClientId=client))
    pybullet.setCollisionFilterGroupMask(number, -1, WORLD_GROUP, VEHICLE_GROUP | RAY_GROUP, physicsClientId=client)
    return number
