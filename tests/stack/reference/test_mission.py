import numpy as np
import pytest

from scaloft_fi.stack.reference.messages import Failsafe, PoseEstimate, Route
from scaloft_fi.stack.reference.mission import Mission, MissionConfig

CONFIG = MissionConfig(goal_radius_m=0.15, goal_axes=(1.0, 1.0, 0.0), settled_m=0.1, dwell_s=0.5)
ROUTE = Route(((0.0, 7.0, 1.65), (0.0, 0.0, 1.65)))


def pose(x, y, z=1.65, v=(0.0, 0.0, 0.0)):
    return PoseEstimate(0.0, np.array([x, y, z]), np.array(v), 0.0, np.array([0.0, 0.0, 0.0, 1.0]))


def flying():
    mission = Mission(CONFIG, (0.0, 0.0, 1.65))
    mission.plan(ROUTE)
    mission.climb(0.0, pose(0, 0))
    mission.climb(0.5, pose(0, 0))
    return mission


def test_it_leaves_only_after_the_altitude_was_held_for_the_dwell():
    mission = Mission(CONFIG, (0.0, 0.0, 1.65))
    mission.climb(0.0, pose(0, 0, 1.0))
    assert mission.phase == "takeoff"
    mission.climb(1.0, pose(0, 0, 1.6))
    mission.climb(1.4, pose(0, 0, 1.6))
    assert mission.phase == "takeoff"
    mission.climb(1.5, pose(0, 0, 1.6))
    assert mission.phase == "fly"


def test_it_hands_out_one_waypoint_at_a_time_and_lands_after_the_last():
    mission = flying()
    assert mission.target().point == ROUTE.points[0]
    mission.advance(mission.check(pose(0, 6.8)))
    assert mission.index == 0
    mission.advance(mission.check(pose(0, 6.9)))
    assert mission.target().point == ROUTE.points[1]
    mission.advance(mission.check(pose(0, 0.1)))
    assert mission.phase == "land"
    assert mission.target() is None
    assert mission.check(pose(0, 0)) is None


def test_height_does_not_count_for_the_goal():
    assert flying().check(pose(0, 7, z=0.5)).reached


def test_the_goal_check_tells_the_closing_speed():
    assert flying().check(pose(0, 5, v=(0.0, 0.4, 0.0))).speed_mps == pytest.approx(0.4)


def test_without_a_route_it_has_no_target():
    mission = Mission(CONFIG, (0.0, 0.0, 1.65))
    mission.climb(0.0, pose(0, 0))
    mission.climb(0.5, pose(0, 0))
    assert mission.phase == "fly"
    assert mission.target() is None


def test_the_battery_monitor_sends_it_home_or_down():
    mission = flying()
    mission.follow(Failsafe(1.0, "return"))
    assert mission.target().point == (0.0, 0.0, 1.65)
    mission.follow(Failsafe(2.0, "land"))
    assert mission.phase == "land"
