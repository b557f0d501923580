"""PX4-Autopilot pull request 20308, "ObstacleAvoidance: fix condition for target wp skipping" (2022).

A waypoint counts as passed when the vehicle, projected on the leg, is farther from the leg's start than the leg is
long.  Only lengths are compared, so a vehicle *before* the start passes as well: with an acceptance radius longer than
the next leg all waypoints in a line are skipped.  The fix asks for the same direction too.  The reference mission has
no such rule; the copy has the part of it that the fix took out.  Its legs are longer than 3 m, its radius is 0.15 m.
"""

from __future__ import annotations

import math

from experiments.bugs.bug import Bug
from experiments.bugs.staged import Parts
from scaloft_fi.stack.reference.messages import GoalCheck, PoseEstimate
from scaloft_fi.stack.reference.mission import Mission

EXTRA_M = 0.5
"""How far beyond the waypoint's distance the acceptance radius is raised [m], as in PX4."""


class SkipsFromBehind(Mission):
    """Raises the acceptance radius where the vehicle is farther behind a leg's start than the leg is long."""

    defect = True

    def check(self, pose: PoseEstimate) -> GoalCheck | None:
        """Input of the goal test; its radius holds the vehicle where the rule takes the waypoint for passed."""
        check = super().check(pose)
        if check is None or not self.defect:
            return check
        start = self._route[self.index - 1] if self.index else self.home
        leg_x, leg_y = (self._route[self.index][k] - start[k] for k in range(2))
        along_m2 = leg_x * (float(pose.position[0]) - start[0]) + leg_y * (float(pose.position[1]) - start[1])
        if along_m2 < 0.0 and -along_m2 > leg_x**2 + leg_y**2:
            return check._replace(radius_m=math.hypot(*check.offset[:2]) + EXTRA_M)
        return check


BUG = Bug(
    key="px4-20308",
    project="PX4/PX4-Autopilot",
    thread="https://github.com/PX4/PX4-Autopilot/pull/20308",
    fixed_by="the same pull request",
    cell="BEFORE-goal",
    wrong="a waypoint is skipped when the vehicle is farther behind the leg's start than the leg is long",
    fix="the vehicle must be ahead of the leg's start",
    written="the acceptance radius grows there by the distance to the waypoint",
    parts=Parts(mission=SkipsFromBehind),
)
