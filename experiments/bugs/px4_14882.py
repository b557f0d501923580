"""PX4-Autopilot pull request 14882, "sensors/vehicle_angular_velocity: don't remove bias twice" (merged in 2020).

A refactoring took the estimated gyro bias off the angular velocity twice, which rate control flies with.  The fix takes
it off once.  In the copy the angular rate for rate control has the bias taken off a second time; the attitude does not.
"""

from __future__ import annotations

from experiments.bugs.bug import Bug
from experiments.bugs.staged import Parts
from scaloft_fi.stack.messages import Imu
from scaloft_fi.stack.reference.estimator import RATE_BIAS, Estimator


class BiasTwice(Estimator):
    """Takes the bias of the gyro off the rate twice."""

    defect = True

    def inertial(self, now_s: float, imu: Imu) -> None:
        """Integrate one inertial sample; the angular rate then lacks the bias twice."""
        super().inertial(now_s, imu)
        if self.defect:
            self.rate[:] = imu.rate - 2.0 * self.state[RATE_BIAS : RATE_BIAS + 3]


BUG = Bug(
    key="px4-14882",
    project="PX4/PX4-Autopilot",
    thread="https://github.com/PX4/PX4-Autopilot/pull/14882",
    fixed_by="the same pull request",
    cell="MORE-imu",
    wrong="the gyro bias is removed twice",
    fix="it is removed once",
    written="rate control gets the rate minus twice the bias",
    parts=Parts(estimator=BiasTwice, compiled=False),
)
