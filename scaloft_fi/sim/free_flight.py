"""One physics step of a body without contact: the arithmetic of Bullet, operation by operation.

PyBullet defines the physics.  This module compiles its step for a single free body, so that steps without contact need
no call of the server.  Bullet 3.2.7 keeps a body as a multibody without links:
`btMultiBody::computeAccelerationsArticulatedBodyAlgorithmMultiDof` and `stepPositionsMultiDof` hold the formulas
(Featherstone, Rigid Body Dynamics Algorithms, 2008), `btMatrix3x3` those between quaternion and matrix.
`sim/agreement.py` checks that the bits equal the server's.
"""

from __future__ import annotations

import math

import numpy as np

from scaloft_fi.sim.build import GRAVITY_MPS2
from scaloft_fi.sim.vehicle import Array, Vehicle
from scaloft_fi.stack.declaration import STEP_S
from scaloft_fi.stack.kernel import jit

_LARGEST_MPS = 100.0
"""Bullet limits every component of velocity and angular rate to this [m/s, rad/s]."""
_LARGEST_TURN = 0.25 * math.pi
"""Greatest rotation in one step [rad]."""
_SMALL_RATE = 0.001
"""Below this rate Bullet expands the sine of half the rotation in a Taylor series [rad/s]."""


def inertia_of(vehicle: Vehicle) -> Array:
    """Argument of `free_step`, (5,): moments of inertia x, y, z [kg m2], mass [kg], 1 / mass [1/kg]."""
    return np.array([*vehicle.inertia, vehicle.mass_kg, 1.0 / vehicle.mass_kg])


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
