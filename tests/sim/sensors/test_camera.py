"""The rasteriser beside ray casting, and the depth camera beside plain Python."""

from __future__ import annotations

import math
import time
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from scaloft_fi.sim import mesh
from scaloft_fi.sim.build import build
from scaloft_fi.sim.mesh import Camera, Scene, View
from scaloft_fi.sim.sensors.camera import CERTAIN, DepthSensor, Detector, look, pixels_of
from scaloft_fi.sim.sensors.sensor import FlightSetting
from scaloft_fi.stack.messages import Exposure
from scaloft_fi.streams import key_words
from tests.sim.conftest import turned_by

CAMERA = Camera(64, 48, math.radians(59), 0.1)
UPRIGHT = np.array([0.0, 0.0, 0.0, 1.0])
HERE = np.zeros(3)


def scene_of(*forms):
    whole = mesh.join(forms)
    owner = np.repeat(np.arange(len(forms)), [len(form.faces) for form in forms]).astype(np.int16)
    return Scene(whole.vertices, whole.faces, owner, tuple(map(str, range(len(forms)))), np.ones(len(forms)))


def cast(scene, camera, position, attitude):
    """The oracle: intersect each pixel's ray with each triangle."""
    turn = turned_by(attitude)
    start = position + turn @ [camera.ahead_m, 0, 0]
    rays = camera.rays.reshape(-1, 3) @ turn.T
    depth, segments = np.full(len(rays), np.inf), np.full(len(rays), -1)
    for (a, b, c), owner in zip(scene.vertices[scene.faces], scene.owner, strict=True):
        u, v, s = b - a, c - a, start - a
        p, q = np.cross(rays, v), np.cross(s, u)
        volume = p @ u
        with np.errstate(divide="ignore", invalid="ignore"):
            first, second, t = (p @ s) / volume, (rays @ q) / volume, (v @ q) / volume
            hit = (volume != 0) & (first >= 0) & (second >= 0) & (first + second <= 1) & (t > 0) & (t < depth)
        depth[hit], segments[hit] = t[hit], owner
    return depth.reshape(camera.height, camera.width), segments.reshape(camera.height, camera.width)


def poses(count, seed=0):
    rng = np.random.default_rng(seed)
    for _ in range(count):
        q = np.array([*rng.normal(0, 0.1, 2), *rng.normal(0, 1, 2)])
        yield np.array([rng.uniform(-1, 1), rng.uniform(-1, 8.5), rng.uniform(0.2, 2.4)]), q / np.linalg.norm(q)


@pytest.mark.parametrize("key", ["T0O0W0D0H0", "T1O1W0D0H1"])
def test_the_picture_equals_ray_casting(scenario, key):
    scene, wrong = scenario(key).world.scene, []
    for position, attitude in poses(12):
        view, (depth, segments) = look(scene, CAMERA, position, attitude), cast(scene, CAMERA, position, attitude)
        wrong.append((view.segments != segments) | ~np.isclose(view.depth, depth, rtol=0, atol=1e-6))
    assert np.mean(wrong) <= 1e-4  # rays along an edge may fall to either side


def test_a_face_is_seen_from_both_sides():
    room = scene_of(mesh.box((4, 4, 4)))
    for one in (room, replace(room, faces=room.faces[:, ::-1].copy())):
        view = look(one, CAMERA, HERE, UPRIGHT)
        assert np.allclose(view.depth, 1.9)
        assert not (view.segments == -1).any()


def test_depth_is_along_the_optical_axis_and_a_picture_gives_points_on_the_surface():
    wall, yaw = scene_of(mesh.box((1, 50, 50)).moved((5.5, 0, 0))), 0.3
    assert np.allclose(look(wall, CAMERA, HERE, UPRIGHT).depth, 4.9)
    attitude, place = np.array([0, 0, math.sin(yaw / 2), math.cos(yaw / 2)]), np.array([0.5, 1.0, 2.0])
    body = CAMERA.rays * look(wall, CAMERA, place, attitude).depth[:, :, None] + [CAMERA.ahead_m, 0, 0]
    assert np.allclose((body @ turned_by(attitude).T + place)[:, :, 0], 5)


def test_nothing_is_seen_where_nothing_is_what_is_left_is_left_and_what_is_up_is_up():
    view = look(scene_of(mesh.box((1, 1, 1)).moved((-5, 0, 0))), CAMERA, HERE, UPRIGHT)
    assert np.all(np.isinf(view.depth) & (view.segments == -1))
    left, up = (mesh.box((0.4, 0.4, 0.4)).moved(place) for place in ((3, 1, 0), (3, 0, 1)))
    segments = look(scene_of(left, up), CAMERA, HERE, UPRIGHT).segments
    assert np.nonzero(segments == 0)[1].max() < 32
    assert np.nonzero(segments == 1)[0].max() < 24


def test_rays_are_symmetric_and_span_the_field_of_view():
    rays = CAMERA.rays
    assert rays.shape == (48, 64, 3)
    assert np.allclose(rays[:, ::-1, 1], -rays[:, :, 1])
    assert np.allclose(rays[::-1, :, 2], -rays[:, :, 2])
    assert math.isclose(2 * math.atan(rays[0, 0, 1] + CAMERA.pitch / 2), CAMERA.fov_rad)


