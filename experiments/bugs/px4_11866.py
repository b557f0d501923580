"""PX4-Autopilot pull request 11866, "Collision prevention improvements" (merged in 2019).

Two stages read one speed limit differently: collision prevention took `speed_xy` as the greatest speed, and the
position controller applied it to each axis by itself, so that the vehicle may fly sqrt(2) times the limit on a
diagonal.  The pull request made collision prevention read it as the controller does.  The study's limit is one of
the speed, so the defect of the copy is the controller's reading: each horizontal axis is limited by itself.
"""

from __future__ import annotations

import math

import numpy as np

from experiments.bugs.bug import Bug
from experiments.bugs.staged import Parts
from experiments.bugs.travel import Travel
from scaloft_fi.stack.messages import Array
from scaloft_fi.stack.reference.messages import PoseEstimate
from scaloft_fi.stack.reference.planner import LocalPlan, shape_velocity


class EachAxisLimited(Travel):
    """Limits each horizontal axis of the commanded velocity instead of the speed."""

    defect = True

    def shaped(self, plan: LocalPlan, pose: PoseEstimate) -> tuple[Array, float]:
        """Velocity and heading; no horizontal axis is faster than the limit."""
        if not self.defect:
            return super().shaped(plan, pose)
        limit_mps = self.limit.limit_mps
        greatest = self.limit._replace(limit_mps=math.sqrt(2.0) * limit_mps)
        velocity, yaw_rad = shape_velocity(plan, pose, greatest, self.stages.planner.config)
        velocity[:2] = np.clip(velocity[:2], -limit_mps, limit_mps)
        return velocity, yaw_rad


BUG = Bug(
    key="px4-11866",
    project="PX4/PX4-Autopilot",
    thread="https://github.com/PX4/PX4-Autopilot/pull/11866",
    fixed_by="the same pull request",
    cell="PARTOF-speedlimit",
    wrong="the position controller applies the speed limit to each axis, another stage to the speed",
    fix="the other stage reads the limit as the controller does",
    written="the command to flight control limits each horizontal axis by itself",
    parts=Parts(companion=EachAxisLimited),
)
