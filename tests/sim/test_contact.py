"""Contacts, clearances, and how soon the vehicle could touch something, beside the server's plain answers."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import product

import numpy as np
import pybullet
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from options import usually

from scaloft_fi.sim.build import build, physics_server
from scaloft_fi.sim.contact import Clearances, Feeler, Reach, contacts, moved_m
from scaloft_fi.sim.load import load
from scaloft_fi.sim.observer import Observer
from scaloft_fi.sim.vehicle import STATE_SIZE, Airframe, free_step, inertia_of, spawn, wrench
from tests.sim.conftest import SIM, state_at, turned_by

CONFIG = load(SIM)
VEHICLE, HULL_M = CONFIG.vehicle, np.array(CONFIG.vehicle.hull_m)
UPRIGHT, INVERTED = (0.0, 0.0, 0.0, 1.0), (1.0, 0.0, 0.0, 0.0)
STEPS = 12


@pytest.mark.flight
@pytest.mark.parametrize(
    ("position", "velocity", "spin"),
    [
        ((-0.5, 2.2, 0.9), (0.0, 2.0, 0.5), (3.0, 0.0, 8.0)),  # into the person
        ((0.0, 4.0, 1.0), (5.0, 0.0, 1.0), (0.0, 9.0, 0.0)),  # into the wall
        ((0.0, 1.0, 0.6), (0.0, 0.5, -1.0), (5.0, 5.0, 0.0)),  # onto the ground near home
    ],
)
def test_feeling_only_where_something_is_near_finds_every_touch(client, scenario, position, velocity, spin):
    flown = scenario("T1O1W0D0H1")
    ids, airframe = build(client, flown.world), Airframe(client, VEHICLE, position, 0.0)
    pybullet.resetBaseVelocity(airframe.number, velocity, spin, physicsClientId=client)
    airframe.read()
    observer = Observer(client, ids, airframe.number, VEHICLE, flown, flown.world.surroundings())
    feeler = Feeler(client, airframe.number, VEHICLE, ids.name_of)
    felt = []
    for step in range(240):
        if step % 12 == 0:
            observer.sample(step / 240, airframe.state, None)
            feeler.look(airframe.truth, observer.room_m)
        airframe.step(lambda _step: airframe.actuate(np.zeros(4)), 0, 1)
        touches = feeler.feel(airframe.truth, airframe.state)
        assert touches == contacts(client, airframe.number, ids.name_of, airframe.state, VEHICLE.half_height_m)
        observer.step((step + 1) / 240, airframe.truth, touches)
        felt += touches
        assert not (feeler.out_of_reach and touches)
    assert felt


@pytest.mark.flight
def test_it_asks_again_once_the_vehicle_may_have_come_near(client):
    feeler, state = Feeler(-1, 0, VEHICLE, {}), state_at((0, 4, 1.65))
    free_m = 1.0 - 0.5 * math.hypot(*VEHICLE.hull_m) + 0.5 * min(VEHICLE.hull_m) - 0.05
    feeler.look(state.tolist(), 1.0)
    assert feeler.feel((0.0, 4.0 + free_m - 1e-6, 1.65), state) == ()
    for place in ((0.0, 4.0 + free_m + 1e-6, 1.65), (math.nan, 4.0, 1.65)):
        with pytest.raises(Exception, match="Not connected"):
            feeler.feel(place, state)


@pytest.mark.parametrize(
    ("motion", "room_m", "out_of_reach"),
    [
        ({"velocity": (0.0, 0.5, 0.0)}, 1.0, True),
        ({"velocity": (0.0, 20.0, 0.0)}, 1.0, False),
        ({"velocity": (0.0, math.nan, 0.0)}, 1.0, False),
        ({"rate": (0.0, 0.0, math.nan)}, 0.3, False),
        ({}, 0.1, False),
        ({}, 0.2, True),
        ({"rate": (0.0, 0.0, 8.0)}, 0.2, False),
    ],
)
def test_near_fast_or_whirling_it_may_touch_something_within_a_tick(motion, room_m, out_of_reach):
    feeler = Feeler(-1, 0, VEHICLE, {})
    feeler.look(state_at((0, 4, 1.65), **motion).tolist(), room_m)
    assert feeler.out_of_reach is out_of_reach


@pytest.fixture(scope="module")
def placed():
    """Puts a vehicle somewhere; returns its pose, its clearances, and a way to ask the server for them plainly."""
    world = CONFIG.scenario(CONFIG.grid.situation("T1O1W1D0H1")).world
    with physics_server() as client:
        ids, body = build(client, world), spawn(client, VEHICLE, (0, 4, 1.65), 0.0)

        def put(position, turn=(0.0, 0.0, 0.0)):
            attitude = pybullet.getQuaternionFromEuler(turn)
            pybullet.resetBasePositionAndOrientation(body, position, attitude, physicsClientId=client)
            return (*position, *attitude)

        def plainly(name):
            points = pybullet.getClosestPoints(body, ids.by_name[name], 1.0, physicsClientId=client)
            return min((point[8] for point in points), default=1.0)

        yield put, lambda: Clearances(client, ids, body, VEHICLE, world), plainly, tuple(ids.by_name)


step_of = st.tuples(
    st.tuples(st.floats(-0.3, 0.3), st.floats(-0.3, 0.3), st.floats(-0.2, 0.2)), st.tuples(*[st.floats(-0.6, 0.6)] * 3)
)


@pytest.mark.flight
@settings(max_examples=usually(25, release=300))
@given(st.tuples(st.floats(-1.5, 1.5), st.floats(0.0, 8.0), st.floats(0.3, 2.4)), st.lists(step_of, max_size=8))
def test_asking_no_farther_than_needed_finds_what_asking_as_far_as_counts_finds(placed, start, ways):
    put, clearances, plainly, names = placed
    asked, place, turn = clearances(), np.array(start), np.zeros(3)
    for way, tilt in [((0.0,) * 3, (0.0,) * 3), *ways]:
        place, turn = place + way, turn + tilt
        asked.look(put(place.tolist(), turn.tolist()))
        for name in names:
            clearance_m = plainly(name)
            assert asked.measure(name) == clearance_m
            assert clearance_m <= 0.0 or clearance_m == 1.0 or asked.gaps_m[name] <= clearance_m + 2e-3


@pytest.mark.flight
def test_a_second_question_is_asked_of_a_server_that_moved_the_vehicle_unseen_and_what_is_not_there_is_far(placed):
    put, clearances, plainly, _ = placed
    asked = clearances()
    asked.look(put((0.0, 4.0, 0.2)))
    near_m = asked.measure("ground")
    asked.look(put((0.0, 4.0, 0.2)))
    put((0.0, 4.0, 0.8))
    assert asked.measure("ground") == plainly("ground") > near_m + 0.5
    assert asked.measure("nothing") == 1.0


vectors = st.tuples(*[st.floats(-1.0, 1.0)] * 3)


@given(vectors, st.tuples(*[st.floats(-3.0, 3.0)] * 6), vectors)
def test_no_point_within_the_radius_moved_farther(place, turns, point):
    before, after = (pybullet.getQuaternionFromEuler(turn) for turn in (turns[:3], turns[3:]))
    moved = turned_by(after) @ point + place - turned_by(before) @ point
    most_m = moved_m((0.0, 0.0, 0.0, *before), (*place, *after), math.hypot(*point))
    assert float(np.linalg.norm(moved)) <= most_m + 1e-6


def corners(state):
    """Of the hull, (8, 3) [m]."""
    return state[:3] + 0.5 * np.array(list(product((-1.0, 1.0), repeat=3))) * HULL_M @ turned_by(state[3:7]).T


def distances_m(state, points):
    """From the hull to each of `points` (N, 3) [m]."""
    local = (points - state[:3]) @ turned_by(state[3:7])
    return np.linalg.norm(np.maximum(np.abs(local) - 0.5 * HULL_M, 0.0), axis=1)


def flown(vehicle, thrusts, velocity=(0, 0, 0), rate=(0, 0, 0), attitude=UPRIGHT):
    """States before and after each of the steps under `thrusts` (T, 4) [N]."""
    state, turned, pushed = state_at((0, 0, 0), attitude, velocity, rate), np.array(attitude), np.zeros(6)
    turned[:3] *= -1.0
    states = [state.copy()]
    for thrust in thrusts:
        wrench(np.asarray(thrust, float), state, vehicle.effect(), pushed[:3], pushed[3:])
        free_step(state, turned, pushed, inertia_of(vehicle))
        states.append(state.copy())
    return states


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
    before, *states = flown(VEHICLE, thrusts, speed * np.array(velocity), spin * np.array(rate), attitude)
    within_m = Reach(VEHICLE).within_tick_m(before.tolist())
    assert all((distances_m(before, corners(state)) <= within_m).all() for state in states)


def test_way_and_turn_gained_are_those_of_all_rotors_and_weight_of_the_rotors_of_one_side_and_of_the_wind():
    most, reach = np.full((STEPS, 4), VEHICLE.max_thrust_n), Reach(VEHICLE)
    *_, fallen = flown(replace(VEHICLE, drag_ns_per_m=0.0), most, attitude=INVERTED)
    *_, turned = flown(VEHICLE, most * (0, 1, 1, 0))
    assert [-fallen[2], 2.0 * math.asin(turned[3])] == pytest.approx([reach.gained_m, reach.gained_rad], rel=1e-9)
    windy = Reach(VEHICLE, 10.0)
    by_wind_m = 0.05**2 * 13 / 24 * VEHICLE.drag_ns_per_m * 10.0 / VEHICLE.mass_kg
    assert (windy.gained_m - reach.gained_m, windy.gained_rad) == (pytest.approx(by_wind_m), reach.gained_rad)


def test_a_tumbling_body_gains_rate_without_torque_but_no_more_than_it_says_and_all_of_it_counts():
    slender = replace(VEHICLE, inertia_kgm2=(0.005, 0.02, 0.024), drag_ns_per_m=0.0)
    states, reach = flown(slender, np.zeros((4000, 4)), rate=(0.01, 1.0, 0.01)), Reach(slender)
    assert 1.2 < max(float(np.linalg.norm(state[10:13])) for state in states) < reach.tumble
    still_m, turning_m = (reach.within_tick_m(state_at(rate=(0.0, rate, 0.0)).tolist()) for rate in (0.0, 1.0))
    assert turning_m - still_m == pytest.approx(0.05 * reach.tumble * 0.5 * math.hypot(*VEHICLE.hull_m))


def test_a_turn_counts_only_until_no_turn_can_bring_the_hull_nearer():
    still, fast, faster = (Reach(VEHICLE).within_tick_m(state_at(rate=(0, 0, z)).tolist()) for z in (0.0, 30.0, 60.0))
    assert still < fast == faster


@pytest.mark.parametrize("place", [7, 10])
def test_without_a_number_it_says_none_or_the_most(place):
    truth = [math.nan if k == place else 0.0 for k in range(STATE_SIZE)]
    within_m = Reach(VEHICLE).within_tick_m(truth)
    assert math.isnan(within_m) or within_m > Reach(VEHICLE).any_turn_m
