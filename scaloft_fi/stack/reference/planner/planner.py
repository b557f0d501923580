"""The local planner: where to fly next, of the 3DVFH* kind (PX4-Avoidance local_planner).

It deviates from its model in four ways: obstacles are dilated by the maximum instead of a sum, because a sum dilutes
thin bars; a bin holds its nearest point instead of the mean; the costs are tuned for a tunnel; a bin that holds the
goal stands for the goal's exact bearing.  Like its model it knows no hard safety margin.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from scaloft_fi.stack.fields import Array, Point
from scaloft_fi.stack.reference.messages import ObstacleMap, PoseEstimate
from scaloft_fi.stack.reference.planner.config import PlannerConfig, settings
from scaloft_fi.stack.reference.planner.search import MAX_DILATION, search


class LocalPlan(NamedTuple):
    """The direction to fly.

    direction: (3,) unit vector [world], zero at the goal itself; distance_m: to the goal [m];
    blocked: the way starts towards an obstacle nearer than the planner's half-cost distance; expanded: tree nodes.
    """

    direction: Array
    distance_m: float
    blocked: bool
    expanded: int


class Planner:
    """Plans a direction.  It remembers its last direction, because the cost of a turn is measured from there."""

    def __init__(self, config: PlannerConfig) -> None:
        self.config = config
        self._settings = settings(config)
        self._previous = np.zeros(3)

    def plan(self, obstacles: ObstacleMap, target: Point, pose: PoseEstimate) -> LocalPlan:
        """Plan from `pose` to `target` [m, world] past `obstacles`."""
        c = self.config
        goal = np.array(target, dtype=np.float64)
        offset = goal - pose.position
        distance = math.sqrt(float(offset @ offset))
        if not math.isfinite(distance):
            return LocalPlan(np.zeros(3), distance, blocked=True, expanded=0)
        if distance <= c.straight_in_m:
            direction = offset / distance if distance > 0.0 else np.zeros(3)
            return LocalPlan(direction, distance, blocked=False, expanded=0)
        radius = dilation_bins(c.dilation_bins, obstacles.inflation)
        direction, cost, expanded = search(
            np.ascontiguousarray(obstacles.points), pose.position, goal, self._previous, radius, self._settings
        )
        self._previous = direction
        return LocalPlan(direction, distance, cost >= c.obstacle_cost * c.obstacle_weight, expanded)


def dilation_bins(bins: int, inflation: float) -> int:
    """Radius of the dilation [bins] at `inflation`, at most what the histogram's width allows."""
    return int(min(max(round(bins * inflation), 0), MAX_DILATION)) if math.isfinite(inflation) else bins
