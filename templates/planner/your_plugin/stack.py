"""A stack named `your_plugin`: the reference stack with this planner, which knows only the straight line."""

from dataclasses import replace

import numpy as np

from scaloft_fi.api import REFERENCE, LocalPlan, Planner, ReferenceStack, declare_stack

HALF_WIDTH_M, STOP_M = 0.4, 1.2


class OwnPlanner(Planner):
    """Flies straight to the waypoint, and stops where an obstacle is near on that line."""

    def plan(self, obstacles, target, pose):
        """The way from here: a direction of length 1, or zeros to wait, and the distance that is left [m]."""
        way = np.array(target) - pose.position
        distance_m = float(np.linalg.norm(way))
        direction = way / distance_m if distance_m > 0.0 else np.zeros(3)
        seen = obstacles.points.reshape(-1, 3) - pose.position
        along_m = seen @ direction
        aside_m = np.linalg.norm(seen - np.outer(along_m, direction), axis=1)
        blocked = bool(np.any((along_m > 0.0) & (along_m < min(STOP_M, distance_m)) & (aside_m < HALF_WIDTH_M)))
        return LocalPlan(np.zeros(3) if blocked else direction, distance_m, blocked, 0)


class OwnStack(ReferenceStack):
    """The reference stack with that planner."""

    planner_kind = OwnPlanner


declare_stack(replace(REFERENCE, name="your_plugin", make=OwnStack))
