from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from scaloft_fi.sim.mesh import View
from scaloft_fi.sim.sensors.detector import Detector
from scaloft_fi.sim.sensors.sensor import FlightSetting
from scaloft_fi.stack.messages import Exposure

LIGHT = 0.9
GOOD = Exposure(math.log2(0.5 / 0.9), 1.0, 0.0)
shares, lights = st.floats(0, 1), st.floats(1e-6, 1)


def picture(pixels=100, column=10, z=3.0):
    depth, segments = np.full((48, 64), 6.0), np.zeros((48, 64), np.int16)
    rows = np.arange(pixels) % 48
    columns = column + np.arange(pixels) // 48
    depth[rows, columns], segments[rows, columns] = z, 4
    return View(depth, segments)


def detector(config, persons=None, seed=0, **changes):
    changed = replace(config.sensors.detector, **changes)
    persons = {4: "person"} if persons is None else persons
    names = tuple(persons.get(number, f"body {number}") for number in range(6))
    scene = replace(config.world.scene, names=names)
    labels = dict.fromkeys(persons.values(), "person")
    return Detector(changed, FlightSetting(config.sensors.by_name, scene, labels, ("S", seed)))


def share_found(it, view, exposure=GOOD, pictures=400, light=LIGHT, haze_per_m=0.0):
    return np.mean([it.find(k, view, exposure, 0.0, light, haze_per_m) is not None for k in range(pictures)])


def test_a_bright_near_person_is_found_as_often_as_the_formula_says(config):
    expected = config.sensors.detector.probability(100, 0.9, 1.0, 0.0)
    assert expected > 0.75
    assert share_found(detector(config), picture()) == pytest.approx(expected, abs=0.06)


@given(lights, st.floats(1, 500), st.floats(1, 16), st.floats(-6, 6))
def test_probability_is_a_probability_and_falls_with_every_trouble(config, light, pixels, gain, error_ev):
    chance = config.sensors.detector.probability
    p = chance(pixels, light, gain, error_ev)
    assert 0 <= p <= config.sensors.detector.best
    assert chance(pixels, light, 2 * gain, error_ev) <= p
    assert chance(0.5 * pixels, light, gain, error_ev) <= p
    assert chance(pixels, 0.5 * light, gain, error_ev) <= p
    assert chance(pixels, light, gain, 1.5 * error_ev) <= p


def test_in_total_darkness_the_detector_is_blind(config):
    dark = Exposure(4.0, 4.0, 0.0)
    assert share_found(detector(config), picture(), dark, light=0.003) < 0.02
    assert share_found(detector(config), picture(), dark, light=0.0) == 0


def test_nobody_is_found_where_nobody_is(config):
    assert share_found(detector(config), View(np.full((48, 64), 6.0), np.zeros((48, 64), np.int16))) == 0
    assert share_found(detector(config, persons={}), picture()) == 0


def test_a_bad_exposure_hides_a_person(config):
    assert share_found(detector(config), picture(), Exposure(GOOD.ev + 4, 1.0, 0.0)) < 0.1
    assert share_found(detector(config), picture(), Exposure(GOOD.ev, 16.0, 0.0)) < 0.4
    assert share_found(detector(config), picture(60), Exposure(GOOD.ev, 1.0, 0.6)) < 0.6


def test_an_order_that_is_no_number_hides_a_person(config):
    assert share_found(detector(config), picture(), Exposure(math.nan, 1.0, 0.0)) == 0


def test_bearing_and_range_are_those_of_the_visible_part(config):
    it = detector(config, bearing_sigma_deg=0.0, range_sigma=0.0, best=1.0, noise_light=0.0)
    found = it.find(0, picture(96, column=10), GOOD, 0.1, LIGHT).persons[0]
    left = config.sensors.depth.camera.rays[0, 10:12, 1]
    assert found.bearing_rad == pytest.approx(math.atan(left.mean()))
    assert found.bearing_rad > 0
    assert found.range_m == pytest.approx(3 * np.mean(np.hypot(1, left)))
    assert found.label == "person"


def test_bearing_and_range_are_noisy_without_offset(config):
    it = detector(config, best=1.0, noise_light=0.0)
    found = [it.find(k, picture(), GOOD, 0.0, LIGHT).persons[0] for k in range(400)]
    ranges, bearings = np.array([p.range_m for p in found]), np.array([p.bearing_rad for p in found])
    assert ranges.std() / ranges.mean() == pytest.approx(config.sensors.detector.range_sigma, rel=0.15)
    assert bearings.std() == pytest.approx(math.radians(config.sensors.detector.bearing_sigma_deg), rel=0.15)


def test_the_score_rises_with_the_probability(config):
    config_ = config.sensors.detector
    assert config_.score(0.8, 0) > config_.score(0.4, 0) > config_.score(0.0, 0)
    assert 0.05 <= config_.score(0, -99) <= config_.score(1, 99) <= 0.999
    assert config_.score(config_.probability(100, 0.9, 1, 0), 0) > 0.7


def test_false_positives_come_at_their_rate(config):
    empty = View(np.full((48, 64), 6.0), np.zeros((48, 64), np.int16))
    assert share_found(detector(config, false_positives=0.2), empty) == pytest.approx(0.2, abs=0.06)
    assert share_found(detector(config), empty) == 0


def test_detection_depends_on_the_picture_number_only(config):
    first, second = detector(config), detector(config)
    for k in range(30):
        first.find(k, picture(), GOOD, 0.0, LIGHT)
    assert first.find(40, picture(), GOOD, 0.0, LIGHT) == second.find(40, picture(), GOOD, 0.0, LIGHT)


def test_each_person_is_found_by_itself(config):
    view = picture()
    view.segments[:, 40:44] = 5
    it = detector(config, persons={4: "miner", 5: "visitor"}, best=1.0, noise_light=0.0)
    bearings = [person.bearing_rad for person in it.find(0, view, GOOD, 0.0, LIGHT).persons]
    assert bearings[0] > 0 > bearings[1]


def test_dust_hides_a_far_person_and_not_a_near_one(config):
    clear = [share_found(detector(config), picture(z=z), pictures=200) for z in (1.0, 5.0)]
    dusty = [share_found(detector(config), picture(z=z), pictures=200, haze_per_m=0.8) for z in (1.0, 5.0)]
    assert clear[0] == clear[1] > 0.75
    assert dusty[0] > 0.6
    assert dusty[1] < 0.15
