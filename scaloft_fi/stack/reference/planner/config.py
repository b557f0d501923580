"""Settings of the local planner."""

from __future__ import annotations

from collections import namedtuple
from dataclasses import astuple, dataclass, fields
from typing import Annotated, Any

from scaloft_fi.stack.config import Bounds, Count, NotNegative, Positive


@dataclass(frozen=True)
class PlannerConfig:
    """Settings of the local planner, with the values that a vehicle of 0.5 m needs in a tunnel 3 m wide.

    Attributes:
        obstacle_cost: scale of the obstacle term (PX4-Avoidance distance cost: 5000).
        obstacle_weight: gain of the dilated obstacle term against the other costs.
        obstacle_m: distance at which the obstacle term is half its maximum [m] (PX4-Avoidance obstacle_cost_param).
        obstacle_width_m: over which distance the term falls off [m].
        dilation_bins: radius of the obstacle dilation [bins of 6 deg] at inflation 1.
        yaw_cost: per squared degree off the goal's azimuth (PX4-Avoidance: 3).
        pitch_cost: per squared degree off the goal's elevation (PX4-Avoidance: 25).
        inertia_cost: of turning by a right angle from the direction flown before (PX4-Avoidance velocity cost: 6000
            per m/s, 4000 here, at the cruise speed of 0.5 m/s).
        elevation_limit_deg: steepest direction that is considered [deg].
        range_m: points farther than this from a tree node are ignored: their cost is below 1 % of the maximum [m].
        near_m: points nearer than this to a tree node are ignored [m] (PX4-Avoidance min_sensor_range).
        node_m: length of a tree edge [m].
        expansions: tree nodes that are expanded at most.
        children: directions followed from a node at most.
        separation_m: tree nodes are at least this far apart [m] (PX4-Avoidance: 0.2).
        heuristic_cost: per metre to the goal.
        beyond_goal_m: points farther away than the goal plus this are ignored [m].
        straight_in_m: inside this distance of the goal the vehicle flies straight to it [m].
        full_off_axis_rad: up to this angle off the camera's axis the vehicle flies at full speed [rad].
        stop_off_axis_rad: from this angle on the vehicle only turns [rad].
        slow_radius_m: inside this distance of the goal the vehicle slows down [m] (PX4-Avoidance: 1 m).
        slow_gain_per_s: speed inside `slow_radius_m`, per metre to the goal [1/s].
        creep_mps: least speed inside `slow_radius_m`, unless the speed limit is lower [m/s].
    """

    obstacle_cost: float
    obstacle_weight: float
    obstacle_m: Positive
    obstacle_width_m: Positive
    dilation_bins: Annotated[int, Bounds(least=0, most=1_000)]
    yaw_cost: float
    pitch_cost: float
    inertia_cost: float
    elevation_limit_deg: float
    range_m: NotNegative
    near_m: NotNegative
    node_m: Annotated[float, Bounds(least=0.01)]
    expansions: Count
    children: Count
    separation_m: NotNegative
    heuristic_cost: float
    beyond_goal_m: float
    straight_in_m: float
    full_off_axis_rad: float
    stop_off_axis_rad: float
    slow_radius_m: float
    slow_gain_per_s: float
    creep_mps: float


# the same fields as compiled code takes them
Settings: Any = namedtuple("Settings", [field.name for field in fields(PlannerConfig)])  # type: ignore[misc]


def settings(config: PlannerConfig) -> Any:
    """`config` for compiled code."""
    return Settings(*astuple(config))
