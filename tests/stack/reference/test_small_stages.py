"""Speed limit, exposure, battery monitor, recoil, pose buffer, settings."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from scaloft_fi.stack.messages import Battery, Detections, Metering, Person
from scaloft_fi.stack.reference.companion import ExposureConfig, ExposureControl, PoseBuffer
from scaloft_fi.stack.reference.messages import CollisionFlag, PoseEstimate
from scaloft_fi.stack.reference.mission import BatteryConfig, BatteryMonitor, SpeedLimitConfig, SpeedLimitStage
from scaloft_fi.stack.reference.proximity import Recoil, RecoilConfig


def pose(stamp_s=0.0, x=0.0, y=0.0, yaw_rad=0.0, v=(0.0, 0.0, 0.0)):
    attitude = np.array([0.0, 0.0, math.sin(yaw_rad / 2), math.cos(yaw_rad / 2)])
    return PoseEstimate(stamp_s, np.array([x, y, 1.65]), np.array(v), yaw_rad, attitude)


LIMITS = SpeedLimitConfig(label="person", min_score=0.5, max_range_m=4.5)


def boxes(*persons):
    return Detections(0.0, persons)


def test_cruise_is_announced_once_and_the_slow_limit_with_every_person():
    stage = SpeedLimitStage(LIMITS, 0.5, 0.2)
    assert stage.update(0.0, None)[0].limit_mps == 0.5
    assert stage.update(0.1, None) == (None, None)
    for t in (0.2, 0.4):
        limit, person = stage.update(t, boxes(Person("person", 0.9, 0.0, 3.0)))
        assert limit.limit_mps == 0.2
        assert person.range_m == 3.0


@pytest.mark.parametrize(
    "person", [Person("chair", 0.9, 0.0, 3.0), Person("person", 0.4, 0.0, 3.0), Person("person", 0.9, 0.0, 5.0)]
)
def test_other_classes_doubtful_boxes_and_far_persons_do_not_count(person):
    stage = SpeedLimitStage(LIMITS, 0.5, 0.2)
    stage.update(0.0, None)
    assert stage.update(0.1, boxes(person)) == (None, None)


def test_the_exposure_loop_removes_the_metered_error():
    control = ExposureControl(ExposureConfig(gain=0.15, limit_ev=4.0, gain_from_ev=2.0))
    light_ev = 1.3
    for _ in range(100):
        order = control.meter(Metering(0.0, light_ev - control.meter(None).ev))
    assert order.ev == pytest.approx(light_ev, abs=1e-3)
    assert order.gain == 1.0


def test_in_the_dark_exposure_stops_at_its_limit_and_gain_rises():
    control = ExposureControl(ExposureConfig(gain=0.15, limit_ev=4.0, gain_from_ev=2.0))
    for _ in range(100):
        order = control.meter(Metering(0.0, 7.0))
    assert order.ev == 4.0
    assert order.gain == 4.0


def battery_monitor():
    return BatteryMonitor(BatteryConfig(low_charge=0.15, critical_charge=0.07, empty_cell_v=3.3, lost_s=5.0))


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
def test_the_battery_monitor_asks_for_what_the_telemetry_calls_for(battery, action):
    asked = battery_monitor().update(0.0, battery)
    assert (asked.action if asked else None) == action


def test_lost_telemetry_counts_as_an_empty_pack_and_each_action_is_asked_once():
    monitor = battery_monitor()
    assert monitor.update(5.0, None) is None
    assert monitor.update(5.05, None).action == "land"
    assert monitor.update(5.1, None) is None


RECOIL = RecoilConfig(speed_mps=0.5, distance_m=0.8, timeout_s=3.0, pause_s=0.5, refractory_s=2.0, accel_mps2=4.0)


def test_the_recoil_goes_away_from_the_flag_then_pauses_then_ends():
    recoil = Recoil(RECOIL)
    recoil.trigger(0.0, CollisionFlag(0.0, 0.0), pose(yaw_rad=math.pi / 2))
    velocity, yaw_rad = recoil.order(0.0, pose(), 0.5)
    assert velocity == pytest.approx([0.0, -0.5, 0.0])
    assert yaw_rad == math.pi / 2
    velocity, _ = recoil.order(1.6, pose(y=-0.8), 0.5)
    assert velocity == pytest.approx([0.0, 0.0, 0.0])
    assert recoil.order(2.2, pose(y=-0.8), 0.5) is None


def test_the_recoil_obeys_the_speed_limit_and_its_time_out():
    recoil = Recoil(RECOIL)
    recoil.trigger(0.0, CollisionFlag(0.0, math.pi / 2), pose())
    assert recoil.order(0.0, pose(), 0.2)[0] == pytest.approx([0.0, -0.2, 0.0])
    assert recoil.order(3.1, pose(), 0.2)[0] == pytest.approx([0.0, 0.0, 0.0])
    assert recoil.order(3.6, pose(), 0.2) is None


def test_flags_during_and_shortly_after_a_recoil_are_ignored():
    recoil = Recoil(RECOIL)
    recoil.trigger(0.0, CollisionFlag(0.0, 0.0), pose())
    recoil.trigger(4.0, CollisionFlag(4.0, 0.0), pose())
    assert recoil.order(4.0, pose(), 0.5) is None
    recoil.trigger(5.6, CollisionFlag(5.6, 0.0), pose())
    assert recoil.order(5.6, pose(), 0.5) is not None


@given(st.floats(0.0, 0.95))
def test_a_pose_between_two_ticks_lies_on_the_line_between_them(stamp_s):
    buffer = PoseBuffer(span_s=1.0, reach_s=0.5)
    for k in range(20):
        buffer.add(pose(k * 0.05, x=k * 0.05, yaw_rad=0.1 * k))
    found = buffer.at(stamp_s)
    assert found.position[0] == pytest.approx(stamp_s, abs=1e-9)
    assert found.yaw_rad == pytest.approx(2.0 * stamp_s, abs=1e-9)


def test_the_pose_buffer_extrapolates_a_little_and_refuses_the_rest():
    buffer = PoseBuffer(span_s=1.0, reach_s=0.5)
    assert buffer.at(0.0) is None
    for k in range(41):
        buffer.add(pose(k * 0.05, x=k * 0.05, v=(1.0, 0.0, 0.0)))
    assert buffer.at(2.3).position[0] == pytest.approx(2.3)
    assert buffer.at(2.6) is None
    assert buffer.at(0.5) is None


def test_the_pose_buffer_drops_what_is_not_newer():
    buffer = PoseBuffer(span_s=1.0, reach_s=0.5)
    buffer.add(pose(1.0, x=1.0))
    buffer.add(pose(0.5, x=7.0))
    assert buffer.newest.position[0] == 1.0
