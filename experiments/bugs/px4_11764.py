"""PX4-Autopilot issue 11764, "Mission speed change not working" (2019), fixed by pull request 11836.

A command to change the speed during a mission was ignored: the vehicle always travelled at the cruise speed, which
limited it further down.  The fix applies the commanded speed, and tests it.  In the copy the reduction beside a person
arrives, and the way along a plan is flown at the cruise speed all the same.
"""

from __future__ import annotations

from experiments.bugs.bug import Bug
from experiments.bugs.staged import Parts
from experiments.bugs.travel import Travel
from scaloft_fi.stack.messages import Array
from scaloft_fi.stack.reference.messages import PoseEstimate
from scaloft_fi.stack.reference.planner import LocalPlan, shape_velocity


class CruisesAlways(Travel):
    """Travels at the cruise speed, whatever was commanded."""

    defect = True

    def shaped(self, plan: LocalPlan, pose: PoseEstimate) -> tuple[Array, float]:
        """Velocity and heading at the cruise speed."""
        if not self.defect:
            return super().shaped(plan, pose)
        cruise = self.limit._replace(limit_mps=self.stages.speed_limit.cruise_mps)
        return shape_velocity(plan, pose, cruise, self.stages.planner.config)


BUG = Bug(
    key="px4-11764",
    project="PX4/PX4-Autopilot",
    thread="https://github.com/PX4/PX4-Autopilot/issues/11764",
    fixed_by="pull request 11836",
    cell="NO-speedlimit",
    wrong="a commanded change of speed has no effect; the vehicle always travels at the cruise speed",
    fix="the commanded speed is applied",
    written="the way along a plan is flown at the cruise speed, whatever the limit in force",
    parts=Parts(companion=CruisesAlways),
)
