import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from scaloft_fi.stack.reference.messages import SpeedLimit
from scaloft_fi.stack.reference.planner import LocalPlan, shape_velocity

angles = st.floats(-math.pi, math.pi)
slopes = st.floats(-1.2, 1.2)
distances = st.floats(0.0, 20.0)
limits = st.floats(0.01, 2.0)


def plan_along(azimuth, slope, distance):
    level = math.cos(slope)
    direction = np.array([level * math.cos(azimuth), level * math.sin(azimuth), math.sin(slope)])
    return LocalPlan(direction, distance, blocked=False, expanded=1)


@given(angles, slopes, distances, angles, limits)
def test_the_speed_is_never_above_the_limit(planner_config, pose_at, azimuth, slope, distance, yaw, limit):
    plan = plan_along(azimuth, slope, distance)
    velocity, _ = shape_velocity(plan, pose_at(yaw=yaw), SpeedLimit(0.0, limit, "euclidean"), planner_config)
    assert np.linalg.norm(velocity) <= limit * (1 + 1e-9)


@given(angles, slopes, distances, angles, limits)
def test_per_axis_no_axis_is_above_the_limit(planner_config, pose_at, azimuth, slope, distance, yaw, limit):
    plan = plan_along(azimuth, slope, distance)
    velocity, _ = shape_velocity(plan, pose_at(yaw=yaw), SpeedLimit(0.0, limit, "per_axis"), planner_config)
    assert np.abs(velocity).max() <= limit * (1 + 1e-9)


@given(angles)
def test_per_axis_a_diagonal_is_faster_than_the_limit(planner_config, pose_at, azimuth):
    plan, pose = plan_along(azimuth, 0.0, 5.0), pose_at(yaw=azimuth)
    speeds = [
        np.linalg.norm(shape_velocity(plan, pose, SpeedLimit(0.0, 0.2, norm), planner_config)[0])
        for norm in ("euclidean", "per_axis")
    ]
    assert speeds[0] == pytest.approx(0.2)
    assert speeds[1] == pytest.approx(0.2 / max(abs(math.cos(azimuth)), abs(math.sin(azimuth))))


@given(angles, angles, distances)
def test_far_off_the_cameras_axis_it_only_turns(planner_config, pose_at, azimuth, yaw, distance):
    off_axis = abs(math.remainder(azimuth - yaw, 2 * math.pi))
    plan = plan_along(azimuth, 0.0, distance)
    velocity, heading = shape_velocity(plan, pose_at(yaw=yaw), SpeedLimit(0.0, 0.5, "euclidean"), planner_config)
    if off_axis >= planner_config.stop_off_axis_rad:
        assert not velocity.any()
    elif off_axis <= planner_config.full_off_axis_rad and distance >= planner_config.slow_radius_m:
        assert np.linalg.norm(velocity) == pytest.approx(0.5)
    assert math.remainder(heading - azimuth, 2 * math.pi) == pytest.approx(0.0, abs=1e-9)


@given(st.floats(0.2, 0.5), st.floats(0.2, 0.5))
def test_the_farther_off_axis_the_slower(planner_config, pose_at, one, other):
    def speed(off_axis):
        plan = plan_along(off_axis, 0.0, 5.0)
        limit = SpeedLimit(0.0, 0.5, "euclidean")
        return np.linalg.norm(shape_velocity(plan, pose_at(), limit, planner_config)[0])

    assert (speed(one) - speed(other)) * (one - other) <= 1e-12


@given(st.floats(0.0, 1.0))
def test_near_the_goal_it_slows_down_but_creeps_on(planner_config, pose_at, distance):
    plan = plan_along(0.0, 0.0, distance)
    velocity, _ = shape_velocity(plan, pose_at(), SpeedLimit(0.0, 5.0, "euclidean"), planner_config)
    if distance < planner_config.slow_radius_m:
        slow = max(planner_config.creep_mps, planner_config.slow_gain_per_s * distance)
        assert velocity[0] == pytest.approx(slow)


def test_a_limit_below_creeping_holds_at_the_goal_too(planner_config, pose_at):
    velocity, _ = shape_velocity(
        plan_along(0.0, 0.0, 0.1), pose_at(), SpeedLimit(0.0, 0.05, "euclidean"), planner_config
    )
    assert velocity[0] == pytest.approx(0.05)


def test_straight_up_it_keeps_its_heading_and_goes(planner_config, pose_at):
    plan = LocalPlan(np.array([0.0, 0.0, 1.0]), 3.0, blocked=False, expanded=1)
    velocity, heading = shape_velocity(plan, pose_at(yaw=1.0), SpeedLimit(0.0, 0.5, "euclidean"), planner_config)
    assert velocity.tolist() == [0.0, 0.0, 0.5]
    assert heading == 1.0


def test_without_a_direction_it_stays(planner_config, pose_at):
    plan = LocalPlan(np.zeros(3), 0.0, blocked=False, expanded=0)
    velocity, heading = shape_velocity(plan, pose_at(yaw=0.3), SpeedLimit(0.0, 0.5, "per_axis"), planner_config)
    assert not velocity.any()
    assert heading == 0.3
