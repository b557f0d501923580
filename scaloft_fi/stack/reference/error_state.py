"""The Kalman filter over the estimator's error, its transition matrix and its gate.

The error is of (position, velocity, attitude, rate bias, force bias); attitude errors are small rotation vectors in the
world frame.  A fix measures position x, y, z and heading.
"""

from __future__ import annotations

import math

import numpy as np

from scaloft_fi.stack.fields import Array
from scaloft_fi.stack.kernel import jit
from scaloft_fi.stack.rates import TICK_S
from scaloft_fi.stack.reference.covariance import MEASURED, SIZE, carried, corrected, innovation
from scaloft_fi.stack.reference.light_filterpy import KalmanFilter, dgesv

_IDENTITY = np.eye(len(MEASURED))


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
        self.S = innovation(self.P, self.R)
        *_, inverse, singular = dgesv(self.S, _IDENTITY)
        if singular:
            raise np.linalg.LinAlgError("Singular matrix")
        self.K, self.x, self.P = corrected(self.P, self.R, inverse, z)


def error_filter(
    force_noise: float,
    rate_noise: float,
    rate_bias_walk: float,
    force_bias_walk: float,
    fix_sigma_m: float,
    fix_yaw_sigma_rad: float,
) -> ErrorFilter:
    """The filter before take-off; the noises are those of `EstimatorConfig`."""
    kf = ErrorFilter(dim_x=SIZE, dim_z=len(MEASURED))
    kf.x = np.zeros(SIZE)
    kf.P = np.diag([1e-4] * 3 + [1e-4] * 3 + [1e-4] * 3 + [1e-5] * 3 + [1e-3] * 3)
    kf.Q = np.diag(
        [1e-10] * 3
        + [force_noise**2 * TICK_S] * 3
        + [rate_noise**2 * TICK_S] * 3
        + [rate_bias_walk**2 * TICK_S] * 3
        + [force_bias_walk**2 * TICK_S] * 3
    )
    kf.H = np.eye(SIZE)[list(MEASURED)]
    kf.R = np.diag([fix_sigma_m**2] * 3 + [fix_yaw_sigma_rad**2])
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
