"""PX4-Autopilot pull request 5062, "Fix gyro calibration" (merged in 2016; issues 5029 and 5060).

The calibration scale of the gyro was set to 0 instead of 1, so that every rate reads zero.  The fix sets it to 1.  In
the copy rates are multiplied by that scale before they are integrated.
"""

from __future__ import annotations

from experiments.bugs.bug import Bug
from experiments.bugs.staged import Parts
from scaloft_fi.stack.messages import Imu
from scaloft_fi.stack.reference.estimator import Estimator

SCALE = 0.0
"""The calibration scale, which should be 1."""


class ScaledByZero(Estimator):
    """Multiplies the gyro's rates by a scale of zero."""

    defect = True

    def inertial(self, now_s: float, imu: Imu) -> None:
        """Integrate one inertial sample, whose rates are scaled."""
        super().inertial(now_s, imu._replace(rate=SCALE * imu.rate) if self.defect else imu)


BUG = Bug(
    key="px4-5062",
    project="PX4/PX4-Autopilot",
    thread="https://github.com/PX4/PX4-Autopilot/pull/5062",
    fixed_by="the same pull request",
    cell="NO-imu",
    wrong="the gyro's calibration scale is 0 instead of 1",
    fix="it is 1",
    written="every rate is multiplied by zero",
    parts=Parts(estimator=ScaledByZero, compiled=False),
)
