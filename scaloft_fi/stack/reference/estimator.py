"""State estimation: strapdown integration at the inertial rate, corrected by fixes in an error-state Kalman filter.

The filter is `filterpy.kalman.KalmanFilter` over the error of the state.  A late fix is compared with the estimate for
the time of its stamp.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from scaloft_fi.stack.config import NotNegative, Positive
from scaloft_fi.stack.fields import Array
from scaloft_fi.stack.messages import Fix, Imu
from scaloft_fi.stack.reference.error_state import error_filter, plausible, transition
from scaloft_fi.stack.reference.history import History
from scaloft_fi.stack.reference.messages import PoseEstimate
from scaloft_fi.stack.reference.strapdown import (
    ATTITUDE,
    NUMBERS,
    POSITION,
    RATE_BIAS,
    STAMP_S,
    USED_S,
    VELOCITY,
    correct,
    integrate,
    parts_of,
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
        state: (16,) nominal state, see `strapdown.propagate`.
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
        self._filter = error_filter(
            config.force_noise,
            config.rate_noise,
            config.rate_bias_walk,
            config.force_bias_walk,
            config.fix_sigma_m,
            config.fix_yaw_sigma_rad,
        )

    @property
    def stamp_s(self) -> float:
        """Stamp of the last inertial sample [s]."""
        return float(self._times[STAMP_S])

    @property
    def last_imu_s(self) -> float:
        """Time of the last inertial sample that was used [s]."""
        return float(self._times[USED_S])

    def inertial(self, now_s: float, imu: Imu) -> None:
        """Integrate one inertial sample."""
        integrate(now_s, imu.stamp_s, imu.rate, imu.force, self.numbers)

    def tick(self, now_s: float, fix: Fix | None) -> PoseEstimate:
        """Predict the error's covariance, correct by `fix` if there is one; returns the estimate."""
        self._predict(now_s)
        self._history.add(now_s, self.state[POSITION:VELOCITY], yaw_of(self.state[ATTITUDE:RATE_BIAS]))
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
        transition(self._filter.F, dt_s, self.world_force, self.rotation)
        self.world_force[:] = 0.0
        self._filter.predict()

    def _correct(self, now_s: float, fix: Fix) -> None:
        config = self.config
        if (
            not fix.stamp_s > self._fix_stamp_s
            or not now_s - config.stale_after_s <= fix.stamp_s <= now_s + 0.5 * config.stale_after_s
        ):
            return
        self._fix_stamp_s = fix.stamp_s
        position, yaw_rad = self._history.at(fix.stamp_s)
        error = np.empty(4)
        error[:3] = fix.position - position
        error[3] = math.remainder(fix.yaw_rad - yaw_rad, 2.0 * math.pi)
        kf = self._filter
        if not plausible(error, kf.P, kf.R, config.gate_sigma):
            if self._refused_since_s is None:
                self._refused_since_s = now_s
            if now_s - self._refused_since_s < config.reset_after_s:
                return
            self.state[POSITION:VELOCITY] += error[:3]
            self._history.shift(error[:3], error[3])
            turn(self.state[ATTITUDE:RATE_BIAS], 0.0, 0.0, error[3], True)
        else:
            kf.update(error)
            correct(self.state, kf.x)
            self._history.shift(kf.x[:3], kf.x[8])
            kf.x[:] = 0.0
        self._refused_since_s = None
        self.last_fix_s = now_s
