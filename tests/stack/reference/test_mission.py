"""Waypoints, speed limit for people, battery monitor, exposure control, pose buffer; companions fly in tests/sim."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from scaloft_fi.stack.messages import Battery, Detections, Metering, Person
from scaloft_fi.stack.reference.messages import Failsafe, Route
from scaloft_fi.stack.reference.mission import BatteryMonitor, Mission, SpeedLimitStage
from scaloft_fi.stack.reference.stack import ExposureControl, PoseBuffer
from tests.stack.conftest import pose_at

ROUTE = Route(((0.0, 7.0, 1.65), (0.0, 0.0, 1.65)))


@pytest.fixture
def mission(config):
    return Mission(config.mission, (0.0, 0.0, 1.65))


@pytest.fixture
def flying(mission):
    mission.plan(ROUTE)
    for now_s in (0.0, 0.5):
        mission.climb(now_s, pose_at(z=1.65))
    return mission


def test_it_leaves_only_after_the_altitude_was_held_for_the_dwell_and_has_no_target_without_a_route(mission):
    phases = []
    for now_s, z in ((0.0, 1.0), (1.0, 1.6), (1.4, 1.6), (1.5, 1.6)):
        mission.climb(now_s, pose_at(z=z))
        phases.append(mission.phase)
    assert phases == ["takeoff", "takeoff", "takeoff", "fly"]
    assert mission.target() is None


def test_it_hands_out_one_waypoint_at_a_time_and_lands_after_the_last(flying):
    assert flying.target().point == ROUTE.points[0]
    flying.advance(flying.check(pose_at(y=6.8)))
    assert flying.index == 0
    flying.advance(flying.check(pose_at(y=6.9)))
    assert flying.target().point == ROUTE.points[1]
    flying.advance(flying.check(pose_at(y=0.1)))
    assert (flying.phase, flying.target(), flying.check(pose_at())) == ("land", None, None)


def test_height_does_not_count_for_the_goal_whose_check_tells_the_closing_speed(flying):
    assert flying.check(pose_at(y=7, z=0.5)).reached
    assert flying.check(pose_at(y=5, velocity=(0.0, 0.4, 0.0))).speed_mps == pytest.approx(0.4)


def test_the_battery_monitor_sends_it_home_or_down(flying):
    flying.follow(Failsafe(1.0, "return"))
    assert flying.target().point == (0.0, 0.0, 1.65)
    flying.follow(Failsafe(2.0, "land"))
    assert flying.phase == "land"


@pytest.mark.parametrize(
    ("battery", "action"),
    [
        (Battery(0.0, 0.9, 16.0, 4), None),
        (Battery(0.0, 0.15, 14.8, 4), "return"),
        (Battery(0.0, 0.05, 14.0, 4), "land"),
        (Battery(0.0, 0.9, 12.0, 4), "land"),
        (Battery(0.0, 0.9, 16.0, 6), "land"),
    ],
)
def test_the_battery_monitor_asks_for_what_the_telemetry_calls_for(config, battery, action):
    asked = BatteryMonitor(config.battery).update(0.0, battery)
    assert (asked.action if asked else None) == action


def test_a_charge_at_take_off_that_asks_for_the_return_is_lost_in_the_route_and_one_that_asks_to_land_is_not(mission):
    mission.follow(Failsafe(0.0, "return"))
    mission.plan(ROUTE)
    for now_s in (0.0, 0.5):
        mission.climb(now_s, pose_at(z=1.65))
    assert mission.target().point == ROUTE.points[0]
    mission.follow(Failsafe(0.0, "land"))
    mission.plan(ROUTE)
    assert mission.phase == "land"


def test_lost_telemetry_counts_as_an_empty_pack_and_each_action_is_asked_once(config):
    monitor = BatteryMonitor(config.battery)
    asked = [monitor.update(now_s, None) for now_s in (5.0, 5.05, 5.1)]
    assert asked == [None, Failsafe(5.05, "land"), None]


def test_cruise_is_announced_once_and_the_slow_limit_with_every_person(config):
    stage = SpeedLimitStage(config.speed_limit, 0.5, 0.2)
    assert stage.update(0.0, None)[0].limit_mps == 0.5
    assert stage.update(0.1, None) == (None, None)
    for t in (0.2, 0.4):
        limit, person = stage.update(t, Detections(0.0, (Person("person", 0.9, 0.0, 3.0),)))
        assert (limit.limit_mps, person.range_m) == (0.2, 3.0)
    for doubtful in (("chair", 0.9, 0.0, 3.0), ("person", 0.4, 0.0, 3.0), ("person", 0.9, 0.0, 5.0)):
        assert stage.update(0.6, Detections(0.0, (Person(*doubtful),))) == (None, None)


def test_the_exposure_loop_removes_the_metered_error_up_to_its_limit_where_the_gain_rises(config):
    control, dark = ExposureControl(config.exposure), ExposureControl(config.exposure)
    for _ in range(100):
        order = control.meter(Metering(0.0, 1.3 - control.meter(None).ev))
        most = dark.meter(Metering(0.0, 7.0))
    assert (order.ev, order.gain) == (pytest.approx(1.3, abs=1e-3), 1.0)
    assert (most.ev, most.gain) == (4.0, 4.0)


@given(st.floats(0.0, 2.6))
def test_a_pose_lies_between_two_ticks_or_a_little_beyond_the_newest(stamp_s):
    buffer = PoseBuffer(span_s=1.0, reach_s=0.5)
    assert buffer.at(stamp_s) is None
    for k in range(41):
        buffer.add(pose_at(x=k * 0.05, yaw=0.1 * min(k, 20), stamp_s=k * 0.05, velocity=(1.0, 0.0, 0.0)))
    buffer.add(pose_at(x=7.0, stamp_s=0.5))  # no newer than the newest, and dropped
    found, oldest_s = buffer.at(stamp_s), 1.0
    if not oldest_s - 1e-9 <= stamp_s <= 2.5:
        assert found is None
    elif oldest_s < stamp_s:
        assert found.position[0] == pytest.approx(stamp_s, abs=1e-9)
        assert found.yaw_rad == pytest.approx(2.0, abs=1e-9)
        assert np.linalg.norm(found.attitude) == pytest.approx(1.0)
