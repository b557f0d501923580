from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from scaloft_fi.sim.mesh import View
from scaloft_fi.sim.sensors.camera import Detector
from scaloft_fi.sim.sensors.sensor import FlightSetting
from scaloft_fi.stack.messages import Exposure

LIGHT = 0.9
GOOD = Exposure(math.log2(0.5 / 0.9), 1.0, 0.0)
lights = st.floats(1e-6, 1)
EMPTY = View(np.full((48, 64), 6.0), np.zeros((48, 64), np.int16))


def picture(pixels=100, column=10, z=3.0):
    depth, segments = np.full((48, 64), 6.0), np.zeros((48, 64), np.int16)
    rows = np.arange(pixels) % 48
    columns = column + np.arange(pixels) // 48
    depth[rows, columns], segments[rows, columns] = z, 4
    return View(depth, segments)


@pytest.fixture
def detector(config):
    def make(persons=((4, "person"),), seed=0, **changes):
        names = tuple(dict(persons).get(number, f"body {number}") for number in range(6))
        scene, labels = replace(config.world.scene, names=names), {name: "person" for _, name in persons}
        setting = FlightSetting(config.sensors.by_name, scene, labels, ("S", seed))
        return Detector(replace(config.sensors.detector, **changes), setting)

    return make


def share_found(it, view=None, exposure=GOOD, pictures=400, light=LIGHT, haze_per_m=0.0):
    view = view or picture()
    return np.mean([it.find(k, view, exposure, 0.0, light, haze_per_m) is not None for k in range(pictures)])


def test_a_bright_near_person_is_found_as_often_as_the_formula_says_and_nobody_where_nobody_is(config, detector):
    expected = config.sensors.detector.probability(100, 0.9, 1.0, 0.0)
    assert expected > 0.75
    assert share_found(detector()) == pytest.approx(expected, abs=0.06)
    assert share_found(detector(), EMPTY) == share_found(detector(persons=())) == 0


@given(lights, st.floats(1, 500), st.floats(1, 16), st.floats(-6, 6))
def test_probability_is_a_probability_and_falls_with_every_trouble(config, light, pixels, gain, error_ev):
    chance = config.sensors.detector.probability
    p = chance(pixels, light, gain, error_ev)
    assert 0 <= p <= config.sensors.detector.best
    assert chance(pixels, light, 2 * gain, error_ev) <= p
    assert chance(0.5 * pixels, light, gain, error_ev) <= p
    assert chance(pixels, 0.5 * light, gain, error_ev) <= p
    assert chance(pixels, light, gain, 1.5 * error_ev) <= p


@pytest.mark.parametrize(
    ("pixels", "exposure", "light", "most"),
    [
        (100, Exposure(4.0, 4.0, 0.0), 0.003, 0.02),
        (100, Exposure(4.0, 4.0, 0.0), 0.0, 0.0),
        (100, Exposure(GOOD.ev + 4, 1.0, 0.0), LIGHT, 0.1),
        (100, Exposure(GOOD.ev, 16.0, 0.0), LIGHT, 0.4),
        (60, Exposure(GOOD.ev, 1.0, 0.6), LIGHT, 0.6),
        (100, Exposure(math.nan, 1.0, 0.0), LIGHT, 0.0),  # an order that is no number
    ],
)
def test_darkness_and_a_bad_exposure_hide_a_person(detector, pixels, exposure, light, most):
    assert share_found(detector(), picture(pixels), exposure, light=light) <= most


def test_bearing_and_range_are_those_of_the_visible_part(config, detector):
    it = detector(bearing_sigma_deg=0.0, range_sigma=0.0, best=1.0, noise_light=0.0)
    found = it.find(0, picture(96, column=10), GOOD, 0.1, LIGHT).persons[0]
    left = config.sensors.depth.camera.rays[0, 10:12, 1]
    assert found.bearing_rad == pytest.approx(math.atan(left.mean()))
    assert found.bearing_rad > 0
    assert found.range_m == pytest.approx(3 * np.mean(np.hypot(1, left)))
    assert found.label == "person"


def test_bearing_and_range_are_noisy_without_offset(config, detector):
    it, own = detector(best=1.0, noise_light=0.0), config.sensors.detector
    found = [it.find(k, picture(), GOOD, 0.0, LIGHT).persons[0] for k in range(400)]
    ranges, bearings = np.array([p.range_m for p in found]), np.array([p.bearing_rad for p in found])
    assert ranges.std() / ranges.mean() == pytest.approx(own.range_sigma, rel=0.15)
    assert bearings.std() == pytest.approx(math.radians(own.bearing_sigma_deg), rel=0.15)


def test_the_score_rises_with_the_probability(config):
    own = config.sensors.detector
    scores = [own.score(chance, noise) for chance, noise in ((0, -99), (0.0, 0), (0.4, 0), (0.8, 0), (1, 99))]
    assert scores == sorted(set(scores))
    assert 0.05 <= scores[0] <= scores[-1] <= 0.999
    assert own.score(own.probability(100, 0.9, 1, 0), 0) > 0.7


def test_false_positives_come_at_their_rate(detector):
    assert share_found(detector(false_positives=0.2), EMPTY) == pytest.approx(0.2, abs=0.06)


def test_detection_depends_on_the_picture_number_only(detector):
    first, second = detector(), detector()
    share_found(first, pictures=30)
    assert first.find(40, picture(), GOOD, 0.0, LIGHT) == second.find(40, picture(), GOOD, 0.0, LIGHT)


def test_each_person_is_found_by_itself(detector):
    view = picture()
    view.segments[:, 40:44] = 5
    it = detector(persons=((4, "miner"), (5, "visitor")), best=1.0, noise_light=0.0)
    left, right = (person.bearing_rad for person in it.find(0, view, GOOD, 0.0, LIGHT).persons)
    assert left > 0 > right


def test_dust_hides_a_far_person_and_not_a_near_one(detector):
    views = [picture(z=z) for z in (1.0, 5.0)]
    clear, far = (share_found(detector(), view, pictures=200) for view in views)
    near, dusty = (share_found(detector(), view, pictures=200, haze_per_m=0.8) for view in views)
    assert clear == far > 0.75
    assert near > 0.6
    assert dusty < 0.15
