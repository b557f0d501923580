from __future__ import annotations

import math
from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from scaloft_fi.sim.contact import Reach
from scaloft_fi.sim.load import load
from scaloft_fi.sim.vehicle import STATE_SIZE, free_step, inertia_of, wrench
from tests.sim.conftest import SIM

VEHICLE = load(SIM).vehicle
STEPS = 12
UPRIGHT, INVERTED = (0.0, 0.0, 0.0, 1.0), (1.0, 0.0, 0.0, 0.0)


def axes_of(state):
    """The body's axes as columns, (3, 3)."""
    x, y, z, w = state[3:7]
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def corners(state):
    """Of the hull, (8, 3) [m]."""
    half = 0.5 * np.array(list(product((-1.0, 1.0), repeat=3))) * VEHICLE.hull_m
    return state[:3] + half @ axes_of(state).T


def distances_m(state, points):
    """From the hull to each of `points` (N, 3) [m]."""
    local = (points - state[:3]) @ axes_of(state)
    return np.linalg.norm(np.maximum(np.abs(local) - 0.5 * np.array(VEHICLE.hull_m), 0.0), axis=1)


def flown(vehicle, velocity, rate, thrusts, attitude=UPRIGHT):
    """States before and after each of the steps under `thrusts` (T, 4) [N]."""
    state, turned, pushed = np.zeros(STATE_SIZE), np.array(attitude), np.zeros(6)
    state[3:7], state[7:10], state[10:13] = attitude, velocity, rate
    turned[:3] *= -1.0
    states = [state.copy()]
    for thrust in thrusts:
        wrench(np.asarray(thrust, float), state, vehicle.effect(), pushed[:3], pushed[3:])
        free_step(state, turned, pushed, inertia_of(vehicle))
        states.append(state.copy())
    return states


def test_wind_adds_what_its_drag_can_add_in_a_tick():
    calm, windy = Reach(VEHICLE), Reach(VEHICLE, 10.0)
    gained_m = windy.gained_m - calm.gained_m
    assert gained_m == pytest.approx(0.05**2 * 13 / 24 * VEHICLE.drag_ns_per_m * 10.0 / VEHICLE.mass_kg)
    assert windy.gained_rad == calm.gained_rad


vectors = st.tuples(*[st.floats(-1.0, 1.0)] * 3)


@given(
    velocity=vectors,
    speed=st.sampled_from([0.0, 1.0, 5.0, 30.0]),
    rate=vectors,
    spin=st.sampled_from([0.0, 1.0, 5.0, 10.0, 40.0]),
    rotors=st.lists(
        st.sampled_from([(0, 0, 0, 0), (1, 0, 0, 1), (1, 0, 1, 0), (0, 1, 1, 0), (1, 1, 1, 1)]), min_size=1
    ),
    attitude=st.sampled_from([UPRIGHT, INVERTED]),
)
def test_nothing_comes_nearer_than_it_says(velocity, speed, rate, spin, rotors, attitude):
    """What a corner of the hull arrives at was before as far away as the hull has come nearer to it."""
    thrusts = VEHICLE.max_thrust_n * np.resize(np.array(rotors, float), (STEPS, 4))
    before, *states = flown(VEHICLE, speed * np.array(velocity), spin * np.array(rate), thrusts, attitude)
    within_m = Reach(VEHICLE).within_tick_m(before.tolist())
    assert all((distances_m(before, corners(state)) <= within_m).all() for state in states)


def test_the_way_gained_is_that_of_all_rotors_and_weight_together():
    streamlined = replace(VEHICLE, drag_ns_per_m=0.0)
    *_, last = flown(streamlined, (0, 0, 0), (0, 0, 0), np.full((STEPS, 4), VEHICLE.max_thrust_n), INVERTED)
    assert -last[2] == pytest.approx(Reach(VEHICLE).gained_m, rel=1e-9)


def test_the_turn_gained_is_that_of_the_rotors_of_one_side():
    *_, last = flown(VEHICLE, (0, 0, 0), (0, 0, 0), np.full((STEPS, 4), VEHICLE.max_thrust_n) * (0, 1, 1, 0))
    assert 2.0 * math.asin(last[3]) == pytest.approx(Reach(VEHICLE).gained_rad, rel=1e-9)


def test_a_tumbling_body_gains_rate_without_torque_but_no_more_than_it_says():
    slender = replace(VEHICLE, inertia_kgm2=(0.005, 0.02, 0.024), drag_ns_per_m=0.0)
    states = flown(slender, (0, 0, 0), (0.01, 1.0, 0.01), np.zeros((4000, 4)))
    grown = max(float(np.linalg.norm(state[10:13])) for state in states)
    assert 1.2 < grown < Reach(slender).tumble


def test_a_rate_counts_with_all_that_it_may_grow_to():
    reach = Reach(replace(VEHICLE, inertia_kgm2=(0.005, 0.02, 0.024)))
    still_m, turning_m = (reach.within_tick_m((0.0,) * 10 + (0.0, rate, 0.0)) for rate in (0.0, 1.0))
    assert turning_m - still_m == pytest.approx(0.05 * reach.tumble * 0.5 * math.hypot(*VEHICLE.hull_m))


def test_a_turn_counts_only_until_no_turn_can_bring_the_hull_nearer():
    reach = Reach(VEHICLE)
    still, fast, faster = ((0.0,) * 10 + (0.0, 0.0, rate) for rate in (0.0, 30.0, 60.0))
    assert reach.within_tick_m(still) < reach.within_tick_m(fast) == reach.within_tick_m(faster)


@pytest.mark.parametrize("place", [7, 10])
def test_without_a_number_it_says_none_or_the_most(place):
    truth = [0.0] * STATE_SIZE
    truth[place] = math.nan
    within_m = Reach(VEHICLE).within_tick_m(truth)
    assert math.isnan(within_m) or within_m > Reach(VEHICLE).any_turn_m
