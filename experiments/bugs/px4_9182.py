"""PX4-Autopilot issue 9182, "Potential bug for EKF2" (2018); the buffer got a size of its own by pull request 22983.

Poses of an onboard SLAM reach the estimator 200 ms late, with right stamps.  The estimator keeps the past only as long
as a parameter for delays says, which is zero because the stamps are synchronised; late poses are compared with a too
recent estimate, or overwritten, and the vehicle struck the ceiling.  The fix sizes the buffers by the real delay.  In
the copy the estimator keeps no past, so that a fix, 50 ms late in this study, is compared with the newest estimate.
"""

from __future__ import annotations

from dataclasses import replace

from experiments.bugs.bug import Bug
from experiments.bugs.staged import Parts
from scaloft_fi.stack.messages import Array
from scaloft_fi.stack.reference.estimator import Estimator, EstimatorConfig


class KeepsNoPast(Estimator):
    """Keeps estimates only as long as the parameter for delays says: not at all."""

    defect = True

    def __init__(self, config: EstimatorConfig, position: Array, yaw_rad: float) -> None:
        super().__init__(replace(config, history_s=0.0) if self.defect else config, position, yaw_rad)


BUG = Bug(
    key="px4-9182",
    project="PX4/PX4-Autopilot",
    thread="https://github.com/PX4/PX4-Autopilot/issues/9182",
    fixed_by="pull request 22983",
    cell="LATE-pose",
    wrong="the estimator's buffers are too short for the delay of the poses",
    fix="their size follows the real delay",
    written="a late fix is compared with the newest estimate",
    parts=Parts(estimator=KeepsNoPast),
)
