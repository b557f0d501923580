from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from scaloft_fi.sim.mesh import View
from scaloft_fi.sim.sensors.camera import CERTAIN, DepthSensor
from scaloft_fi.sim.sensors.sensor import FlightSetting
from scaloft_fi.streams import key_words

SHAPE = (48, 64)
MASK = (1 << 64) - 1
LIGHT = 0.9


def wall(z, segment=0):
    return View(np.full(SHAPE, float(z)), np.full(SHAPE, segment, np.int16))


def sensor(config, seed=0, reflectivity=(0.5, 0.004), **changes):
    scene = replace(config.world.scene, reflectivity=np.array(reflectivity))
    setting = FlightSetting(config.sensors.by_name, scene, {}, ("S", seed))
    return DepthSensor(replace(config.sensors.depth, **changes), setting)


def word(key, counter):
    """SplitMix64 in whole numbers."""
    x = (key + counter * 0x9E3779B97F4A7C15) & MASK
    x = ((x ^ (x >> 30)) * 0xBF58476D1CE4E5B9) & MASK
    x = ((x ^ (x >> 27)) * 0x94D049BB133111EB) & MASK
    return x ^ (x >> 31)


@pytest.mark.parametrize("haze_per_m", [0.0, 0.3])
def test_the_compiled_kernel_equals_plain_python(config, haze_per_m):
    depth = config.sensors.depth
    draw = np.random.default_rng(0)
    view = View(draw.uniform(0.1, 9.0, SHAPE), draw.integers(0, 2, SHAPE).astype(np.int16))
    frame = sensor(config).frame(7, view, 0.35, 0.3, haze_per_m).depth
    key = key_words("S", 0, "depth")[0]
    for row, column in [(0, 0), (47, 63), *draw.integers(0, 48, (400, 2)).tolist()]:
        z, rho = view.depth[row, column], (0.5, 0.004)[view.segments[row, column]]
        counter = 7 * 2 * 48 * 64 + 2 * (row * 64 + column)
        seen = math.exp(-haze_per_m * z)
        signal = depth.passive * 0.3 * min(1, depth.passive_range_m / z) * seen + depth.active * rho / z**2 * seen**2
        x = (signal - depth.snr_half) / depth.snr_width
        chance = 0 if x < -CERTAIN else depth.best / (1 + math.exp(-x)) if x <= CERTAIN else depth.best
        expected = 0.0
        if depth.min_m <= z <= depth.max_m and (word(key, counter) >> 11) * 2.0**-53 < chance:
            bits = word(key, counter + 1)
            total = sum((bits >> shift) & 0xFFFF for shift in (0, 16, 32, 48))
            noise = (total - 2 * 65535) / math.sqrt(4 * (65536**2 - 1) / 12)
            expected = max(z + depth.sigma_per_m * z * z * noise, depth.min_m / 2)
        assert frame[row, column] == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize("z", [1.0, 4.0, 7.5])
def test_noise_grows_with_the_square_of_the_range(config, z):
    frame = sensor(config).frame(0, wall(z), 0.0, LIGHT).depth
    seen = frame[frame > 0]
    sigma = config.sensors.depth.sigma_per_m * z * z
    assert seen.std() == pytest.approx(sigma, rel=0.08)
    assert seen.mean() == pytest.approx(z, abs=4 * sigma / math.sqrt(len(seen)))


def test_in_light_nearly_every_pixel_returns(config):
    share = np.mean(sensor(config).frame(0, wall(4), 0.0, LIGHT).depth > 0)
    assert share == pytest.approx(config.sensors.depth.best, abs=0.01)


def test_out_of_range_nothing_returns(config):
    depth = config.sensors.depth
    for z in (0.9 * depth.min_m, 1.01 * depth.max_m, math.inf):
        assert not sensor(config).frame(0, wall(z, -1 if math.isinf(z) else 0), 0.0, LIGHT).depth.any()


def test_in_the_dark_rock_is_seen_near_and_the_bar_hardly_at_all(config):
    rho = (0.5, config.world.bodies["bar"].reflectivity)
    dark = sensor(config, reflectivity=rho)
    assert np.mean(dark.frame(0, wall(2, 0), 0.0, 0.003).depth > 0) > 0.9
    assert np.mean(dark.frame(0, wall(6, 0), 0.0, 0.003).depth > 0) < 0.05
    assert np.mean(dark.frame(0, wall(1, 1), 0.0, 0.003).depth > 0) < 0.05
    light = sensor(config, reflectivity=rho)
    assert np.mean(light.frame(0, wall(4, 1), 0.0, LIGHT).depth > 0) > 0.9


def test_frames_differ_and_repeat(config):
    first, again = sensor(config), sensor(config)
    again.frame(3, wall(4), 0.0, LIGHT)
    frames = [it.frame(5, wall(4), 0.25, LIGHT) for it in (first, again)]
    assert np.array_equal(frames[0].depth, frames[1].depth)
    assert frames[0].stamp_s == 0.25
    assert not np.array_equal(frames[0].depth, first.frame(6, wall(4), 0.3, LIGHT).depth)
    assert not np.array_equal(frames[0].depth, sensor(config, seed=1).frame(5, wall(4), 0.25, LIGHT).depth)


def test_pixels_are_independent(config):
    frame = sensor(config).frame(0, wall(4), 0.0, LIGHT).depth
    noise = (frame - 4)[:, :]
    both = (frame[:, 1:] > 0) & (frame[:, :-1] > 0)
    assert abs(np.corrcoef(noise[:, 1:][both], noise[:, :-1][both])[0, 1]) < 0.08


def test_dust_hides_what_is_far_and_not_what_is_near(config):
    def share(z):
        return np.mean(sensor(config).frame(0, wall(z), 0.0, LIGHT, 0.6).depth > 0)

    assert share(1.0) > 0.95
    assert share(6.0) < 0.05
