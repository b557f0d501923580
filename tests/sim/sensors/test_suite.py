from __future__ import annotations

import copy
import math
from itertools import pairwise

import numpy as np
import pytest

from scaloft_fi.sim.contact import Contact
from scaloft_fi.sim.load import load
from scaloft_fi.sim.sensors import Sensors
from scaloft_fi.sim.sensors.suite import Pipe
from scaloft_fi.sim.vehicle import STATE_SIZE
from scaloft_fi.stack.messages import Exposure, Stamps

HOVER = np.full(4, 3.68)
GOOD = Exposure(math.log2(0.5 / 0.9), 1.0, 0.0)


def state(x=0.0, y=0.0, yaw=math.pi / 2):
    it = np.zeros(STATE_SIZE)
    it[:3] = (x, y, 1.65)
    it[5:7] = (math.sin(yaw / 2), math.cos(yaw / 2))
    return it


def suite(config, key="T0O0W0D0H1", seed=0):
    scenario = config.scenario(config.grid.situation(key))
    return Sensors(config.sensors, scenario.world.surroundings(), scenario.labels, key, seed)


def run(sensors, ticks, stamps=None, where=state):
    return [sensors.frames(k, where(y=0.02 * k), HOVER, GOOD, stamps and stamps(k)) for k in range(ticks)]


@pytest.mark.parametrize(("latency_s", "ticks"), [(0.0, 0), (0.05, 1), (0.1, 2), (0.13, 3), (0.3, 6), (0.0500001, 2)])
def test_a_message_arrives_at_the_first_tick_after_its_latency(latency_s, ticks):
    pipe = Pipe(latency_s)
    arrived = []
    for tick in range(10):
        pipe.send(tick, tick)
        arrived.append(pipe.arrive(tick))
    assert arrived == [None] * ticks + list(range(10 - ticks))


def test_each_sensor_delivers_at_its_rate_and_latency(config):
    frames = run(suite(config), 41)
    assert [k for k, f in enumerate(frames) if f.fix is None] == [0]
    depth_s = config.sensors.depth.latency_s
    assert [k for k, f in enumerate(frames) if f.depth is None] == list(range(round(depth_s * 20)))
    assert all(f.depth.stamp_s == pytest.approx(k / 20 - depth_s) for k, f in enumerate(frames) if f.depth is not None)
    detections = [k for k, f in enumerate(frames) if f.detections is not None]
    assert detections
    assert all((k - 6) % 4 == 0 and k >= 6 for k in detections)
    assert all(frames[k].detections.stamp_s == pytest.approx(k / 20 - 0.3) for k in detections)
    assert [k for k, f in enumerate(frames) if f.battery is not None] == [0, 20, 40]
    assert all(f.metering is not None and f.bumper is not None for f in frames)


def test_messages_carry_the_stamp_of_their_measurement(config):
    frames = run(suite(config), 12, stamps=lambda k: Stamps(1000 + k, 2000 + k, 3000 + k))
    assert frames[5].fix.stamp_s == 1004
    delay = round(config.sensors.depth.latency_s * 20)
    assert frames[9].depth.stamp_s == 2009 - delay
    stamps = {f.detections.stamp_s for f in frames if f.detections}
    assert stamps <= {3000, 3004}


def test_a_fix_is_near_the_place_of_its_measurement(config):
    sensors = suite(config)
    fixes = [f.fix for f in run(sensors, 200)[1:]]
    errors = np.array([fix.position - state(y=0.02 * k)[:3] for k, fix in enumerate(fixes)])
    assert errors.std() == pytest.approx(config.sensors.positioning.sigma_m, rel=0.15)
    assert np.std([fix.yaw_rad for fix in fixes]) == pytest.approx(math.radians(0.5), rel=0.2)


def test_the_fixes_drift_and_the_meter_sees_the_light_fail(config):
    scenario = config.scenario(config.grid.situation("T0O0W0D0H1"))
    around = scenario.world.surroundings()
    sensors = Sensors(config.sensors, around, scenario.labels, "T0O0W0D0H1", 0)
    before = [sensors.frames(k, state(), HOVER, GOOD) for k in range(100)]
    around.drift_m[:], around.light = (0.5, -0.2, 0.1), 0.9 / 8
    after = [sensors.frames(k, state(), HOVER, GOOD) for k in range(100, 200)]
    moved = np.mean([f.fix.position for f in after[5:]], axis=0) - np.mean([f.fix.position for f in before[5:]], axis=0)
    assert moved == pytest.approx((0.5, -0.2, 0.1), abs=0.01)
    errors = [np.mean([f.metering.error_ev for f in frames]) for frames in (before, after)]
    assert errors[1] - errors[0] == pytest.approx(3.0, abs=0.03)


