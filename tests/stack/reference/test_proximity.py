import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from scaloft_fi.stack.messages import DepthFrame
from scaloft_fi.stack.reference.declaration import REFERENCE
from scaloft_fi.stack.reference.messages import Proximity
from scaloft_fi.stack.reference.proximity import ProximityMonitor


@pytest.fixture
def monitor(proximity_config, camera):
    return ProximityMonitor(proximity_config, camera)


def image(depth_m=5.0, **spots):
    """A far wall with spots: name=(rows, columns, depth)."""
    depth = np.full((48, 64), depth_m)
    for rows, columns, near_m in spots.values():
        depth[rows, columns] = near_m
    return DepthFrame(3.0, depth)


def test_sectors_share_the_view_from_left_to_right(monitor, pose_at):
    proximity = monitor.sectors(image(), pose_at())
    assert len(proximity.sectors) == 8
    assert np.all(np.diff(proximity.bearings) == pytest.approx(-1.02974 / 8, abs=0.002))
    assert proximity.bearings == pytest.approx(-proximity.bearings[::-1])
    assert proximity.watched.all()
    assert proximity.stamp_s == 3.0


def test_ranges_are_horizontal_and_from_the_vehicles_centre(monitor, pose_at):
    proximity = monitor.sectors(image(2.0), pose_at())
    middle = proximity.sectors[3:5]
    assert middle == pytest.approx(2.1, abs=0.01)
    assert proximity.sectors[0] == pytest.approx(math.hypot(2.1, 2.0 * math.tan(proximity.bearings[0])), abs=0.15)


@pytest.mark.parametrize(
    ("depth_m", "raised"),
    [(5.0, False), (0.40, False), (0.36, False), (0.34, True), (0.30, True), (0.0, False)],
)
def test_a_wall_raises_the_flag_inside_the_trigger_distance(monitor, pose_at, depth_m, raised):
    proximity = monitor.sectors(image(depth_m), pose_at())
    assert (monitor.flag(1.0, proximity) is not None) is raised


def test_a_clearance_that_clean_flights_keep_raises_nothing(proximity_config, camera, pose_at):
    hull_half_m, clearance_m = 0.235, 0.22
    frame = image(hull_half_m + clearance_m - camera.ahead_m)
    assert (
        ProximityMonitor(proximity_config, camera).flag(
            0.0, ProximityMonitor(proximity_config, camera).sectors(frame, pose_at())
        )
        is None
    )


@pytest.mark.parametrize(("columns", "side"), [(slice(0, 8), 1), (slice(56, 64), -1)])
def test_the_bearing_is_that_of_the_nearest_triggered_sector(monitor, pose_at, columns, side):
    flag = monitor.flag(1.5, monitor.sectors(image(spot=(slice(20, 28), columns, 0.31)), pose_at()))
    assert flag.stamp_s == 1.5
    assert math.copysign(1, flag.bearing_rad) == side
    assert abs(flag.bearing_rad) > 0.4


def test_a_mirrored_image_gives_the_mirrored_bearing(monitor, pose_at):
    frame = image(spot=(slice(20, 28), slice(0, 8), 0.31))
    plain = monitor.flag(0.0, monitor.sectors(frame, pose_at()))
    mirrored = monitor.flag(0.0, monitor.sectors(frame._replace(depth=frame.depth[:, ::-1]), pose_at()))
    assert mirrored.bearing_rad == pytest.approx(-plain.bearing_rad)


def test_of_two_the_nearer_one_gives_the_bearing(monitor, pose_at):
    frame = image(left=(slice(20, 28), slice(0, 8), 0.34), right=(slice(20, 28), slice(56, 64), 0.30))
    assert monitor.flag(0.0, monitor.sectors(frame, pose_at())).bearing_rad < 0


def test_fewer_pixels_than_asked_for_are_noise(monitor, proximity_config, pose_at):
    few = image(spot=(slice(24, 25), slice(32, 32 + proximity_config.min_pixels - 1), 0.31))
    enough = image(spot=(slice(24, 25), slice(32, 32 + proximity_config.min_pixels), 0.31))
    assert monitor.flag(0.0, monitor.sectors(few, pose_at())) is None
    assert monitor.flag(0.0, monitor.sectors(enough, pose_at())) is not None


def test_what_passes_above_or_below_the_hull_is_not_near(monitor, pose_at):
    above = image(spot=(slice(0, 6), slice(0, 64), 0.5))
    assert np.all(monitor.sectors(above, pose_at()).sectors > 2.0)
    assert np.any(monitor.sectors(above, pose_at(pitch=0.4)).sectors < 1.0)


def test_a_tilted_vehicle_watches_its_flight_level(monitor, pose_at):
    level = monitor.sectors(image(1.5), pose_at()).sectors
    tilted = monitor.sectors(image(1.5), pose_at(pitch=0.2)).sectors
    assert np.isfinite(tilted).all()
    assert tilted == pytest.approx(level, abs=0.15)


def test_nothing_seen_is_infinitely_far(monitor, pose_at):
    assert np.all(np.isinf(monitor.sectors(image(0.0), pose_at()).sectors))


def test_without_word_there_is_no_flag(monitor):
    assert monitor.flag(0.0, None) is None
    assert monitor.flag(0.0, monitor.blind(0.0, touched=False)) is None


def test_a_mere_touch_is_ahead_or_towards_the_nearest_thing_seen(monitor, pose_at):
    assert monitor.flag(0.0, monitor.blind(0.0, touched=True)).bearing_rad == 0.0
    seen = monitor.sectors(image(spot=(slice(20, 28), slice(0, 8), 1.0)), pose_at())._replace(touched=True)
    assert monitor.flag(0.0, seen).bearing_rad == pytest.approx(monitor.sectors(image(), pose_at()).bearings[0])


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
    proximity = Proximity(
        0.0, np.array(sectors, dtype=float), np.array(watched, dtype=bool), np.array([0.3, 0.0, -0.3]), 0.45, touched
    )
    flag = monitor.flag(2.0, proximity)
    assert (None if flag is None else flag.bearing_rad) == bearing


@st.composite
def proximities(draw):
    sectors = draw(st.lists(st.sampled_from([0.2, 0.3, 0.5, 2.0, math.inf]), min_size=4, max_size=4))
    watched = draw(st.lists(st.booleans(), min_size=4, max_size=4))
    bearings = np.array([0.4, 0.1, -0.1, -0.4])
    trigger_m, touched = draw(st.sampled_from([0.25, 0.4])), draw(st.booleans())
    return Proximity(1.0, np.array(sectors), np.array(watched), bearings, trigger_m, touched)


@given(first=proximities(), second=proximities())
def test_samples_that_do_not_differ_raise_the_same_flag(first, second):
    flags = [ProximityMonitor.flag(None, 1.0, sample) for sample in (first, second)]
    assert REFERENCE.by_name["proximity"].differ(first, second) or flags[0] == flags[1]
