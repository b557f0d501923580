"""The local planner: where to fly next, of the 3DVFH* kind (PX4-Avoidance local_planner).

It deviates from its model in three ways: obstacles are dilated by the maximum instead of a sum, because a sum dilutes
thin bars; the costs are tuned for a tunnel; a bin that holds the goal stands for the goal's exact bearing.  Like its
model it knows no hard safety margin.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from scaloft_fi.stack.messages import Array, ObstacleMap, Point
from scaloft_fi.stack.planner.config import PlannerConfig
from scaloft_fi.stack.planner.search import MAX_DILATION, search


class Plan(NamedTuple):
    """Where to fly.

    direction: (3,) unit vector [world], zero at the goal itself; distance_m: to the goal [m];
    blocked: the way starts towards an obstacle nearer than the planner's half-cost distance; expanded: tree nodes.
    """

    direction: Array
    distance_m: float
    blocked: bool
    expanded: int


class Planner:
    """Plans from an obstacle map; keeps nothing between plans."""

    def __init__(self, config: PlannerConfig) -> None:
        self.config = config

    def plan(self, obstacles: ObstacleMap, target: Point, previous: Array | None, limit_mps: float) -> Plan:
        """Plan from the map's origin to `target` [m, world].

        `previous` is the direction flown last ((3,) [world], None at the start): turning away from it costs, in
        proportion to the speed `limit_mps` [m/s].
        """
        c = self.config
        goal = np.asarray(target, dtype=np.float64)
        offset = goal - obstacles.origin
        distance = math.sqrt(float(offset @ offset))
        if not distance > c.straight_in_m:
            return Plan(offset / distance if distance > 0 else np.zeros(3), distance, False, 0)
        velocity = np.zeros(3) if previous is None else previous * limit_mps
        radius = dilation_bins(c.dilation_bins, obstacles.inflation)
        direction, cost, expanded = search(obstacles.points, obstacles.origin, goal, velocity, radius, c)
        return Plan(direction, distance, cost >= c.obstacle_cost * c.obstacle_weight, expanded)


def dilation_bins(bins: int, inflation: float) -> int:
    """Radius of the dilation [bins] at `inflation`, at most the window that the histogram holds."""
    return int(min(max(round(bins * inflation), 0), MAX_DILATION)) if math.isfinite(inflation) else bins
