"""All sensors of a flight, the inertial sensor by itself, and a sensor of another author."""

from __future__ import annotations

import copy
import math
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import pytest

from scaloft_fi.errors import InputError
from scaloft_fi.marks import NotNegative
from scaloft_fi.sim.build import GRAVITY_MPS2, physics_server
from scaloft_fi.sim.contact import Contact
from scaloft_fi.sim.flight import FlightLoop
from scaloft_fi.sim.load import load
from scaloft_fi.sim.sensors import Sensors
from scaloft_fi.sim.sensors.body import BarometerConfig, ImuConfig, ImuSensor, MagnetometerConfig
from scaloft_fi.sim.sensors.sensor import SENSORS, SensorKind
from scaloft_fi.sim.sensors.suite import pipe
from scaloft_fi.stack.declaration import STEP_S, PlainWire
from scaloft_fi.stack.messages import Exposure, Stamps
from scaloft_fi.streams import Table
from tests.sim.conftest import state_at

HOVER = np.full(4, 3.68)
GOOD = Exposure(math.log2(0.5 / 0.9), 1.0, 0.0)
AHEAD = (0.0, 0.0, math.sqrt(0.5), math.sqrt(0.5))


def state(x=0.0, y=0.0):
    return state_at((x, y, 1.65), AHEAD)


@pytest.fixture
def suite(scenario):
    """The sensors of a flight, and its surroundings."""

    def make(key="T0O0W0D0H1", seed=0, config=None):
        flown = scenario(key)
        around = flown.world.surroundings()
        return Sensors((config or flown).sensors, around, flown.labels, key, seed), around

    return make


def run(sensors, ticks, stamps=None, exposure=GOOD, speed=0.02):
    return [sensors.frames(k, state(y=speed * k), HOVER, exposure, stamps and stamps(k)) for k in ticks]


@pytest.mark.parametrize(("latency_s", "ticks"), [(0.0, 0), (0.05, 1), (0.1, 2), (0.13, 3), (0.3, 6), (0.0500001, 2)])
def test_a_message_arrives_at_the_first_tick_after_its_latency(latency_s, ticks):
    late, arrived = pipe(latency_s), []
    for tick in range(10):
        late.append(tick)
        arrived.append(late.popleft())
    assert arrived == [None] * ticks + list(range(10 - ticks))


def test_each_sensor_delivers_at_its_rate_and_latency(config, suite):
    frames = run(suite()[0], range(41))
    missing = {name: [k for k, f in enumerate(frames) if getattr(f, name) is None] for name in ("fix", "depth")}
    depth_s = config.sensors.depth.latency_s
    assert missing == {"fix": [0], "depth": list(range(round(depth_s * 20)))}
    assert all(f.depth.stamp_s == pytest.approx(k / 20 - depth_s) for k, f in enumerate(frames) if f.depth is not None)
    detections = [k for k, f in enumerate(frames) if f.detections is not None]
    assert detections
    assert all((k - 6) % 4 == 0 and k >= 6 for k in detections)
    assert all(frames[k].detections.stamp_s == pytest.approx(k / 20 - 0.3) for k in detections)
    assert [k for k, f in enumerate(frames) if f.battery is not None] == [0, 20, 40]
    assert all(f.metering is not None and f.bumper is not None for f in frames)
    assert all(f.detections is None for f in run(suite("T0O0W0D0H0")[0], range(60)))


def test_messages_carry_the_stamp_of_their_measurement(config, suite):
    frames = run(suite()[0], range(12), stamps=lambda k: Stamps(1000 + k, 2000 + k, 3000 + k))
    delay = round(config.sensors.depth.latency_s * 20)
    assert (frames[5].fix.stamp_s, frames[9].depth.stamp_s) == (1004, 2009 - delay)
    assert {f.detections.stamp_s for f in frames if f.detections} <= {3000, 3004}


def test_a_fix_is_near_the_place_of_its_measurement(config, suite):
    fixes = [f.fix for f in run(suite()[0], range(200))[1:]]
    errors = np.array([fix.position - state(y=0.02 * k)[:3] for k, fix in enumerate(fixes)])
    assert errors.std() == pytest.approx(config.sensors.positioning.sigma_m, rel=0.15)
    assert np.std([fix.yaw_rad for fix in fixes]) == pytest.approx(math.radians(0.5), rel=0.2)


def test_the_fixes_drift_and_the_meter_sees_the_light_fail(suite):
    sensors, around = suite()
    before = run(sensors, range(100), speed=0.0)
    around.drift_m[:], around.light = (0.5, -0.2, 0.1), 0.9 / 8
    after = run(sensors, range(100, 200), speed=0.0)
    places, errors = (
        [np.mean([of(f) for f in frames[5:]], axis=0) for frames in (before, after)]
        for of in (lambda f: f.fix.position, lambda f: f.metering.error_ev)
    )
    assert places[1] - places[0] == pytest.approx((0.5, -0.2, 0.1), abs=0.01)
    assert errors[1] - errors[0] == pytest.approx(3.0, abs=0.03)


