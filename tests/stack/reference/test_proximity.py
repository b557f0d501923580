"""The collision flag, and the retreat."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from scaloft_fi.sim.build import physics_server
from scaloft_fi.sim.flight import FlightLoop
from scaloft_fi.stack.declaration import PlainWire
from scaloft_fi.stack.messages import Bumper, SensorFrames
from scaloft_fi.stack.reference.declaration import REFERENCE
from scaloft_fi.stack.reference.messages import CollisionFlag, Proximity
from scaloft_fi.stack.reference.proximity import ProximityMonitor, Recoil
from scaloft_fi.study import Study
from tests.stack.conftest import pose_at, wall_at

LEFT, RIGHT = slice(0, 8), slice(56, 64)


@pytest.fixture
def monitor(config, camera):
    return ProximityMonitor(config.proximity, camera)


def spotted(*spots, rows=slice(20, 28)):
    """A far wall with spots: columns and depth."""
    frame = wall_at(5.0, 3.0)
    for columns, near_m in spots:
        frame.depth[rows, columns] = near_m
    return frame


def flagged(monitor, frame):
    return monitor.flag(1.5, monitor.sectors(frame, pose_at()))


def test_sectors_share_the_view_from_left_to_right_with_level_ranges_from_the_vehicles_centre(monitor):
    proximity = monitor.sectors(wall_at(2.0, 3.0), pose_at())
    assert len(proximity.sectors) == 8
    assert np.all(np.diff(proximity.bearings) == pytest.approx(-1.02974 / 8, abs=0.002))
    assert proximity.bearings == pytest.approx(-proximity.bearings[::-1])
    assert proximity.watched.all()
    assert proximity.stamp_s == 3.0
    assert proximity.sectors[3:5] == pytest.approx(2.1, abs=0.01)
    assert proximity.sectors[0] == pytest.approx(math.hypot(2.1, 2.0 * math.tan(proximity.bearings[0])), abs=0.15)
    assert np.all(np.isinf(monitor.sectors(wall_at(0.0), pose_at()).sectors))


@pytest.mark.flight
@pytest.mark.parametrize("hull", [False, True])
def test_a_touch_raises_the_flag_beside_a_picture_of_a_free_way(hull):
    study = Study.open(None)
    with physics_server() as client:
        scenario = study.scenario(study.grid.situations[0])
        flight = FlightLoop(client, study.sim, scenario, 0, PlainWire())
        companion, flags = flight.stack.companion, []

        def touched(now_s, frames):
            bumper = Bumper(now_s, hull=hull, gear=False)
            companion(now_s, SensorFrames({**frames.by_sensor, "bumper": bumper}))
            flags.append(bool(flight.stack.beliefs(now_s)[flag]))

        flag = REFERENCE.belief_names.index("collision_flag")
        flight.stack.companion = touched
        for _ in range(120):
            flight.tick()
            flight.advance()
    assert any(flags) is hull


@pytest.mark.parametrize(
    ("depth_m", "raised"),
    [(5.0, False), (0.40, False), (0.36, False), (0.355, False), (0.34, True), (0.30, True), (0.0, False)],
)
def test_a_wall_raises_the_flag_inside_the_trigger_distance(monitor, depth_m, raised):
    assert (flagged(monitor, wall_at(depth_m)) is not None) is raised


def test_the_bearing_is_that_of_the_nearest_triggered_sector_and_mirrored_with_the_image(monitor):
    frame = spotted((LEFT, 0.34), (RIGHT, 0.30))
    flag, mirrored = flagged(monitor, frame), flagged(monitor, frame._replace(depth=frame.depth[:, ::-1]))
    assert (flag.stamp_s, mirrored.bearing_rad) == (1.5, pytest.approx(-flag.bearing_rad))
    assert mirrored.bearing_rad > 0.4


def test_fewer_pixels_than_asked_for_are_noise(monitor, config):
    few, enough = (
        spotted((slice(32, 32 + config.proximity.min_pixels + more), 0.31), rows=slice(24, 25)) for more in (-1, 0)
    )
    assert flagged(monitor, few) is None
    assert flagged(monitor, enough) is not None


def test_what_passes_above_the_hull_is_not_near_and_a_tilted_vehicle_watches_its_flight_level(monitor):
    above = spotted((slice(0, 64), 0.5), rows=slice(0, 6))
    assert np.all(monitor.sectors(above, pose_at()).sectors > 2.0)
    assert np.any(monitor.sectors(above, pose_at(pitch=0.4)).sectors < 1.0)
    level, tilted = (monitor.sectors(wall_at(1.5), pose_at(pitch=pitch)).sectors for pitch in (0.0, 0.2))
    assert tilted == pytest.approx(level, abs=0.15)


def test_without_word_there_is_no_flag_and_a_mere_touch_is_ahead(monitor):
    assert monitor.flag(0.0, None) is None
    assert monitor.flag(0.0, monitor.blind(0.0, touched=False)) is None
    assert monitor.flag(0.0, monitor.blind(0.0, touched=True)).bearing_rad == 0.0


@pytest.mark.parametrize(
    ("sectors", "watched", "touched", "bearing"),
    [
        ([9, 9, 9], [1, 1, 1], False, None),
        ([9, 0.4, 9], [1, 1, 1], False, 0.0),
        ([9, 0.4, 9], [1, 0, 1], False, None),
        ([0.44, 0.4, 9], [1, 0, 1], False, 0.3),
        ([0.45, 9, 9], [1, 1, 1], False, None),
        ([9, 9, 2], [1, 1, 1], True, -0.3),
        ([9, 9, 2], [1, 1, 0], True, 0.3),
        ([math.inf] * 3, [1, 1, 1], True, 0.0),
        ([0.3, 9, 0.2], [0, 0, 0], True, 0.0),
    ],
)
def test_the_flag_by_table(monitor, sectors, watched, touched, bearing):
    bearings = np.array([0.3, 0.0, -0.3])
    flag = monitor.flag(2.0, Proximity(0.0, np.array(sectors), np.array(watched, bool), bearings, 0.45, touched))
    assert (None if flag is None else flag.bearing_rad) == bearing


@st.composite
def proximities(draw):
    sectors = draw(st.lists(st.sampled_from([0.2, 0.3, 0.5, 2.0, math.inf]), min_size=4, max_size=4))
    watched, bearings = draw(st.lists(st.booleans(), min_size=4, max_size=4)), np.array([0.4, 0.1, -0.1, -0.4])
    trigger_m, touched = draw(st.sampled_from([0.25, 0.4])), draw(st.booleans())
    return Proximity(1.0, np.array(sectors), np.array(watched), bearings, trigger_m, touched)


@given(first=proximities(), second=proximities())
def test_samples_that_do_not_differ_raise_the_same_flag(first, second):
    flags = [ProximityMonitor.flag(None, 1.0, sample) for sample in (first, second)]
    assert REFERENCE.by_name["proximity"].differ(first, second) or flags[0] == flags[1]


@pytest.fixture
def recoil(config):
    return Recoil(config.recoil)


def test_the_recoil_goes_away_from_the_flag_then_pauses_then_ends(recoil):
    recoil.trigger(0.0, CollisionFlag(0.0, 0.0), pose_at(yaw=math.pi / 2))
    velocity, yaw_rad = recoil.order(0.0, pose_at(), 0.5)
    assert velocity == pytest.approx([0.0, -0.5, 0.0])
    assert yaw_rad == math.pi / 2
    assert recoil.order(1.6, pose_at(y=-0.8), 0.5)[0] == pytest.approx([0.0, 0.0, 0.0])
    assert recoil.order(2.2, pose_at(y=-0.8), 0.5) is None


def test_the_recoil_obeys_the_speed_limit_and_its_time_out_and_flags_shortly_after_it_are_ignored(recoil):
    recoil.trigger(0.0, CollisionFlag(0.0, math.pi / 2), pose_at())
    assert recoil.order(0.0, pose_at(), 0.2)[0] == pytest.approx([0.0, -0.2, 0.0])
    assert recoil.order(3.1, pose_at(), 0.2)[0] == pytest.approx([0.0, 0.0, 0.0])
    for t_s, begins in ((4.0, False), (5.6, True)):
        recoil.trigger(t_s, CollisionFlag(t_s, 0.0), pose_at())
        assert (recoil.order(t_s, pose_at(), 0.2) is not None) is begins
