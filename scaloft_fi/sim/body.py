"""The vehicle's body in the physics server: pushed by its rotors, stepped, and read.

Steps in which it can touch nothing may be computed outside the server, which is then told where they led.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Callable

import numpy as np

from scaloft_fi.sim.build import VEHICLE_GROUP, WORLD_GROUP
from scaloft_fi.sim.free_flight import attitude_of, free_step, inertia_of, turn_through
from scaloft_fi.sim.vehicle import NUMBERS, STATE_SIZE, Array, Vehicle, actuate, parts_of
from scaloft_fi.sim.world import Point

_pack = struct.Struct(f"{STATE_SIZE}d").pack_into


UNTURNED = 1200
"""So many rates are kept before `turned` is brought up to date: those of 5 s."""

Drive = Callable[[int], None]
"""Called with the number of a physics step before it, to set force and torque."""


class Body:
    """The vehicle in the physics server.

    Args:
        client: physics server.
        vehicle: what flies.
        position: of its centre [m, world], where it is put at rest.
        yaw_rad: its heading [rad].

    Attributes:
        number: of the body in the server.
        truth: the 13 numbers of the state after the last step, laid out as `sim.vehicle` says.
        state: (13,) the same as an array, which the next step overwrites.
        thrusts: (4,) thrust of each rotor [N].
        pushed: (6,) force [N, world] and torque [N m, world] of the next step.
        numbers: (46,) state, thrusts and what `actuate` works on, see `vehicle.parts_of`.
        inertia: (5,) what `free_step` reads.
    """

    def __init__(self, client: int, vehicle: Vehicle, position: Point, yaw_rad: float) -> None:
        import pybullet

        # A flight makes these calls 240 times a second: bound once, arguments by place.
        self._step = pybullet.stepSimulation
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
        self._turned, self._rates = inverse_at(yaw_rad), list[tuple[float, ...]]()
        self.read()

    def actuate(self, order: Array) -> None:
        """Turn the rotors towards thrusts `order` (4,) [N]: the force and torque of the next step."""
        actuate(self.thrusts, order, self._lag, self._effect, self.state, self.pushed)

    def moves(self, drive: Drive, first: int, count: int) -> float:
        """Physics steps, each under the force and torque that `numbers` has then.

        Args:
            drive: sets them before each step.
            first: number of the first step.
            count: of steps.

        Returns:
            The greatest square of the speed after a step [m2/s2].
        """
        push, turn, step, pose, motion = self._push, self._turn, self._step, self._pose, self._motion
        number, client, frame = self.number, self._client, self._world_frame
        pushed, buffer, position, top_square = self.pushed.tolist, self._buffer, self._position, 0.0
        turns = self._rates.append
        for i in range(first, first + count):
            drive(i)
            fx, fy, fz, tx, ty, tz = pushed()
            push(number, -1, (fx, fy, fz), position, frame, client)
            turn(number, -1, (tx, ty, tz), frame, client)
            step(client)
            position, attitude = pose(number, client)
            velocity, rate = motion(number, client)
            turns(rate)
            truth = (*position, *attitude, *velocity, *rate)
            _pack(buffer, 0, *truth)
            vx, vy, vz = velocity
            square = vx * vx + vy * vy + vz * vz
            if square > top_square:
                top_square = square
        self._position, self.truth = position, truth
        if len(self._rates) > UNTURNED:
            self.turned()
        return top_square

    def glides(self, drive: Drive, first: int, count: int) -> float:
        """The same where nothing can be touched, computed outside the server."""
        turned, pushed, state, inertia, top_square = self.turned(), self.pushed, self.state, self.inertia, 0.0
        for i in range(first, first + count):
            drive(i)
            top_square = max(top_square, free_step(state, turned, pushed, inertia))
        self.follow()
        return top_square

    def turned(self) -> Array:
        """The quaternion from world to body (4,) to the bit as the server has it, which it does not tell."""
        if self._rates:
            turn_through(self._turned, np.array(self._rates))
            self._rates.clear()
        return self._turned

    def follow(self) -> None:
        """Tell the server of `state` and `turned`, which were advanced without it."""
        number, client = self.number, self._client
        x, y, z, w = self._turned.tolist()
        self.truth = truth = tuple(self.state.tolist())
        self._position = truth[:3]
        self._put(number, self._position, (-x, -y, -z, w), client)
        self._throw(number, truth[7:10], truth[10:], client)

    def read(self) -> None:
        """Read the true state."""
        number, client = self.number, self._client
        self._position, attitude = self._pose(number, client)
        velocity, rate = self._motion(number, client)
        self.truth = (*self._position, *attitude, *velocity, *rate)
        _pack(self._buffer, 0, *self.truth)


def inverse_at(yaw_rad: float) -> Array:
    """What the server makes of the attitude of a body that is put upright at `yaw_rad`: (4,) from world to body."""
    turned, attitude = np.array([0.0, 0.0, -math.sin(0.5 * yaw_rad), math.cos(0.5 * yaw_rad)]), np.empty(4)
    attitude_of(turned, attitude)  # it takes it by way of a matrix, as it tells it
    turned[:3], turned[3] = -attitude[:3], attitude[3]
    return turned


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
