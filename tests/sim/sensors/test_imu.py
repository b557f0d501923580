from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from scaloft_fi.sim.build import GRAVITY_MPS2
from scaloft_fi.sim.sensors.body import ImuConfig, ImuSensor
from scaloft_fi.sim.vehicle import STATE_SIZE
from scaloft_fi.stack.declaration import STEP_S

IDEAL = ImuConfig(rate_sigma_radps=0, rate_bias_radps=0, force_sigma_mps2=0, force_bias_mps2=0)


def state(velocity=(0, 0, 0), rate=(0, 0, 0), yaw=0.0, roll=0.0):
    it = np.zeros(STATE_SIZE)
    half_roll, half_yaw = 0.5 * roll, 0.5 * yaw
    it[3:7] = (
        math.sin(half_roll) * math.cos(half_yaw),
        math.sin(half_roll) * math.sin(half_yaw),
        math.cos(half_roll) * math.sin(half_yaw),
        math.cos(half_roll) * math.cos(half_yaw),
    )
    it[7:10], it[10:13] = velocity, rate
    return it


def test_at_rest_it_feels_the_floor_push_against_gravity():
    sample = ImuSensor(IDEAL, "S", 0).measure(0, state())
    assert np.allclose(sample.force, (0, 0, GRAVITY_MPS2))
    assert np.allclose(sample.rate, 0)
    assert sample.stamp_s == 0


def test_falling_freely_it_feels_nothing():
    sensor = ImuSensor(IDEAL, "S", 0)
    for step in range(5):
        sample = sensor.measure(step, state(velocity=(0, 0, -GRAVITY_MPS2 * step * STEP_S)))
    assert np.allclose(sample.force, 0, atol=1e-9)
    assert sample.stamp_s == 4 * STEP_S


def test_acceleration_and_rate_are_told_in_body_axes():
    sensor = ImuSensor(IDEAL, "S", 0)
    sensor.measure(0, state(yaw=math.pi / 2))
    sample = sensor.measure(1, state(velocity=(0, 2 * STEP_S, 0), rate=(0.1, 0.2, 0.3), yaw=math.pi / 2))
    assert np.allclose(sample.force, (2, 0, GRAVITY_MPS2))
    assert np.allclose(sample.rate, (0.2, -0.1, 0.3))


def test_rolled_over_it_feels_gravity_sideways():
    assert np.allclose(ImuSensor(IDEAL, "S", 0).measure(0, state(roll=math.pi / 2)).force, (0, GRAVITY_MPS2, 0))


def test_noise_has_its_size_and_biases_stay(config):
    quiet = replace(config.sensors.imu, rate_bias_radps=0.5)
    sensor = ImuSensor(quiet, "S", 0)
    rates = np.array([sensor.measure(step, state()).rate for step in range(3000)])
    assert np.allclose(rates.std(axis=0), quiet.rate_sigma_radps, rtol=0.1)
    assert np.abs(rates.mean(axis=0)).max() > 10 * quiet.rate_sigma_radps / math.sqrt(3000)


@pytest.mark.parametrize(("situation", "seed", "same"), [("S", 0, True), ("S", 1, False), ("R", 0, False)])
def test_noise_depends_on_situation_seed_and_step_only(config, situation, seed, same):
    first, second = ImuSensor(config.sensors.imu, "S", 0), ImuSensor(config.sensors.imu, situation, seed)
    for step in range(10):
        first.measure(step, state())
    samples = [sensor.measure(2000, state()).rate for sensor in (first, second)]
    assert np.array_equal(*samples) == same


def test_a_sample_that_was_sent_is_not_written_to_again(config):
    sensor = ImuSensor(config.sensors.imu, "S", 0)
    first = sensor.measure(0, state())
    kept = first.rate.copy()
    sensor.measure(1, state(rate=(1, 1, 1)))
    assert np.array_equal(first.rate, kept)
