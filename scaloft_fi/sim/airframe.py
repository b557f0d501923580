"""The vehicle in the physics server: apply the forces of its rotors, step it, read its state.

Steps in which the vehicle can touch nothing may be computed outside the server; the server then gets the final state.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Callable

import numpy as np

from scaloft_fi.sim.build import VEHICLE_GROUP, WORLD_GROUP
from scaloft_fi.sim.free_flight import attitude_of, inertia_of, turn_through
from scaloft_fi.sim.vehicle import NUMBERS, STATE_SIZE, Array, Vehicle, actuate, parts_of
from scaloft_fi.sim.world import Point

_pack = struct.Struct(f"{STATE_SIZE}d").pack_into


KEPT_RATES = 1200
"""Greatest number of angular rates that wait to be integrated by `inverse_attitude`: 5 s of steps."""

Drive = Callable[[int], None]
"""Called with the number of a physics step before that step; sets its force and torque."""


class Airframe:
    """The vehicle in the physics server.

    Args:
        client: physics server.
        vehicle: what flies.
        position: where the centre of the vehicle starts, at rest [m, world].
        yaw_rad: heading at the start [rad].

    Attributes:
        number: number of the body in the server.
        truth: the 13 numbers of the state after the last step, in the layout of `sim.vehicle`.
        state: (13,) the same numbers as an array, which the next step overwrites.
        thrusts: (4,) thrust of each rotor [N].
        pushed: (6,) force [N, world] and torque [N m, world] of the next step.
        numbers: (46,) state, thrusts and the arguments of `actuate`, see `vehicle.parts_of`.
        inertia: (5,) argument of `free_step`.
    """

    def __init__(self, client: int, vehicle: Vehicle, position: Point, yaw_rad: float) -> None:
        import pybullet

        # A flight makes these calls 240 times a second, so they are bound once and take positional arguments.
        self._simulate = pybullet.stepSimulation
        self._pose, self._motion = pybullet.getBasePositionAndOrientation, pybullet.getBaseVelocity
        self._push, self._turn = pybullet.applyExternalForce, pybullet.applyExternalTorque
        self._put, self._throw = pybullet.resetBasePositionAndOrientation, pybullet.resetBaseVelocity
        self._world_frame = pybullet.WORLD_FRAME
        self._client = client
        self.numbers = np.zeros(NUMBERS)
        self.state, self.thrusts, self.pushed, self._lag, self._effect = parts_of(self.numbers)
        self._buffer = self.state.data
        self._lag[:], self._effect[:] = vehicle.lag(), vehicle.effect()
        self.number = spawn(client, vehicle, position, yaw_rad)
        self._position: Point = position
        self.truth: tuple[float, ...] = ()
        self.inertia = inertia_of(vehicle)
        self._inverse, self._rates = inverse_at(yaw_rad), list[tuple[float, ...]]()
        self.read()

    def blow(self, wind_mps: Array) -> None:
        """Set the velocity of the air (3,) [m/s, world], which pushes with the vehicle's drag."""
        self._effect[4, 1:] = self._effect[4, 0] * wind_mps

    def actuate(self, order: Array) -> None:
        """Move the thrusts towards `order` (4,) [N], and set force and torque of the next step."""
        actuate(self.thrusts, order, self._lag, self._effect, self.state, self.pushed)

    def step(self, drive: Drive, first: int, count: int) -> float:
        """Let the server make physics steps, each under the current force and torque in `pushed`.

        Args:
            drive: sets `pushed` before each step.
            first: number of the first step.
            count: number of steps.

        Returns:
            The greatest square of the speed after a step [m2/s2].
        """
        push, turn, step, pose, motion = self._push, self._turn, self._simulate, self._pose, self._motion
        number, client, frame = self.number, self._client, self._world_frame
        pushed, buffer, position, top_square = self.pushed.tolist, self._buffer, self._position, 0.0
        keep_rate = self._rates.append
        for i in range(first, first + count):
            drive(i)
            fx, fy, fz, tx, ty, tz = pushed()
            push(number, -1, (fx, fy, fz), position, frame, client)
            turn(number, -1, (tx, ty, tz), frame, client)
            step(client)
            position, attitude = pose(number, client)
            velocity, rate = motion(number, client)
            keep_rate(rate)
            truth = (*position, *attitude, *velocity, *rate)
            _pack(buffer, 0, *truth)
            vx, vy, vz = velocity
            square = vx * vx + vy * vy + vz * vz
            if square > top_square:
                top_square = square
        self._position, self.truth = position, truth
        if len(self._rates) > KEPT_RATES:
            self.inverse_attitude()
        return top_square

    def inverse_attitude(self) -> Array:
        """The quaternion from world to body (4,) as the server keeps it, to the bit; it returns a rounded inverse."""
        if self._rates:
            turn_through(self._inverse, np.array(self._rates))
            self._rates.clear()
        return self._inverse

    def update_server(self) -> None:
        """Set the body in the server to `state` and `inverse_attitude`, which were advanced outside the server."""
        number, client = self.number, self._client
        x, y, z, w = self._inverse.tolist()
        self.truth = truth = tuple(self.state.tolist())
        self._position = truth[:3]
        self._put(number, self._position, (-x, -y, -z, w), client)
        self._throw(number, truth[7:10], truth[10:], client)

    def read(self) -> None:
        """Read the true state from the server."""
        number, client = self.number, self._client
        self._position, attitude = self._pose(number, client)
        velocity, rate = self._motion(number, client)
        self.truth = (*self._position, *attitude, *velocity, *rate)
        _pack(self._buffer, 0, *self.truth)


def inverse_at(yaw_rad: float) -> Array:
    """The quaternion from world to body (4,) that the server keeps for an upright body with heading `yaw_rad`."""
    inverse, attitude = np.array([0.0, 0.0, -math.sin(0.5 * yaw_rad), math.cos(0.5 * yaw_rad)]), np.empty(4)
    attitude_of(inverse, attitude)  # the server converts through a matrix, in both directions
    inverse[:3], inverse[3] = -attitude[:3], attitude[3]
    return inverse


def spawn(client: int, vehicle: Vehicle, position: Point, yaw_rad: float) -> int:
    """Put the vehicle at rest into the physics server; returns its body number."""
    import pybullet

    shape = pybullet.createCollisionShape(
        pybullet.GEOM_BOX, halfExtents=[0.5 * edge for edge in vehicle.hull_m], physicsClientId=client
    )
    body = pybullet.createMultiBody(
        baseMass=vehicle.mass_kg,
        baseCollisionShapeIndex=shape,
        basePosition=list(position),
        baseOrientation=[0.0, 0.0, math.sin(0.5 * yaw_rad), math.cos(0.5 * yaw_rad)],
        physicsClientId=client,
    )
    pybullet.changeDynamics(
        body,
        -1,
        localInertiaDiagonal=list(vehicle.inertia),
        linearDamping=0.0,
        angularDamping=0.0,
        activationState=pybullet.ACTIVATION_STATE_DISABLE_SLEEPING,
        physicsClientId=client,
    )
    pybullet.setCollisionFilterGroupMask(body, -1, VEHICLE_GROUP, WORLD_GROUP, physicsClientId=client)
    return int(body)
