"""crazyflie-firmware issue 760, "Default initial position of kalman estimator is not (0, 0, 0)" (2021).

A refactoring changed the estimator's initial position by accident; testing-abstractions (ManCla) injects it as
`initialPos`.  The fix sets it to zero again.  The thread gives no number: 0.5 m in x and y is this copy's assumption.
"""

from __future__ import annotations

import numpy as np

from experiments.bugs.bug import Bug
from experiments.bugs.staged import Parts
from scaloft_fi.stack.messages import Array
from scaloft_fi.stack.reference.estimator import Estimator, EstimatorConfig

OFFSET_M = (0.5, 0.5, 0.0)
"""The wrong initial position, from home [m]."""


class BeginsElsewhere(Estimator):
    """Begins with a position that is not that of the vehicle."""

    defect = True

    def __init__(self, config: EstimatorConfig, position: Array, yaw_rad: float) -> None:
        super().__init__(config, position + np.array(OFFSET_M) if self.defect else position, yaw_rad)


BUG = Bug(
    key="crazyflie-760",
    project="bitcraze/crazyflie-firmware",
    thread="https://github.com/bitcraze/crazyflie-firmware/issues/760",
    fixed_by="the thread names what it must be, and pull request 707 as the cause",
    cell="MORE-pose",
    wrong="the estimator's initial position is not the origin",
    fix="it is the origin",
    written="the estimator begins 0.5 m off in x and y",
    parts=Parts(estimator=BeginsElsewhere),
)
