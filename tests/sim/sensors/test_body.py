"""The inertial sensor; the other sensors of the body are in the suite's tests."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from scaloft_fi.sim.build import GRAVITY_MPS2
from scaloft_fi.sim.sensors.body import ImuConfig, ImuSensor
from scaloft_fi.stack.declaration import STEP_S
from tests.sim.conftest import state_at

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
