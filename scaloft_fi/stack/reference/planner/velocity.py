"""From a plan to a velocity: turn before moving, slow down at the goal, keep the speed limit."""

from __future__ import annotations

import math

import numpy as np

from scaloft_fi.stack.fields import Array
from scaloft_fi.stack.reference.messages import PoseEstimate, SpeedLimit
from scaloft_fi.stack.reference.planner.config import PlannerConfig
from scaloft_fi.stack.reference.planner.planner import LocalPlan

_STEEP = 0.2  # a direction with less than this share in the plane has no bearing


def permitted_mps(direction: Array, limit: SpeedLimit) -> float:
    """Greatest speed along the unit vector `direction` (3,) within `limit` [m/s]."""
    if limit.norm == "per_axis":
        return limit.limit_mps / float(np.max(np.abs(direction)))
    return limit.limit_mps


def shape_velocity(
    plan: LocalPlan, pose: PoseEstimate, limit: SpeedLimit, config: PlannerConfig
) -> tuple[Array, float]:
    """Velocity (3,) [m/s, world] and heading to take [rad, world] to follow `plan`.

    The speed falls to zero with the angle between the plan's bearing and the camera's axis, and near the goal.  The
    heading is the plan's bearing: flight control limits how fast the vehicle turns.
    """
    x, y, z = plan.direction.tolist()
    flat, length = math.hypot(x, y), math.sqrt(x * x + y * y + z * z)
    if not length > 0.0:
        return np.zeros(3), pose.yaw_rad
    share, heading = 1.0, pose.yaw_rad
    if flat > _STEEP * length:
        heading = math.atan2(y, x)
        off_axis = abs(math.remainder(heading - pose.yaw_rad, 2.0 * math.pi))
        fade = config.stop_off_axis_rad - config.full_off_axis_rad
        share = min(max((config.stop_off_axis_rad - off_axis) / fade, 0.0), 1.0)
    speed = permitted_mps(plan.direction, limit)
    if plan.distance_m < config.slow_radius_m:
        speed = min(speed, max(config.creep_mps, config.slow_gain_per_s * plan.distance_m))
    return plan.direction * (share * speed), heading
