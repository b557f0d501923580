"""State estimation: strapdown integration at the inertial rate, corrected by fixes in an error-state Kalman filter.

Products of matrices are fused multiply-adds in the order of the terms, one rounding each, so that their bits are the
same on every processor; the bits of a BLAS depend on the kernels that it chooses for the processor.

The error is of (position, velocity, attitude, rate bias, force bias); attitude errors are small rotation vectors in the
world frame.  A fix measures position x, y, z and heading.

The filter is `filterpy.kalman.KalmanFilter` over the error of the state.  A late fix is compared with the estimate for
the time of its stamp.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import accumulate
from typing import Any, cast

import numpy as np
from filterpy.kalman import KalmanFilter
from numba import types
from numba.extending import intrinsic

from scaloft_fi.marks import NotNegative, Positive
from scaloft_fi.stack.declaration import TICK_S
from scaloft_fi.stack.kernel import jit
from scaloft_fi.stack.messages import Array, Fix, Imu
from scaloft_fi.stack.reference.messages import PoseEstimate

GRAVITY_MPS2 = 9.81

# Layout of the nominal state.
POSITION, VELOCITY, ATTITUDE, RATE_BIAS, STATE_SIZE = 0, 3, 6, 10, 16

# Layout of the numbers that a sample changes: state, its rotation matrix, integrated force, last rate, two times.
_ROTATION, _FORCE, _RATE, _TIMES, NUMBERS = accumulate((STATE_SIZE, 9, 3, 3, 2))

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
    r[0, 0], r[0, 1], r[0, 2] = 1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)
    r[1, 0], r[1, 1], r[1, 2] = 2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)
    r[2, 0], r[2, 1], r[2, 2] = 2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)


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
        numbers: (33,) see `parts_of`.  Of the state, position [m], velocity [m/s] and attitude x, y, z, w advance, and
            the biases stay [rad/s, m/s2]; the rotation is that of the new attitude; the force is the sum of specific
            force x dt since it was last cleared [m/s, world]; the rate is without its bias [rad/s, body]; the times are
            the last sample's stamp and the time of the last integration [s].
    """
    state, r, world_force, body_rate, times = parts_of(numbers)
    dt_s = stamp_s - times[STAMP_S]
    times[STAMP_S] = stamp_s
    if not 0.0 < dt_s < GAP_S:
        return
    times[USED_S] = now_s
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
def yaw_of(q: Array) -> float:
    """Heading [rad] of quaternion `q` (4,) [x, y, z, w]."""
    return math.atan2(2.0 * (q[3] * q[2] + q[0] * q[1]), 1.0 - 2.0 * (q[1] * q[1] + q[2] * q[2]))


SIZE = 15
"""Components of the error: position, velocity, attitude, rate bias, force bias, three each."""
MEASURED = (0, 1, 2, 8)
"""Components of the error that a fix measures: position x, y, z and heading."""
_FIX, _PLACES = len(MEASURED), np.array(MEASURED)
_BLOCK = 5  # columns that are summed at once: while one sum waits for its last term, the others go on


