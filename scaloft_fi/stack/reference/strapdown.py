"""Strapdown integration of the inertial sensor, compiled."""

from __future__ import annotations

import math

from scaloft_fi.stack.fields import Array
from scaloft_fi.stack.kernel import jit

GRAVITY_MPS2 = 9.81

# Layout of the nominal state.
POSITION, VELOCITY, ATTITUDE, RATE_BIAS, FORCE_BIAS, STATE_SIZE = 0, 3, 6, 10, 13, 16

# Layout of the numbers that a sample changes: state, its rotation matrix, integrated force, last rate, two times.
_ROTATION, _FORCE, _RATE, _TIMES = STATE_SIZE, STATE_SIZE + 9, STATE_SIZE + 12, STATE_SIZE + 15
NUMBERS = STATE_SIZE + 17

# Layout of the times.
STAMP_S, USED_S = 0, 1

GAP_S = 0.1
"""An inertial sample that is more than this later than the one before is not integrated [s]."""


@jit
def parts_of(numbers: Array) -> tuple[Array, Array, Array, Array, Array]:
    """State (16,), rotation (3, 3), integrated force (3,), rate (3,) and times (2,) as views of `numbers` (33,)."""
    rotated = numbers[_ROTATION:_FORCE].reshape((3, 3))
    return numbers[:STATE_SIZE], rotated, numbers[_FORCE:_RATE], numbers[_RATE:_TIMES], numbers[_TIMES:NUMBERS]


@jit
def rotation(q: Array, r: Array) -> None:
    """Write the rotation matrix of quaternion `q` (4,) [x, y, z, w], body to world, into `r` (3, 3)."""
    x, y, z, w = q[0], q[1], q[2], q[3]
    r[0, 0] = 1.0 - 2.0 * (y * y + z * z)
    r[0, 1] = 2.0 * (x * y - z * w)
    r[0, 2] = 2.0 * (x * z + y * w)
    r[1, 0] = 2.0 * (x * y + z * w)
    r[1, 1] = 1.0 - 2.0 * (x * x + z * z)
    r[1, 2] = 2.0 * (y * z - x * w)
    r[2, 0] = 2.0 * (x * z - y * w)
    r[2, 1] = 2.0 * (y * z + x * w)
    r[2, 2] = 1.0 - 2.0 * (x * x + y * y)


@jit
def turn(q: Array, dx: float, dy: float, dz: float, in_world: bool) -> None:
    """Turn quaternion `q` (4,) in place by the rotation vector (dx, dy, dz) [rad], of the body or the world frame."""
    angle = math.sqrt(dx * dx + dy * dy + dz * dz)
    s = 0.5 if angle < 1e-9 else math.sin(0.5 * angle) / angle
    ex, ey, ez, ew = dx * s, dy * s, dz * s, math.cos(0.5 * angle)
    x, y, z, w = q[0], q[1], q[2], q[3]
    if in_world:
        x, y, z, w, ex, ey, ez, ew = ex, ey, ez, ew, x, y, z, w
    nx = w * ex + x * ew + y * ez - z * ey
    ny = w * ey - x * ez + y * ew + z * ex
    nz = w * ez + x * ey - y * ex + z * ew
    nw = w * ew - x * ex - y * ey - z * ez
    norm = math.sqrt(nx * nx + ny * ny + nz * nz + nw * nw)
    q[0], q[1], q[2], q[3] = nx / norm, ny / norm, nz / norm, nw / norm


@jit
def integrate(now_s: float, stamp_s: float, rate: Array, force: Array, numbers: Array) -> None:
    """Integrate one inertial sample.

    A sample that is not newer than the one before it, or newer by `GAP_S` or more, only sets the stamp.

    Args:
        now_s: own time [s].
        stamp_s: of the sample [s].
        rate, force: (3,) of the sample [rad/s, m/s2, body].
        numbers: (33,) see `parts_of`; the times are the last sample's stamp and the time of the last integration [s].
    """
    state, r, world_force, body_rate, times = parts_of(numbers)
    dt_s = stamp_s - times[STAMP_S]
    times[STAMP_S] = stamp_s
    if 0.0 < dt_s < GAP_S:
        times[USED_S] = now_s
        propagate(state, rate, force, dt_s, r, world_force, body_rate)


@jit
def propagate(
    state: Array, rate: Array, force: Array, dt_s: float, r: Array, world_force: Array, body_rate: Array
) -> None:
    """Advance the nominal state by one inertial sample, in place.

    Args:
        state: (16,) position [m], velocity [m/s], attitude x, y, z, w, rate bias [rad/s], force bias [m/s2].
        rate: (3,) angular rate [rad/s, body].
        force: (3,) specific force [m/s2, body].
        dt_s: time since the last sample [s].
        r: (3, 3) receives the rotation matrix of the new attitude.
        world_force: (3,) sum of specific force x dt since it was last cleared [m/s, world].
        body_rate: (3,) receives the angular rate without its bias [rad/s, body].
    """
    q = state[ATTITUDE:RATE_BIAS]
    rotation(q, r)
    fx, fy, fz = force[0] - state[13], force[1] - state[14], force[2] - state[15]
    for i in range(3):
        f = r[i, 0] * fx + r[i, 1] * fy + r[i, 2] * fz
        world_force[i] += f * dt_s
        a = f - (GRAVITY_MPS2 if i == 2 else 0.0)
        state[i] += state[3 + i] * dt_s + 0.5 * a * dt_s * dt_s
        state[3 + i] += a * dt_s
        body_rate[i] = rate[i] - state[10 + i]
    turn(q, body_rate[0] * dt_s, body_rate[1] * dt_s, body_rate[2] * dt_s, False)
    rotation(q, r)


@jit
def correct(state: Array, error: Array) -> None:
    """Take the estimated `error` (15,) out of the nominal state (16,), in place.

    Args:
        state: (16,) as `propagate` has it.
        error: (15,) of position [m], velocity [m/s], attitude [rad, world], rate bias [rad/s], force bias [m/s2].
    """
    for i in range(6):
        state[i] += error[i]
        state[10 + i] += error[9 + i]
    turn(state[ATTITUDE:RATE_BIAS], error[6], error[7], error[8], True)


@jit
def yaw_of(q: Array) -> float:
    """Heading [rad] of quaternion `q` (4,) [x, y, z, w]."""
    return math.atan2(2.0 * (q[3] * q[2] + q[0] * q[1]), 1.0 - 2.0 * (q[1] * q[1] + q[2] * q[2]))
