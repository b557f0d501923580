"""State estimation: strapdown integration at the inertial rate, corrected by fixes in an error-state Kalman filter.

The filter is `filterpy.kalman.KalmanFilter` over the error of (position, velocity, attitude, rate bias, force bias);
attitude errors are small rotation vectors in the world frame.  A late fix is compared with the estimate of its
own time.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

import numpy as np
from filterpy.kalman import KalmanFilter

from scaloft_fi.stack.messages import Array, Fix, Imu, PoseEstimate
from scaloft_fi.stack.strapdown import (
    ATTITUDE,
    FORCE_BIAS,
    POSITION,
    RATE_BIAS,
    STATE_SIZE,
    VELOCITY,
    propagate,
    rotation,
    turn,
    yaw_of,
)


@dataclass(frozen=True)
class EstimatorConfig:
    """Tuning of the estimator.

    Attributes:
        rate_noise: white noise of the gyro [rad/s/sqrt(Hz)].
        force_noise: white noise of the accelerometer [m/s2/sqrt(Hz)].
        rate_bias_walk: drift of the gyro bias [rad/s2/sqrt(Hz)].
        force_bias_walk: drift of the accelerometer bias [m/s3/sqrt(Hz)].
        fix_sigma_m: standard deviation a fix is believed to have [m].
        fix_yaw_sigma_rad: the same of its heading [rad].
        gate_sigma: a fix farther off than this many standard deviations is refused.
        reset_after_s: refused for so long, the next fix is taken over as it is [s].
        stale_after_s: a fix older than this is refused [s].
        history_s: how long past estimates are kept for late fixes [s].
    """

    rate_noise: float
    force_noise: float
    rate_bias_walk: float
    force_bias_walk: float
    fix_sigma_m: float
    fix_yaw_sigma_rad: float
    gate_sigma: float
    reset_after_s: float
    stale_after_s: float
    history_s: float


class Estimator:
    """The running estimate.

    Attributes:
        state: (16,) nominal state, see `strapdown.propagate`.
        rate: (3,) last angular rate, bias removed [rad/s, body].
        rotation: (3, 3) attitude as a matrix, body to world.
        last_imu_s: time of the last inertial sample [s].
        last_fix_s: own time at which a fix was last accepted [s].
    """

    def __init__(self, config: EstimatorConfig, position: Array, yaw_rad: float) -> None:
        self.config = config
        self.state = np.zeros(STATE_SIZE)
        self.state[POSITION:VELOCITY] = position
        self.state[8], self.state[9] = math.sin(0.5 * yaw_rad), math.cos(0.5 * yaw_rad)
        self.rate = np.zeros(3)
        self.last_imu_s = 0.0
        self.last_fix_s = 0.0
        self._imu_stamp_s = 0.0
        self._fix_stamp_s = 0.0
        self._refused_since_s: float | None = None
        self._predicted_s = 0.0
        self.rotation = np.eye(3)
        rotation(self.state[ATTITUDE:RATE_BIAS], self.rotation)
        self._world_force = np.zeros(3)
        self._history: deque[tuple[float, Array, float]] = deque()
        self._filter = _error_filter(config)

    def inertial(self, now_s: float, imu: Imu) -> None:
        """Integrate one inertial sample."""
        dt_s = imu.stamp_s - self._imu_stamp_s
        self._imu_stamp_s = imu.stamp_s
        if not 0.0 < dt_s < 0.1:
            return
        self.last_imu_s = now_s
        np.subtract(imu.rate, self.state[RATE_BIAS:FORCE_BIAS], out=self.rate)
        propagate(self.state, imu.rate, imu.force, dt_s, self.rotation, self._world_force)

    def tick(self, now_s: float, fix: Fix | None) -> PoseEstimate:
        """Predict the error's covariance, correct by `fix` if there is one; returns the estimate."""
        self._predict(now_s)
        self._history.append((now_s, self.state[POSITION:VELOCITY].copy(), yaw_of(self.state[ATTITUDE:RATE_BIAS])))
        while now_s - self._history[0][0] > self.config.history_s:
            self._history.popleft()
        if fix is not None:
            self._correct(now_s, fix)
        attitude = self.state[ATTITUDE:RATE_BIAS].copy()
        return PoseEstimate(
            now_s,
            self.state[POSITION:VELOCITY].copy(),
            self.state[VELOCITY:ATTITUDE].copy(),
            yaw_of(attitude),
            attitude,
        )

    def _predict(self, now_s: float) -> None:
        dt_s = now_s - self._predicted_s
        self._predicted_s = now_s
        if dt_s <= 0.0:
            return
        f = self._filter.F
        f[0, 3] = f[1, 4] = f[2, 5] = dt_s
        ax, ay, az = self._world_force
        f[3, 7], f[3, 8] = az, -ay
        f[4, 6], f[4, 8] = -az, ax
        f[5, 6], f[5, 7] = ay, -ax
        f[3:6, 12:15] = -dt_s * self.rotation
        f[6:9, 9:12] = -dt_s * self.rotation
        self._world_force[:] = 0.0
        self._filter.predict()

    def _correct(self, now_s: float, fix: Fix) -> None:
        config = self.config
        if (
            not fix.stamp_s > self._fix_stamp_s
            or not now_s - config.stale_after_s <= fix.stamp_s <= now_s + 0.5 * config.stale_after_s
        ):
            return
        self._fix_stamp_s = fix.stamp_s
        position, yaw_rad = self._at(fix.stamp_s)
        error = np.empty(4)
        error[:3] = fix.position - position
        error[3] = math.remainder(fix.yaw_rad - yaw_rad, 2.0 * math.pi)
        kf = self._filter
        sigma = np.sqrt(np.diag(kf.P)[[0, 1, 2, 8]] + np.diag(kf.R))
        if not bool(np.all(np.abs(error) <= config.gate_sigma * sigma)):
            if self._refused_since_s is None:
                self._refused_since_s = now_s
            if now_s - self._refused_since_s < config.reset_after_s:
                return
            self.state[POSITION:VELOCITY] += error[:3]
            self._shift_history(error[:3], error[3])
            turn(self.state[ATTITUDE:RATE_BIAS], 0.0, 0.0, error[3], True)
        else:
            kf.update(error)
            dx = kf.x.copy()
            self.state[POSITION:ATTITUDE] += dx[0:6]
            turn(self.state[ATTITUDE:RATE_BIAS], dx[6], dx[7], dx[8], True)
            self.state[RATE_BIAS:STATE_SIZE] += dx[9:15]
            self._shift_history(dx[0:3], dx[8])
            kf.x[:] = 0.0
        self._refused_since_s = None
        self.last_fix_s = now_s

    def _at(self, stamp_s: float) -> tuple[Array, float]:
        """Estimated position and heading at `stamp_s`, interpolated; the newest (or oldest) one outside the history."""
        after = self._history[-1]
        for before in reversed(self._history):
            if before[0] <= stamp_s:
                span_s = after[0] - before[0]
                share = min(1.0, (stamp_s - before[0]) / span_s) if span_s > 0.0 else 0.0
                turned = math.remainder(after[2] - before[2], 2.0 * math.pi)
                return before[1] + share * (after[1] - before[1]), before[2] + share * turned
            after = before
        return after[1], after[2]

    def _shift_history(self, shift: Array, turned_rad: float) -> None:
        """A correction applies to the recent past as well, or late fixes would correct the same error twice."""
        self._history = deque((t, p + shift, y + turned_rad) for t, p, y in self._history)


def _error_filter(config: EstimatorConfig) -> KalmanFilter:
    kf = KalmanFilter(dim_x=15, dim_z=4)
    kf.x = np.zeros(15)
    dt_s = 0.05
    kf.P = np.diag([1e-4] * 3 + [1e-4] * 3 + [1e-4] * 3 + [1e-5] * 3 + [1e-3] * 3)
    kf.Q = np.diag(
        [1e-10] * 3
        + [config.force_noise**2 * dt_s] * 3
        + [config.rate_noise**2 * dt_s] * 3
        + [config.rate_bias_walk**2 * dt_s] * 3
        + [config.force_bias_walk**2 * dt_s] * 3
    )
    kf.H = np.zeros((4, 15))
    kf.H[0, 0] = kf.H[1, 1] = kf.H[2, 2] = kf.H[3, 8] = 1.0
    kf.R = np.diag([config.fix_sigma_m**2] * 3 + [config.fix_yaw_sigma_rad**2])
    return kf
