from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from scaloft_fi.sim.free_flight import free_step, inertia_of
from scaloft_fi.sim.load import load
from scaloft_fi.sim.reach import Reach
from scaloft_fi.sim.vehicle import STATE_SIZE, wrench
from tests.sim.conftest import SIM

VEHICLE = load(SIM).vehicle
STEPS = 12


def distance_m(state, point):
    """From the hull to a point [m]."""
    x, y, z, w = state[3:7]
    body_axes = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
    local = body_axes.T @ (point - state[:3])
    return float(np.linalg.norm(np.maximum(np.abs(local) - 0.5 * np.array(VEHICLE.hull_m), 0.0)))


def flown(vehicle, velocity, rate, thrusts):
    """States before and after each of the steps under `thrusts` (12, 4) [N]."""
    state, turned, pushed = np.zeros(STATE_SIZE), np.array([0.0, 0.0, 0.0, 1.0]), np.zeros(6)
    state[6], state[7:10], state[10:13] = 1.0, velocity, rate
    states = [state.copy()]
    for thrust in thrusts:
        wrench(thrust, state, vehicle.effect(), pushed[:3], pushed[3:])
        free_step(state, turned, pushed, inertia_of(vehicle))
        states.append(state.copy())
    return states


vectors = st.tuples(*[st.floats(-1.0, 1.0)] * 3)


@given(
    velocity=vectors,
    speed=st.sampled_from([0.0, 1.0, 5.0, 30.0]),
    rate=vectors,
    spin=st.sampled_from([0.0, 1.0, 5.0, 10.0, 40.0]),
    rotors=st.lists(
        st.sampled_from([(0, 0, 0, 0), (1, 0, 0, 1), (1, 0, 1, 0), (0, 1, 1, 0), (1, 1, 1, 1)]), min_size=1
    ),
    where=vectors,
    far_m=st.floats(0.1, 2.0),
)
def test_nothing_comes_nearer_than_it_says(velocity, speed, rate, spin, rotors, where, far_m):
    thrusts = VEHICLE.max_thrust_n * np.resize(np.array(rotors, float), (STEPS, 4))
    states = flown(VEHICLE, speed * np.array(velocity), spin * np.array(rate), thrusts)
    within_m = Reach(VEHICLE).within_tick_m(states[0].tolist())
    point = far_m * np.array(where)
    before_m = distance_m(states[0], point)
    assert all(distance_m(state, point) >= before_m - within_m for state in states)


def test_it_is_little_more_than_a_full_push_needs():
    """From rest all rotors at once: nothing but weight and the unknown turn is added to the way flown."""
    states = flown(VEHICLE, (0, 0, 0), (0, 0, 0), np.full((STEPS, 4), VEHICLE.max_thrust_n))
    rise_m = states[-1][2]
    assert 0.02 < rise_m < Reach(VEHICLE).within_tick_m(states[0].tolist()) < 0.1


def test_a_turn_counts_only_until_no_turn_can_bring_the_hull_nearer():
    reach = Reach(VEHICLE)
    still, fast, faster = ((0.0,) * 10 + (0.0, 0.0, rate) for rate in (0.0, 30.0, 60.0))
    assert reach.within_tick_m(still) < reach.within_tick_m(fast) == reach.within_tick_m(faster)


def test_a_slender_body_may_tumble_faster():
    slender = replace(VEHICLE, inertia=(0.005, 0.029125, 0.055225))
    truth = (0.0,) * 10 + (0.0, 1.0, 0.0)
    assert Reach(slender).within_tick_m(truth) > Reach(VEHICLE).within_tick_m(truth)


@pytest.mark.parametrize("place", [7, 10])
def test_without_a_number_it_says_none_or_the_most(place):
    truth = [0.0] * STATE_SIZE
    truth[place] = math.nan
    within_m = Reach(VEHICLE).within_tick_m(truth)
    assert math.isnan(within_m) or within_m > Reach(VEHICLE).any_turn_m