def test_the_depth_camera_sees_less_far_in_dust(suite):
    sensors, around = suite("T0O0W0D0H0")
    clear = run(sensors, range(6), speed=0.0)[-1].depth.depth
    around.haze_per_m = 1.0
    dusty = run(sensors, range(6, 12), speed=0.0)[-1].depth.depth
    assert (clear > 4.0).mean() > 0.1
    assert (dusty[clear > 4.0] > 0.0).mean() < 0.1


def test_the_light_meter_reads_the_exposure_error(config, suite):
    frames = run(suite()[0], range(100), exposure=Exposure(GOOD.ev - 2, 1, 0))
    readings = [frame.metering.error_ev for frame in frames]
    assert np.mean(readings) == pytest.approx(2, abs=0.02)
    assert np.std(readings) == pytest.approx(config.sensors.metering.sigma_ev, rel=0.25)


def test_the_battery_drains_and_sags_with_the_thrust(suite):
    messages = [f.battery for f in run(suite()[0], range(1201)) if f.battery]
    charges = [battery.charge for battery in messages]
    assert charges[0] == pytest.approx(0.95, abs=1e-3)
    assert all(a > b for a, b in pairwise(charges))
    assert 10 < charges[-1] / (charges[0] - charges[-1]) < 30  # it hovers about a quarter of an hour
    assert 3.3 * 4 < messages[-1].voltage_v < 4.2 * 4
    assert suite()[0].frames(0, state(), np.zeros(4), GOOD).battery.voltage_v > messages[0].voltage_v
    assert messages[0].cells == 4


def test_the_barometer_reads_less_above_and_the_magnetometer_the_field_along_the_axes_of_the_body(config, suite):
    own = {"barometer": BarometerConfig(0.0, 0.1), "magnetometer": MagnetometerConfig(0.3, 0.0)}
    sensors, _ = suite(config=replace(config, sensors=replace(config.sensors, by_name=config.sensors.by_name | own)))
    low, high = (
        [sensors.frames(tick, state_at((0.0, 0.0, z), AHEAD), HOVER, GOOD) for tick in range(200)] for z in (0.0, 10.0)
    )
    assert low[0]["barometer"].pressure_hpa - high[0]["barometer"].pressure_hpa == pytest.approx(1.2, abs=0.01)
    fields = np.array([frames["magnetometer"].field for frames in low])
    assert fields.mean(axis=0) == pytest.approx([0.0, -21.0, -42.0], abs=0.1)
    assert fields.std(axis=0) == pytest.approx([0.3] * 3, rel=0.2)


def test_the_bumper_tells_a_touch_once_and_hull_from_gear(suite):
    sensors, told = suite()[0], []
    for touches in ([Contact("ground", True)], [Contact("wall", False)], []):
        sensors.feel(touches)
        told.append(sensors.frames(len(told), state(), HOVER, GOOD).bumper)
    assert [(one.hull, one.gear) for one in told] == [(False, True), (True, False), (False, False)]


def test_flights_repeat_bit_for_bit_another_seed_differs_and_a_copy_goes_on_alike(suite):
    (first, _), (again, _), (other, _) = (suite(seed=seed) for seed in (0, 0, 1))
    frames, same, differ = (run(sensors, range(20)) for sensors in (first, again, other))
    assert str(frames) == str(same) != str(differ)
    twin = copy.deepcopy(first)
    for a, b in zip((*frames, *run(first, range(20, 30))), (*same, *run(twin, range(20, 30))), strict=True):
        assert a.depth is None or np.array_equal(a.depth.depth, b.depth.depth)
        assert a.fix is None or np.array_equal(a.fix.position, b.fix.position)


def test_one_channels_noise_does_not_move_with_anothers_input(suite):
    """A fault that changes the path of the vehicle leaves every other sensor's draws where they were."""
    (plain, _), (elsewhere, _) = suite(), suite()
    for k in range(30):
        a = plain.frames(k, state(), HOVER, GOOD)
        b = elsewhere.frames(k, state(x=0.3), 2 * HOVER, Exposure(-3, 8, 0.5))
        if a.fix is not None:
            assert np.allclose(b.fix.position - a.fix.position, (0.3, 0, 0))
            assert a.fix.yaw_rad == b.fix.yaw_rad


def test_latencies_are_settings(study, suite):
    config = load(study, {"sensors.depth.latency_s": 0.2, "sensors.positioning.latency_s": 0.0})
    frames = run(suite(config=config)[0], range(6))
    assert frames[0].fix is not None
    assert [f.depth is None for f in frames] == [True] * 4 + [False] * 2


class Range(NamedTuple):
    stamp_s: float
    range_m: float


@dataclass(frozen=True)
class RangeConfig:
    sigma_m: NotNegative


class RangeFinder:
    """A sensor of another author's package: one class and one declaration."""

    def __init__(self, config, flight):
        self.sigma_m = config.sigma_m
        self.noise = Table(1, *flight.stream, "range")

    def measure(self, moment):
        noise_m = self.sigma_m * float(self.noise.row(moment.tick)[0])
        return Range(moment.now_s, float(moment.view.depth[24, 32]) + noise_m)


