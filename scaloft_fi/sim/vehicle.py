"""The vehicle: a rigid hull with four rotors, its compiled step in free flight, its body in the physics server.

PyBullet defines the physics.  This module compiles its step for a single free body, so that steps without contact need
no call of the server.  Bullet 3.2.7 keeps a body as a multibody without links:
`btMultiBody::computeAccelerationsArticulatedBodyAlgorithmMultiDof` and `stepPositionsMultiDof` hold the formulas
(Featherstone, Rigid Body Dynamics Algorithms, 2008), `btMatrix3x3` those between quaternion and matrix.
`sim/flight.py` checks that the bits equal the server's.

Steps in which the vehicle can touch nothing may be computed outside the server; the server then gets the final state.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np
from numpy.typing import NDArray

from scaloft_fi.document import Item
from scaloft_fi.errors import InputError
from scaloft_fi.marks import Bounds, Examples
from scaloft_fi.sim.build import GRAVITY_MPS2, VEHICLE_GROUP, WORLD_GROUP, bullet
from scaloft_fi.sim.world import Point
from scaloft_fi.stack.declaration import STEP_S
from scaloft_fi.stack.kernel import jit

Array = NDArray[np.float64]

SMALLEST, LARGEST = 1e-6, 1e4
"""Bounds of every mass, inertia, length, thrust and time of a vehicle, far beyond those of any drone."""

Size = Annotated[float, Bounds(least=SMALLEST, most=LARGEST)]
_Offset = Annotated[float, Bounds(least=-LARGEST, most=LARGEST)]
Place = tuple[_Offset, _Offset]
Spin = Literal[1, -1]

POSITION, ATTITUDE, VELOCITY, RATE = slice(0, 3), slice(3, 7), slice(7, 10), slice(10, 13)
"""Layout of the vehicle's state (13,): position [m, world], attitude quaternion x, y, z, w (body to world),
velocity [m/s, world], angular rate [rad/s, world]."""
STATE_SIZE = 13

# Layout of the numbers of a step: state, thrusts, force and torque, lag, effect.
_THRUSTS, _PUSHED, _LAG, _EFFECT, NUMBERS = 13, 17, 23, 26, 46


@dataclass(frozen=True, eq=False)
class Vehicle:
    """The vehicle: a rigid hull with four rotors.  Body axes: x forward, y left, z up.

    Attributes:
        mass_kg: mass [kg].
        inertia_kgm2: (3,) principal moments of inertia x, y, z [kg m2, body].
        hull_m: (3,) edges of the hull, a box about the centre [m, body].
        rotors_m: (4, 2) places x, y of the rotors [m, body].
        spins: (4,) direction of each rotor's torque about body z, 1 or -1.
        moment_m: rotor torque per thrust [m].
        max_thrust_n: greatest thrust of one rotor; four must lift the mass [N].
        spin_up_s, spin_down_s: time constants of the thrust [s].
        drag_ns_per_m: drag force per speed [N s/m].
        throttle_exponent: curve of the speed controllers, for a firmware that orders throttles: a rotor's thrust is its
            greatest times its throttle to this power; 2: the throttle sets the speed, with whose square thrust grows.
    """

    mass_kg: Size
    inertia_kgm2: tuple[Size, Size, Size]
    hull_m: Annotated[tuple[Size, Size, Size], Examples((0.47, 0.47, 0.11))]
    rotors_m: tuple[Place, Place, Place, Place]
    spins: tuple[Spin, Spin, Spin, Spin]
    moment_m: Size
    max_thrust_n: Size
    spin_up_s: Size
    spin_down_s: Size
    drag_ns_per_m: Annotated[float, Bounds(least=0.0, most=LARGEST)]
    throttle_exponent: Annotated[float, Bounds(least=1.0, most=3.0)] = 2.0

    def contradictions(self, item: Item) -> Iterator[InputError]:
        """Refuse rotors that cannot lift the mass."""
        weight_n = self.mass_kg * GRAVITY_MPS2
        if 4.0 * self.max_thrust_n <= weight_n:
            yield item.need("max_thrust_n").error(f"> {weight_n / 4:.2f} to lift off")

    @property
    def half_height_m(self) -> float:
        """Height of the centre above the floor on which the vehicle stands [m]."""
        return 0.5 * self.hull_m[2]

    def lag(self) -> Array:
        """Argument of `rotor_step`, (3,): share of the thrust error removed per step, up and down; greatest thrust."""
        up, down = (1.0 - math.exp(-STEP_S / constant_s) for constant_s in (self.spin_up_s, self.spin_down_s))
        return np.array([up, down, self.max_thrust_n])

    def effect(self) -> Array:
        """Argument of `wrench`, (5, 4): force z and torques x, y, z per rotor thrust [1, m, m, m]; drag at [4, 0]."""
        effect = np.zeros((5, 4))
        effect[0] = 1.0
        effect[1] = np.array(self.rotors_m)[:, 1]
        effect[2] = -np.array(self.rotors_m)[:, 0]
        effect[3] = self.moment_m * np.array(self.spins, np.float64)
        effect[4, 0] = self.drag_ns_per_m
        return effect


@jit
def parts_of(numbers: Array) -> tuple[Array, Array, Array, Array, Array]:
    """State (13,), thrusts (4,), force and torque (6,), lag (3,), effect (5, 4) as views of `numbers` (46,)."""
    effect = numbers[_EFFECT:NUMBERS].reshape((5, 4))
    return numbers[:_THRUSTS], numbers[_THRUSTS:_PUSHED], numbers[_PUSHED:_LAG], numbers[_LAG:_EFFECT], effect


@jit
def rotor_step(thrusts: Array, command: Array, lag: Array) -> None:
    """Advance the rotors by one 240 Hz step, in place: first-order lag, faster up than down, within their limits.

    Args:
        thrusts: (4,) thrust of each rotor [N].
        command: (4,) commanded thrust [N]; a value that is not finite stops the rotor.
        lag: (3,) from `Vehicle.lag`.
    """
    for i in range(4):
        wanted = command[i] if np.isfinite(command[i]) else 0.0
        wanted = min(max(wanted, 0.0), lag[2])
        thrusts[i] += (wanted - thrusts[i]) * (lag[0] if wanted > thrusts[i] else lag[1])


@jit
def wrench(thrusts: Array, state: Array, effect: Array, force: Array, torque: Array) -> None:
    """Compute force and torque of rotors and air on the vehicle.

    Args:
        thrusts: (4,) thrust of each rotor [N].
        state: (13,) state of the vehicle.
        effect: (5, 4) from `Vehicle.effect`; the air's own force [N, world] at [4, 1:].
        force: (3,) receives the force [N, world].
        torque: (3,) receives the torque [N m, world].
    """
    lift, tx, ty, tz = 0.0, 0.0, 0.0, 0.0
    for i in range(4):
        lift += effect[0, i] * thrusts[i]
        tx += effect[1, i] * thrusts[i]
        ty += effect[2, i] * thrusts[i]
        tz += effect[3, i] * thrusts[i]
    x, y, z, w = state[3], state[4], state[5], state[6]
    ux, uy, uz = 2.0 * (x * z + y * w), 2.0 * (y * z - x * w), 1.0 - 2.0 * (x * x + y * y)
    drag = effect[4, 0]
    force[0] = lift * ux - drag * state[7]
    force[1] = lift * uy - drag * state[8]
    force[2] = lift * uz - drag * state[9]
    if effect[4, 1] != 0.0 or effect[4, 2] != 0.0 or effect[4, 3] != 0.0:
        for k in range(3):
            force[k] += effect[4, 1 + k]
    torque[0] = (1.0 - 2.0 * (y * y + z * z)) * tx + 2.0 * (x * y - z * w) * ty + ux * tz
    torque[1] = 2.0 * (x * y + z * w) * tx + (1.0 - 2.0 * (x * x + z * z)) * ty + uy * tz
    torque[2] = 2.0 * (x * z - y * w) * tx + 2.0 * (y * z + x * w) * ty + uz * tz


@jit
def actuate(thrusts: Array, order: Array, lag: Array, effect: Array, state: Array, pushed: Array) -> None:
    """Apply `rotor_step`, then `wrench`; `pushed` (6,) receives force, then torque."""
    rotor_step(thrusts, order, lag)
    wrench(thrusts, state, effect, pushed[:3], pushed[3:])


_LARGEST_MPS = 100.0
"""Bullet limits every component of velocity and angular rate to this [m/s, rad/s]."""
_LARGEST_TURN = 0.25 * math.pi
"""Greatest rotation in one step [rad]."""
_SMALL_RATE = 0.001
"""Below this rate Bullet expands the sine of half the rotation in a Taylor series [rad/s]."""


def inertia_of(vehicle: Vehicle) -> Array:
    """Argument of `free_step`, (5,): moments of inertia x, y, z [kg m2], mass [kg], 1 / mass [1/kg]."""
    return np.array([*vehicle.inertia_kgm2, vehicle.mass_kg, 1.0 / vehicle.mass_kg])


@jit
def free_step(state: Array, inverse: Array, pushed: Array, inertia: Array) -> float:
    """Advance `state` and `inverse` by one step, in place; returns the square of the speed after it [m2/s2].

    Args:
        state: (13,) state of the body in the layout of `sim.vehicle`.
        inverse: (4,) quaternion x, y, z, w from world to body, which Bullet keeps; `state` holds its rounded inverse.
        pushed: (6,) force at the centre [N, world], torque [N m, world], without weight.
        inertia: (5,) from `inertia_of`.
    """
    r = np.empty((3, 3))
    matrix_of(inverse[0], inverse[1], inverse[2], inverse[3], r)
    ix, iy, iz, mass, per_mass = inertia[0], inertia[1], inertia[2], inertia[3], inertia[4]
    vx, vy, vz, ox, oy, oz = state[7], state[8], state[9], state[10], state[11], state[12]
    fx, fy, fz = pushed[0], pushed[1], pushed[2] + -GRAVITY_MPS2 * mass
    tx, ty, tz = pushed[3], pushed[4], pushed[5]

    # In the body frame: angular rate w, velocity v, then the force and torque that would keep both constant.
    wx = r[0, 0] * ox + r[0, 1] * oy + r[0, 2] * oz
    wy = r[1, 0] * ox + r[1, 1] * oy + r[1, 2] * oz
    wz = r[2, 0] * ox + r[2, 1] * oy + r[2, 2] * oz
    ux = r[0, 0] * vx + r[0, 1] * vy + r[0, 2] * vz
    uy = r[1, 0] * vx + r[1, 1] * vy + r[1, 2] * vz
    uz = r[2, 0] * vx + r[2, 1] * vy + r[2, 2] * vz
    spin_x, spin_y, spin_z = ix * wx, iy * wy, iz * wz
    swing_x, swing_y, swing_z = wy * uz - wz * uy, wz * ux - wx * uz, wx * uy - wy * ux
    hold_x = -(r[0, 0] * tx + r[0, 1] * ty + r[0, 2] * tz) + spin_x * 0.0 + (wy * spin_z - wz * spin_y)
    hold_y = -(r[1, 0] * tx + r[1, 1] * ty + r[1, 2] * tz) + spin_y * 0.0 + (wz * spin_x - wx * spin_z)
    hold_z = -(r[2, 0] * tx + r[2, 1] * ty + r[2, 2] * tz) + spin_z * 0.0 + (wx * spin_y - wy * spin_x)
    bear_x = -(r[0, 0] * fx + r[0, 1] * fy + r[0, 2] * fz) + mass * ux * 0.0 + mass * swing_x
    bear_y = -(r[1, 0] * fx + r[1, 1] * fy + r[1, 2] * fz) + mass * uy * 0.0 + mass * swing_y
    bear_z = -(r[2, 0] * fx + r[2, 1] * fy + r[2, 2] * fz) + mass * uz * 0.0 + mass * swing_z

    ax, ay, az = -(hold_x / ix), -(hold_y / iy), -(hold_z / iz)
    gx, gy, gz = -(bear_x * per_mass) + swing_x, -(bear_y * per_mass) + swing_y, -(bear_z * per_mass) + swing_z
    for k in range(3):
        state[10 + k] = _kept(state[10 + k] + (r[0, k] * ax + r[1, k] * ay + r[2, k] * az) * STEP_S)
        state[7 + k] = _kept(state[7 + k] + (r[0, k] * gx + r[1, k] * gy + r[2, k] * gz) * STEP_S)
        state[k] += STEP_S * state[7 + k]
    turn_on(inverse, state[10:13])
    attitude_of(inverse, state[3:7])
    square: float = state[7] * state[7] + state[8] * state[8] + state[9] * state[9]
    return square


@jit
def _kept(speed):  # type: ignore[no-untyped-def]
    """Limit a component as the server does; adding 0.0, as the server does, turns -0.0 into 0.0."""
    if speed < -_LARGEST_MPS:
        speed = -_LARGEST_MPS
    elif speed > _LARGEST_MPS:
        speed = _LARGEST_MPS
    return speed + 0.0


@jit
def turn_on(inverse: Array, rate: Array) -> None:
    """Advance `inverse` (4,), world to body, by one step at angular rate `rate` (3,) [rad/s, world], in place."""
    x, y, z = rate[0], rate[1], rate[2]
    size = math.sqrt(x * x + y * y + z * z)
    if size * STEP_S > _LARGEST_TURN:
        size = _LARGEST_TURN / STEP_S
    if size < _SMALL_RATE:
        share = 0.5 * STEP_S - (STEP_S * STEP_S * STEP_S) * 0.020833333333 * size * size
    else:
        share = math.sin(0.5 * size * STEP_S) / size
    bx, by, bz, bw = -(x * share), -(y * share), -(z * share), math.cos(size * STEP_S * 0.5)
    ax, ay, az, aw = inverse[0], inverse[1], inverse[2], inverse[3]
    qx = aw * bx + ax * bw + ay * bz - az * by
    qy = aw * by + ay * bw + az * bx - ax * bz
    qz = aw * bz + az * bw + ax * by - ay * bx
    qw = aw * bw - ax * bx - ay * by - az * bz
    scale = 1.0 / math.sqrt(qx * qx + qy * qy + qz * qz + qw * qw)
    inverse[0], inverse[1], inverse[2], inverse[3] = qx * scale, qy * scale, qz * scale, qw * scale


@jit
def turn_through(inverse: Array, rates: Array) -> None:
    """Apply `turn_on` for each row of `rates` (N, 3)."""
    for i in range(len(rates)):
        turn_on(inverse, rates[i])


@jit
def matrix_of(x, y, z, w, r):  # type: ignore[no-untyped-def]
    """Fill `r` (3, 3) with the rotation of a quaternion."""
    s = 2.0 / (x * x + y * y + z * z + w * w)
    xs, ys, zs = x * s, y * s, z * s
    wx, wy, wz = w * xs, w * ys, w * zs
    xx, xy, xz = x * xs, x * ys, x * zs
    yy, yz, zz = y * ys, y * zs, z * zs
    r[0, 0], r[0, 1], r[0, 2] = 1.0 - (yy + zz), xy - wz, xz + wy
    r[1, 0], r[1, 1], r[1, 2] = xy + wz, 1.0 - (xx + zz), yz - wx
    r[2, 0], r[2, 1], r[2, 2] = xz - wy, yz + wx, 1.0 - (xx + yy)


@jit
def attitude_of(inverse: Array, attitude: Array) -> None:
    """Write the attitude (4,), body to world, that the server returns for `inverse` (4,), through a matrix."""
    m = np.empty((3, 3))
    matrix_of(-inverse[0], -inverse[1], -inverse[2], inverse[3], m)
    trace = m[0, 0] + m[1, 1] + m[2, 2]
    if trace > 0.0:
        s = math.sqrt(trace + 1.0)
        attitude[3] = s * 0.5
        s = 0.5 / s
        attitude[0] = (m[2, 1] - m[1, 2]) * s
        attitude[1] = (m[0, 2] - m[2, 0]) * s
        attitude[2] = (m[1, 0] - m[0, 1]) * s
        return
    i = 0
    if m[0, 0] < m[1, 1]:
        i = 2 if m[1, 1] < m[2, 2] else 1
    elif m[0, 0] < m[2, 2]:
        i = 2
    j, k = (i + 1) % 3, (i + 2) % 3
    s = math.sqrt(m[i, i] - m[j, j] - m[k, k] + 1.0)
    attitude[i] = s * 0.5
    s = 0.5 / s
    attitude[3] = (m[k, j] - m[j, k]) * s
    attitude[j] = (m[j, i] + m[i, j]) * s
    attitude[k] = (m[k, i] + m[i, k]) * s


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
        pybullet = bullet()
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
    pybullet = bullet()
    half_m = [0.5 * edge for edge in vehicle.hull_m]
    shape = pybullet.createCollisionShape(pybullet.GEOM_BOX, halfExtents=half_m, physicsClientId=client)
    attitude = [0.0, 0.0, math.sin(0.5 * yaw_rad), math.cos(0.5 * yaw_rad)]
    body = pybullet.createMultiBody(
        vehicle.mass_kg, shape, basePosition=list(position), baseOrientation=attitude, physicsClientId=client
    )
    inertia, awake = list(vehicle.inertia_kgm2), pybullet.ACTIVATION_STATE_DISABLE_SLEEPING
    still = {"linearDamping": 0.0, "angularDamping": 0.0, "activationState": awake}
    pybullet.changeDynamics(body, -1, localInertiaDiagonal=inertia, **still, physicsClientId=client)
    pybullet.setCollisionFilterGroupMask(body, -1, VEHICLE_GROUP, WORLD_GROUP, physicsClientId=client)
    return int(body)
