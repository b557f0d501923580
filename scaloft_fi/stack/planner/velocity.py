"""From a direction to a velocity: turn first, then go; slow down at the goal; keep the speed limit."""

from __future__ import annotations

import math

import numpy as np

from scaloft_fi.stack.messages import Array, SpeedLimit
from scaloft_fi.stack.planner.config import VelocityConfig

_STEEP = 0.2  # a direction with less than this share in the plane has no heading


def wrap(angle_rad: float) -> float:
    """`angle_rad` in -pi..pi."""
    return math.remainder(angle_rad, 2.0 * math.pi)


def permitted_mps(direction: Array, limit: SpeedLimit) -> float:
    """Greatest speed along the unit vector `direction` (3,) within `limit` [m/s]."""
    if limit.norm == "per_axis":
        return limit.limit_mps / float(np.max(np.abs(direction)))
    return limit.limit_mps


def shape_velocity(
    direction: Array,
    distance_m: float,
    yaw_rad: float,
    yaw_setpoint_rad: float,
    limit: SpeedLimit,
    period_s: float,
    config: VelocityConfig,
) -> tuple[Array, float]:
    """Velocity (3,) [m/s, world] and yaw setpoint [rad] for flying along `direction` ((3,) unit vector or zero).

    `yaw_rad` is where the camera looks, `yaw_setpoint_rad` the last setpoint, `period_s` the time since then.
    The speed falls to zero with the angle between the direction's bearing and the camera's axis, and near the goal.
    """
    x, y, z = direction.tolist()
    flat, length = math.hypot(x, y), math.sqrt(x * x + y * y + z * z)
    if not length > 0.0:
        return np.zeros(3), yaw_setpoint_rad
    share = 1.0
    if flat > _STEEP * length:
        bearing = math.atan2(y, x)
        off_axis = abs(wrap(bearing - yaw_rad))
        fade = config.stop_off_axis_rad - config.full_off_axis_rad
        share = min(max((config.stop_off_axis_rad - off_axis) / fade, 0.0), 1.0)
        step = config.yaw_slew_radps * period_s
        yaw_setpoint_rad = wrap(yaw_setpoint_rad + min(max(wrap(bearing - yaw_setpoint_rad), -step), step))
    speed = permitted_mps(direction, limit)
    if distance_m < config.slow_radius_m:
        speed = min(speed, max(config.creep_mps, config.slow_gain_per_s * distance_m))
    return direction * (share * speed), yaw_setpoint_rad