def _emit_fused(_typing: Any, _a: Any, _b: Any, _c: Any) -> Any:
    def emit(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        return builder.fma(*arguments)

    return types.float64(types.float64, types.float64, types.float64), emit


fused = cast(Callable[[float, float, float], float], intrinsic(_emit_fused))
"""a * b + c, rounded once."""


@jit
def _product(a: Array, b: Array, out: Array) -> None:
    """Write a b into `out`; all (SIZE, SIZE)."""
    for i in range(SIZE):
        for j in range(0, SIZE, _BLOCK):
            s = t = u = v = w = 0.0
            for k in range(SIZE):
                x = a[i, k]
                s, t, u = fused(x, b[k, j], s), fused(x, b[k, j + 1], t), fused(x, b[k, j + 2], u)
                v, w = fused(x, b[k, j + 3], v), fused(x, b[k, j + 4], w)
            out[i, j], out[i, j + 1], out[i, j + 2], out[i, j + 3], out[i, j + 4] = s, t, u, v, w


@jit
def _both_sides(f: Array, p: Array) -> Array:
    """The product f p f', (SIZE, SIZE) as both are."""
    half, turned, out = np.empty((SIZE, SIZE)), np.empty((SIZE, SIZE)), np.empty((SIZE, SIZE))
    for i in range(SIZE):
        for j in range(SIZE):
            turned[j, i] = f[i, j]
    _product(f, p, half)
    _product(half, turned, out)
    return out


@jit
def carried(f: Array, p: Array, noise: Array) -> Array:
    """The covariance after a step: f p f' + noise; all (SIZE, SIZE)."""
    return _both_sides(f, p) + noise


@jit
def _times(a: Array, b: Array) -> Array:
    """The product a b of small matrices."""
    out = np.zeros((a.shape[0], b.shape[1]))
    for i in range(a.shape[0]):
        for j in range(b.shape[1]):
            for k in range(a.shape[1]):
                out[i, j] = fused(a[i, k], b[k, j], out[i, j])
    return out


@jit
def corrected(p: Array, noise: Array, inverse: Array, z: Array) -> tuple[Array, Array, Array]:
    """Gain (SIZE, 4), error (SIZE,) and covariance (SIZE, SIZE) after a fix, in Joseph's form.

    Args:
        p: (SIZE, SIZE) covariance before the fix.
        noise: (4, 4) covariance of a fix.
        inverse: (4, 4) inverse of the innovation's covariance.
        z: (4,) the innovation, fix minus estimate.
    """
    gain, error, kept = _times(p[:, _PLACES], inverse), np.empty(SIZE), np.eye(SIZE)
    for i in range(SIZE):
        for j in range(_FIX):
            kept[i, MEASURED[j]] -= gain[i, j]
        # summed in pairs, as numpy does, and from +0: an innovation of 0 gives an error of +0, not of -0
        error[i] = 0.0 + ((gain[i, 0] * z[0] + gain[i, 2] * z[2]) + (gain[i, 1] * z[1] + gain[i, 3] * z[3]))
    return gain, error, _both_sides(kept, p) + _times(_times(gain, noise), gain.T)


@jit
def update(p: Array, noise: Array, z: Array, spread: Array, gain: Array, error: Array) -> None:
    """Correct by the innovation `z` (4,), in place, because each array that a kernel returns is made anew.

    Args:
        p: (15, 15) covariance of the error.
        noise: (4, 4) covariance of a fix.
        z: (4,) fix minus estimate.
        spread: (4, 4) receives the innovation's covariance.
        gain, error: (15, 4), (15,) receive those of `corrected`.

    Raises:
        numpy.linalg.LinAlgError: the covariance of the innovation is singular.
    """
    for i in range(_FIX):
        for j in range(_FIX):
            spread[i, j] = p[MEASURED[i], MEASURED[j]] + noise[i, j]
    inverse = np.linalg.solve(spread, np.eye(_FIX))  # by LAPACK's dgesv, as in scipy
    gain[:], error[:], p[:] = corrected(p, noise, inverse, z)  # type: ignore[arg-type]


class ErrorFilter(KalmanFilter):  # type: ignore[misc]
    """`KalmanFilter` for an error that is zero before each correction and of which four components are measured.

    It keeps filterpy's matrices, makes none of filterpy's copies for inspection, and computes in compiled kernels.
    """

    P: Array

    def predict(self) -> None:
        """Carry the covariance over one step; an error of zero stays zero."""
        self.P = carried(self.F, self.P, self.Q)

    def update(self, z: Array) -> None:
        """Correct by the innovation `z` (4,), fix minus estimate: x, y, z [m] and heading [rad].

        Raises:
            numpy.linalg.LinAlgError: the covariance of the innovation is singular.
        """
        try:
            update(self.P, self.R, z, self.S, self.K, self.x)
        except np.linalg.LinAlgError:
            raise np.linalg.LinAlgError("Singular matrix") from None


def error_filter(config: EstimatorConfig) -> ErrorFilter:
    """The filter before take-off."""
    kf = ErrorFilter(dim_x=SIZE, dim_z=len(MEASURED))
    kf.x = np.zeros(SIZE)
    kf.P = np.diag(np.repeat([1e-4, 1e-4, 1e-4, 1e-5, 1e-3], 3))
    noises = (config.force_noise, config.rate_noise, config.rate_bias_walk, config.force_bias_walk)
    kf.Q = np.diag(np.repeat([1e-10, *(noise**2 * TICK_S for noise in noises)], 3))
    kf.H = np.eye(SIZE)[list(MEASURED)]
    kf.R = np.diag([config.fix_sigma_m**2] * 3 + [config.fix_yaw_sigma_rad**2])
    return kf


@jit
def transition(f: Array, dt_s: float, world_force: Array, r: Array) -> None:
    """Write the transition of the error over `dt_s` into the matrix `f` (15, 15).

    Args:
        f: (15, 15) the identity but for the entries that this function writes.
        dt_s: time since the last prediction [s].
        world_force: (3,) sum of specific force x dt in that time [m/s, world].
        r: (3, 3) attitude, body to world.
    """
    ax, ay, az = world_force[0], world_force[1], world_force[2]
    f[3, 7], f[3, 8] = az, -ay
    f[4, 6], f[4, 8] = -az, ax
    f[5, 6], f[5, 7] = ay, -ax
    for i in range(3):
        f[i, 3 + i] = dt_s
        for k in range(3):
            f[3 + i, 12 + k] = f[6 + i, 9 + k] = -dt_s * r[i, k]


@jit
def plausible(error: Array, covariance: Array, noise: Array, gate_sigma: float) -> bool:
    """Whether each component of `error` (4,) is within `gate_sigma` standard deviations.

    Args:
        error: (4,) fix minus estimate: position x, y, z [m] and heading [rad].
        covariance: (15, 15) of the estimator's error.
        noise: (4, 4) covariance of a fix.
        gate_sigma: greatest accepted number of standard deviations.
    """
    for i in range(4):
        k = i if i < 3 else 8
        if not abs(error[i]) <= gate_sigma * math.sqrt(covariance[k, k] + noise[i, i]):
            return False
    return True


TAU, HALF_TURN = 2.0 * math.pi, math.pi


@jit
def wrapped(angle: float) -> float:
    """`math.remainder(angle, 2 pi)`: the exact rest (IEEE 754) within half a turn.

    Raises:
        ValueError: the angle is infinite.
    """
    if math.isinf(angle):
        raise ValueError("math domain error")
    turns = np.rint(angle / TAU)
    if turns == 0.0 or math.isnan(angle):
        return angle
    rest = fused(-turns, TAU, angle)
    if abs(rest) > HALF_TURN:  # the quotient was rounded across the middle
        turns += 1.0 if rest > 0.0 else -1.0
        rest = fused(-turns, TAU, angle)
    if abs(rest) == HALF_TURN and turns % 2.0 != 0.0:
        return -rest
    return rest if rest != 0.0 else math.copysign(0.0, angle)


@jit
def recalled(rows: Array, begin: int, end: int, stamp_s: float, out: Array) -> None:
    """Write into `out` (4,) position and heading at `stamp_s`; outside the rows those of the last or the first.

    Args:
        rows: (N, 5) time [s], position x, y, z [m, world], heading [rad].
        begin, end: which of the rows count.
        stamp_s: time [s].
        out: (4,) receives the result.
    """
    before = after = end - 1
    for k in range(end - 1, begin - 1, -1):
        before = k
        if rows[k, 0] <= stamp_s:
            break
        after = k
    for axis in range(4):
        out[axis] = rows[before, 1 + axis]
    t, later_s = rows[before, 0], rows[after, 0]
    if not t < stamp_s or not t < later_s:
        return
    share = (stamp_s - t) / (later_s - t)
    share = share if share < 1.0 else 1.0
    for axis in range(3):
        out[axis] += share * (rows[after, 1 + axis] - rows[before, 1 + axis])
    out[3] += share * wrapped(rows[after, 4] - rows[before, 4])


@jit
def shifted(rows: Array, begin: int, end: int, by: Array, yaw_rad: float) -> None:
    """Add a correction of position (3,) [m] and heading [rad] to the rows that count, as of `recalled`."""
    for k in range(begin, end):
        for axis in range(3):
            rows[k, 1 + axis] += by[axis]
        rows[k, 4] += yaw_rad


@jit
def noted(rows: Array, begin: int, end: int, now_s: float, numbers: Array, span_s: float) -> int:
    """Write the estimate of `now_s` into row `end`; returns the first row that is not older than the span.

    Args:
        rows, begin, end: as of `recalled`.
        now_s: time [s].
        numbers: (33,) of the estimate, as of `parts_of`.
        span_s: how long rows count [s].
    """
    rows[end, 0] = now_s
    for axis in range(3):
        rows[end, 1 + axis] = numbers[POSITION + axis]
    rows[end, 4] = yaw_of(numbers[ATTITUDE:RATE_BIAS])
    while now_s - rows[begin, 0] > span_s:
        begin += 1
    return begin


class History:
    """Estimates of the last `span_s` seconds.

    Attributes:
        rows: (N, 5) as of `recalled`; those from `begin` to `end` count.
    """

    def __init__(self, span_s: float) -> None:
        self._span_s, self.rows, self.begin, self.end = span_s, np.empty((64, 5)), 0, 0

    def add(self, now_s: float, numbers: Array) -> None:
        """Add the estimate of `now_s`, as of `parts_of`, and drop estimates that are older than the span."""
        if self.end == len(self.rows):
            kept = self.rows[self.begin :]
            self.rows = np.empty((max(64, 4 * len(kept)), 5))
            self.rows[: len(kept)] = kept
            self.begin, self.end = 0, len(kept)
        self.begin = noted(self.rows, self.begin, self.end, now_s, numbers, self._span_s)
        self.end += 1


@jit
def innovation(
    fix_position: Array, fix_yaw_rad: float, stamp_s: float, rows: Array, begin: int, end: int, out: Array
) -> None:
    """Write into `out` (4,) the fix minus the estimate of its time: position x, y, z [m] and heading [rad]."""
    recalled(rows, begin, end, stamp_s, out)
    for axis in range(3):
        out[axis] = fix_position[axis] - out[axis]
    out[3] = wrapped(fix_yaw_rad - out[3])


@jit
def taken(error: Array, numbers: Array, rows: Array, begin: int, end: int) -> None:
    """Take the estimated `error` (15,) off the numbers (33,) of the estimate, and off the recent past (`recalled`)."""
    for i in range(ATTITUDE):
        numbers[i] += error[i]
    for i in range(STATE_SIZE - RATE_BIAS):
        numbers[RATE_BIAS + i] += error[9 + i]
    turn(numbers[ATTITUDE:RATE_BIAS], error[6], error[7], error[8], True)
    shifted(rows, begin, end, error[:3], error[8])


@dataclass(frozen=True)
class EstimatorConfig:
    """Tuning of the estimator.

    Attributes:
        rate_noise: white noise of the gyro [rad/s/sqrt(Hz)].
        force_noise: white noise of the accelerometer [m/s2/sqrt(Hz)].
        rate_bias_walk: drift of the gyro bias [rad/s2/sqrt(Hz)].
        force_bias_walk: drift of the accelerometer bias [m/s3/sqrt(Hz)].
        fix_sigma_m: believed standard deviation of a fix's position [m].
        fix_yaw_sigma_rad: believed standard deviation of a fix's heading [rad].
        gate_sigma: a fix farther from the estimate than this number of standard deviations is refused.
        reset_after_s: after this time of refused fixes the next fix replaces the estimate [s].
        stale_after_s: a fix older than this is refused [s].
        history_s: how long past estimates are kept for late fixes [s].
    """

    rate_noise: NotNegative
    force_noise: NotNegative
    rate_bias_walk: NotNegative
    force_bias_walk: NotNegative
    fix_sigma_m: Positive
    fix_yaw_sigma_rad: Positive
    gate_sigma: NotNegative
    reset_after_s: NotNegative
    stale_after_s: NotNegative
    history_s: NotNegative


class Estimator:
    """The running estimate.

    Attributes:
        numbers: (33,) state, rotation, world_force, rate and two times; the other arrays are views of it.
        state: (16,) nominal state, see `integrate`.
        rate: (3,) last angular rate, bias removed [rad/s, body].
        rotation: (3, 3) attitude as a matrix, body to world.
        world_force: (3,) specific force integrated since the last prediction [m/s, world].
        last_fix_s: time by the stack's clock at which a fix was last accepted [s].
    """

    def __init__(self, config: EstimatorConfig, position: Array, yaw_rad: float) -> None:
        self.config = config
        self.numbers = np.zeros(NUMBERS)
        self.state, self.rotation, self.world_force, self.rate, self._times = parts_of(self.numbers)
        self.state[POSITION:VELOCITY] = position
        self.state[8], self.state[9] = math.sin(0.5 * yaw_rad), math.cos(0.5 * yaw_rad)
        self.last_fix_s = 0.0
        self._fix_stamp_s = 0.0
        self._refused_since_s: float | None = None
        self._predicted_s = 0.0
        rotation(self.state[ATTITUDE:RATE_BIAS], self.rotation)
        self._history = History(config.history_s)
        self._filter = error_filter(config)

    @property
    def last_imu_s(self) -> float:
        """Time of the last inertial sample that was used [s]."""
        return float(self._times[USED_S])

    def inertial(self, now_s: float, imu: Imu) -> None:
        """Integrate one inertial sample."""
        integrate(now_s, imu.stamp_s, imu.rate, imu.force, self.numbers)

    def tick(self, now_s: float, fix: Fix | None) -> PoseEstimate:
        """Predict the error's covariance, correct by `fix` if there is one; returns the estimate."""
        dt_s, self._predicted_s = now_s - self._predicted_s, now_s
        if dt_s > 0.0:
            transition(self._filter.F, dt_s, self.world_force, self.rotation)
            self.world_force[:] = 0.0
            self._filter.predict()
        self._history.add(now_s, self.numbers)
        if fix is not None:
            self._correct(now_s, fix)
        attitude = self.state[ATTITUDE:RATE_BIAS].copy()
        position, velocity = self.state[POSITION:VELOCITY].copy(), self.state[VELOCITY:ATTITUDE].copy()
        return PoseEstimate(now_s, position, velocity, yaw_of(attitude), attitude)

    def _correct(self, now_s: float, fix: Fix) -> None:
        config = self.config
        if (
            not fix.stamp_s > self._fix_stamp_s
            or not now_s - config.stale_after_s <= fix.stamp_s <= now_s + 0.5 * config.stale_after_s
        ):
            return
        self._fix_stamp_s = fix.stamp_s
        past = (self._history.rows, self._history.begin, self._history.end)
        error, kf = np.empty(_FIX), self._filter
        innovation(fix.position, fix.yaw_rad, fix.stamp_s, *past, error)
        if not plausible(error, kf.P, kf.R, config.gate_sigma):
            if self._refused_since_s is None:
                self._refused_since_s = now_s
            if now_s - self._refused_since_s < config.reset_after_s:
                return
            self.state[POSITION:VELOCITY] += error[:3]
            shifted(*past, error[:3], error[3])
            turn(self.state[ATTITUDE:RATE_BIAS], 0.0, 0.0, error[3], True)
        else:
            kf.update(error)
            taken(kf.x, self.numbers, *past)
            kf.x[:] = 0.0
        self._refused_since_s = None
        self.last_fix_s = now_s