def test_the_depth_camera_sees_less_far_in_dust(config):
    scenario = config.scenario(config.grid.situation("T0O0W0D0H0"))
    around = scenario.world.surroundings()
    sensors = Sensors(config.sensors, around, scenario.labels, "T0O0W0D0H0", 0)
    clear = [sensors.frames(k, state(), HOVER, GOOD) for k in range(6)][-1]
    around.haze_per_m = 1.0
    dusty = [sensors.frames(k, state(), HOVER, GOOD) for k in range(6, 12)][-1]
    far = clear.depth.depth > 4.0
    assert far.mean() > 0.1
    assert (dusty.depth.depth[far] > 0.0).mean() < 0.1


def test_without_a_person_nobody_is_detected(config):
    assert all(f.detections is None for f in run(suite(config, "T0O0W0D0H0"), 60))


def test_the_light_meter_reads_the_exposure_error(config):
    sensors = suite(config)
    readings = [sensors.frames(k, state(), HOVER, Exposure(GOOD.ev - 2, 1, 0)).metering.error_ev for k in range(100)]
    assert np.mean(readings) == pytest.approx(2, abs=0.02)
    assert np.std(readings) == pytest.approx(config.sensors.metering.sigma_ev, rel=0.25)


def test_the_battery_drains_and_sags_with_the_thrust(config):
    sensors = suite(config)
    messages = [f.battery for f in run(sensors, 1201) if f.battery]
    charges = [battery.charge for battery in messages]
    assert charges[0] == pytest.approx(0.95, abs=1e-3)
    assert all(a > b for a, b in pairwise(charges))
    minutes_left = charges[-1] / (charges[0] - charges[-1])
    assert 10 < minutes_left < 30  # a quadrotor of this class hovers about a quarter of an hour
    assert 3.3 * 4 < messages[-1].voltage_v < 4.2 * 4
    resting = suite(config).frames(0, state(), np.zeros(4), GOOD).battery
    assert resting.voltage_v > messages[0].voltage_v
    assert messages[0].cells == 4


def test_the_bumper_tells_a_touch_once_and_hull_from_gear(config):
    sensors = suite(config)
    sensors.feel([Contact("ground", True)])
    first = sensors.frames(0, state(), HOVER, GOOD).bumper
    sensors.feel([Contact("wall", False)])
    second = sensors.frames(1, state(), HOVER, GOOD).bumper
    third = sensors.frames(2, state(), HOVER, GOOD).bumper
    assert (first.hull, first.gear) == (False, True)
    assert (second.hull, second.gear) == (True, False)
    assert (third.hull, third.gear) == (False, False)


def test_flights_repeat_bit_for_bit_and_another_seed_differs(config):
    first, again, other = (run(suite(config, seed=seed), 20) for seed in (0, 0, 1))
    for a, b in zip(first, again, strict=True):
        assert str(a) == str(b)
        assert a.depth is None or np.array_equal(a.depth.depth, b.depth.depth)
    assert str(first) != str(other)


def test_one_channels_noise_does_not_move_with_anothers_input(config):
    """A fault that changes the path of the vehicle leaves every other sensor's draws where they were."""
    plain, elsewhere = suite(config), suite(config)
    for k in range(30):
        a = plain.frames(k, state(), HOVER, GOOD)
        b = elsewhere.frames(k, state(x=0.3), 2 * HOVER, Exposure(-3, 8, 0.5))
        if a.fix is not None:
            assert np.allclose(b.fix.position - a.fix.position, (0.3, 0, 0))
            assert a.fix.yaw_rad == b.fix.yaw_rad


def test_a_copy_goes_on_as_the_original_would(config):
    sensors = suite(config)
    run(sensors, 10)
    twin = copy.deepcopy(sensors)
    for k in range(10, 20):
        a, b = (it.frames(k, state(y=0.1), HOVER, GOOD) for it in (sensors, twin))
        assert np.array_equal(a.depth.depth, b.depth.depth)
        assert np.array_equal(a.fix.position, b.fix.position)


def test_latencies_are_settings(study):
    config = load(study, {"sensors.depth.latency_s": 0.2, "sensors.positioning.latency_s": 0.0})
    frames = run(suite(config), 6)
    assert frames[0].fix is not None
    assert [f.depth is None for f in frames] == [True] * 4 + [False] * 2