@pytest.fixture
def with_entry(monkeypatch, study):
    """The study's simulation with an entry for the declared sensor."""
    kind = SensorKind(RangeFinder, Range, RangeConfig, period_ticks=2, latency_s=0.1)
    monkeypatch.setitem(SENSORS._entries, "range", kind)

    def make(text):
        with (study / "sensors.yaml").open("a") as file:
            file.write(text)
        return load(study)

    return make


def flown(config, ticks=12):
    """Digest of so many ticks, and what the stack got at each."""
    frames = []
    with physics_server() as client:
        flight = FlightLoop(client, config, config.scenario(config.grid.situation("T0O0W0D0H0")), 0, PlainWire())
        companion = flight.stack.companion
        flight.stack.companion = lambda now_s, frame: frames.append(frame) or companion(now_s, frame)
        for _ in range(ticks):
            flight.tick()
            flight.advance()
        return flight.log().digest, frames


@pytest.mark.flight
def test_a_declared_sensor_flies_where_the_study_has_an_entry_for_it_and_moves_no_other(with_entry, config):
    digest, frames = flown(with_entry("range:\n  sigma_m: 0.02\n"))
    assert [k for k, frame in enumerate(frames) if frame["range"] is not None] == [2, 4, 6, 8, 10]
    assert frames[6]["range"].stamp_s == pytest.approx(0.2)
    without, plain = flown(config)
    assert digest == without
    assert "range" not in plain[0].by_sensor
    assert str(plain[5].metering) == str(frames[5].metering)


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("range:\n  sigma_m: -1\n", r"sensors.yaml:\d+: sigma_m=-1 must be >= 0"),
        ("rnage:\n  sigma_m: 0.02\n", r"sensors.yaml:\d+: unknown key 'rnage' in .*; did you mean 'range'"),
    ],
)
def test_its_settings_are_checked_and_an_entry_that_nobody_declared_is_refused_with_the_nearest(
    with_entry, text, sentence
):
    with pytest.raises(InputError, match=sentence):
        with_entry(text)


IDEAL = ImuConfig(rate_sigma_radps=0, rate_bias_radps=0, force_sigma_mps2=0, force_bias_mps2=0)
HALF = math.sqrt(0.5)


@pytest.fixture
def ideal():
    return ImuSensor(IDEAL, "S", 0)


def test_at_rest_it_feels_the_floor_push_against_gravity_sideways_where_it_is_rolled_over(ideal):
    sample = ideal.measure(0, state_at())
    assert np.allclose(sample.force, (0, 0, GRAVITY_MPS2))
    assert not sample.rate.any()
    assert sample.stamp_s == 0
    assert np.allclose(ideal.measure(1, state_at(attitude=(HALF, 0, 0, HALF))).force, (0, GRAVITY_MPS2, 0))


def test_falling_freely_it_feels_nothing(ideal):
    for step in range(5):
        sample = ideal.measure(step, state_at(velocity=(0, 0, -GRAVITY_MPS2 * step * STEP_S)))
    assert np.allclose(sample.force, 0, atol=1e-9)
    assert sample.stamp_s == 4 * STEP_S


def test_acceleration_and_rate_are_told_in_body_axes(ideal):
    left = (0, 0, HALF, HALF)
    ideal.measure(0, state_at(attitude=left))
    sample = ideal.measure(1, state_at(attitude=left, velocity=(0, 2 * STEP_S, 0), rate=(0.1, 0.2, 0.3)))
    assert np.allclose(sample.force, (2, 0, GRAVITY_MPS2))
    assert np.allclose(sample.rate, (0.2, -0.1, 0.3))


def test_noise_has_its_size_and_biases_stay(config):
    quiet = replace(config.sensors.imu, rate_bias_radps=0.5)
    sensor = ImuSensor(quiet, "S", 0)
    rates = np.array([sensor.measure(step, state_at()).rate for step in range(3000)])
    assert np.allclose(rates.std(axis=0), quiet.rate_sigma_radps, rtol=0.1)
    assert np.abs(rates.mean(axis=0)).max() > 10 * quiet.rate_sigma_radps / math.sqrt(3000)


@pytest.mark.parametrize(("situation", "seed", "same"), [("S", 0, True), ("S", 1, False), ("R", 0, False)])
def test_noise_depends_on_situation_seed_and_step_only_and_a_sent_sample_is_not_written_to_again(
    config, situation, seed, same
):
    first, second = ImuSensor(config.sensors.imu, "S", 0), ImuSensor(config.sensors.imu, situation, seed)
    sent = [first.measure(step, state_at()) for step in range(10)]
    kept = sent[-1].rate.copy()
    samples = [sensor.measure(2000, state_at(rate=(1, 1, 1))).rate for sensor in (first, second)]
    assert np.array_equal(*samples) == same
    assert np.array_equal(sent[-1].rate, kept)