@pytest.mark.flight
def test_the_picture_equals_ray_tests_of_the_physics(scenario, client):
    import pybullet

    world, wrong = scenario("T1O1W0D0H1").world, []
    ids = build(client, world)
    numbers = np.array([ids.by_name[name] for name in world.scene.names])
    for position, attitude in poses(20, seed=1):
        turn = turned_by(attitude)
        start = position + turn @ [CAMERA.ahead_m, 0, 0]
        ends = start + 30 * CAMERA.rays.reshape(-1, 3) @ turn.T
        hits = pybullet.rayTestBatch([start.tolist()] * len(ends), ends.tolist(), physicsClientId=client)
        view, depth = look(world.scene, CAMERA, position, attitude), np.array([30 * hit[2] for hit in hits])
        seen, off_m = view.segments.ravel(), np.abs(view.depth.ravel() - depth)
        same = (seen >= 0) & (numbers[seen] == [hit[0] for hit in hits])
        assert off_m[same & np.isin(seen, (0, 1))].max(initial=0) < 1e-3
        # Bullet rounds the edges of hulls by its margin, and a grazing ray slides along them.
        wrong.append(~same | (off_m > 1e-3))
    assert np.mean(wrong) < 1e-3


def test_a_picture_is_drawn_in_less_than_a_fifth_of_a_millisecond(scenario):
    scene, shots, best = scenario("T1O1W0D0H1").world.scene, list(poses(50)), math.inf
    for _ in range(6):
        begun = time.process_time()
        for position, attitude in shots:
            look(scene, CAMERA, position, attitude)
        best = min(best, (time.process_time() - begun) / len(shots))
    assert best < 200e-6


def test_pixels_of_a_body_are_counted_within_range():
    rng = np.random.default_rng(1)
    segments = rng.integers(-1, 4, (7, 9)).astype(np.int16)
    depth = np.where(segments < 0, np.inf, rng.uniform(0, 10, (7, 9)))
    expected = np.count_nonzero(np.isin(segments, [1, 3]) & (depth <= 5.0))
    assert pixels_of(segments, depth, np.array([False, True, False, True]), 5.0) == expected > 0


SHAPE = (48, 64)
MASK = (1 << 64) - 1
LIGHT = 0.9


def wall(z, segment=0):
    return View(np.full(SHAPE, float(z)), np.full(SHAPE, segment, np.int16))


@pytest.fixture
def sensor(config):
    def make(seed=0, reflectivity=(0.5, 0.004)):
        scene = replace(config.world.scene, reflectivity=np.array(reflectivity))
        return DepthSensor(config.sensors.depth, FlightSetting(config.sensors.by_name, scene, {}, ("S", seed)))

    return make


@pytest.fixture
def share(sensor):
    """The share of the pixels of a wall that have a depth."""

    def make(z, segment=0, light=LIGHT, haze_per_m=0.0, **of):
        return np.mean(sensor(**of).frame(0, wall(z, segment), 0.0, light, haze_per_m).depth > 0)

    return make


def word(key, counter):
    """SplitMix64 in whole numbers."""
    x = (key + counter * 0x9E3779B97F4A7C15) & MASK
    x = ((x ^ (x >> 30)) * 0xBF58476D1CE4E5B9) & MASK
    x = ((x ^ (x >> 27)) * 0x94D049BB133111EB) & MASK
    return x ^ (x >> 31)


@pytest.mark.parametrize("haze_per_m", [0.0, 0.3])
def test_the_compiled_camera_equals_plain_python(config, sensor, haze_per_m):
    depth, rng = config.sensors.depth, np.random.default_rng(0)
    view = View(rng.uniform(0.1, 9.0, SHAPE), rng.integers(0, 2, SHAPE).astype(np.int16))
    frame = sensor().frame(7, view, 0.35, 0.3, haze_per_m).depth
    key = key_words("S", 0, "depth")[0]
    for row, column in [(0, 0), (47, 63), *rng.integers(0, 48, (400, 2)).tolist()]:
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
def test_noise_grows_with_the_square_of_the_range_pixel_by_pixel(config, sensor, z):
    frame = sensor().frame(0, wall(z), 0.0, LIGHT).depth
    seen, sigma = frame[frame > 0], config.sensors.depth.sigma_per_m * z * z
    assert seen.std() == pytest.approx(sigma, rel=0.08)
    assert seen.mean() == pytest.approx(z, abs=4 * sigma / math.sqrt(len(seen)))
    right, left = frame[:, 1:], frame[:, :-1]
    both = (right > 0) & (left > 0)
    assert abs(np.corrcoef(right[both], left[both])[0, 1]) < 0.08


def test_in_light_nearly_every_pixel_returns_and_out_of_range_none(config, share):
    depth = config.sensors.depth
    assert share(4) == pytest.approx(depth.best, abs=0.01)
    for z in (0.9 * depth.min_m, 1.01 * depth.max_m, math.inf):
        assert share(z, -1 if math.isinf(z) else 0) == 0


def test_in_the_dark_rock_is_seen_near_and_the_bar_hardly_at_all_and_dust_hides_what_is_far(config, share):
    rho = (0.5, config.world.bodies["bar"].reflectivity)
    seen = [share(z, body, light, reflectivity=rho) for z, body, light in ((2, 0, 0.003), (4, 1, LIGHT))]
    lost = [share(z, body, 0.003, reflectivity=rho) for z, body in ((6, 0), (1, 1))]
    assert min(*seen, share(1.0, haze_per_m=0.6)) > 0.9
    assert max(*lost, share(6.0, haze_per_m=0.6)) < 0.05


def test_frames_differ_and_repeat(sensor):
    first, again = sensor(), sensor()
    again.frame(3, wall(4), 0.0, LIGHT)
    frame, same = (it.frame(5, wall(4), 0.25, LIGHT) for it in (first, again))
    assert np.array_equal(frame.depth, same.depth)
    assert frame.stamp_s == 0.25
    for other in (first.frame(6, wall(4), 0.3, LIGHT), sensor(seed=1).frame(5, wall(4), 0.25, LIGHT)):
        assert not np.array_equal(frame.depth, other.depth)


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
