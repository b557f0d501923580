from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from scaloft_fi.sim.build import GRAVITY_MPS2, STEP_S, build
from scaloft_fi.sim.vehicle import STATE_SIZE, push, read_state, rotor_step, spawn, wrench

thrusts = st.tuples(*[st.floats(0, 10.35)] * 4).map(np.array)
units = st.tuples(*[st.floats(-1, 1)] * 4).filter(lambda q: np.linalg.norm(q) > 0.1).map(np.array)


def still(attitude=(0, 0, 0, 1), velocity=(0, 0, 0)):
    state = np.zeros(STATE_SIZE)
    state[3:7] = np.array(attitude) / np.linalg.norm(attitude)
    state[7:10] = velocity
    return state


def pushed(config, thrust, state):
    force, torque = np.empty(3), np.empty(3)
    wrench(thrust, state, config.vehicle.effect(), force, torque)
    return force, torque


@given(thrusts, thrusts)
def test_rotors_approach_their_order_without_passing_it(config, before, order):
    after = before.copy()
    rotor_step(after, order, config.vehicle.lag())
    assert np.all((after - before) * (order - after) >= -1e-12)


@given(thrusts, st.tuples(*[st.floats(allow_nan=True, allow_infinity=True)] * 4).map(np.array))
def test_rotors_stay_within_their_limits_whatever_is_ordered(config, before, order):
    for _ in range(5):
        rotor_step(before, order, config.vehicle.lag())
    assert np.all((before >= 0) & (before <= config.vehicle.max_thrust_n))


def test_rotors_have_the_published_time_constants(config):
    up, down = np.zeros(4), np.full(4, 10.0)
    for _ in range(3):
        rotor_step(up, np.full(4, 10.0), config.vehicle.lag())
    for _ in range(6):
        rotor_step(down, np.zeros(4), config.vehicle.lag())
    assert np.allclose(up, 10 * (1 - math.exp(-3 * STEP_S / 0.0125)))
    assert np.allclose(down, 10 * math.exp(-6 * STEP_S / 0.025))


def test_each_rotor_lifts_and_turns_about_its_arm(config):
    for rotor, (x, y) in enumerate(config.vehicle.rotors):
        force, torque = pushed(config, np.eye(4)[rotor], still())
        assert np.allclose(force, (0, 0, 1))
        assert np.allclose(torque, (y, -x, 0.06 * config.vehicle.spins[rotor]))


@given(thrusts, units, st.tuples(*[st.floats(-3, 3)] * 3))
def test_the_wrench_is_the_body_wrench_turned_into_the_world(config, thrust, attitude, velocity):
    state = still(attitude, velocity)
    force, torque = pushed(config, thrust, state)
    x, y, z, w = state[3:7]
    turn = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
    arms = np.column_stack([config.vehicle.rotors, np.zeros(4)])
    body_torque = np.cross(arms, np.outer(thrust, (0, 0, 1))).sum(axis=0)
    body_torque[2] += 0.06 * thrust @ config.vehicle.spins
    assert np.allclose(force, turn @ (0, 0, thrust.sum()) - config.vehicle.drag * np.array(velocity))
    assert np.allclose(torque, turn @ body_torque)


def test_thrust_to_weight_is_that_of_the_vehicle(config):
    ratio = 4 * config.vehicle.max_thrust_n / (config.vehicle.mass_kg * GRAVITY_MPS2)
    assert math.isclose(ratio, 2.75, rel_tol=0.03)


def fly(client, config, steps, thrust, spin=None):
    import pybullet

    build(client, config.world)
    body = spawn(client, config.vehicle, (0, 4, 1.5), 0.3)
    if spin is not None:
        pybullet.resetBaseVelocity(body, [0, 0, 0], spin, physicsClientId=client)
    state, force, torque = np.empty(STATE_SIZE), np.empty(3), np.empty(3)
    read_state(client, body, state)
    states = [state.copy()]
    for _ in range(steps):
        wrench(thrust, state, config.vehicle.effect(), force, torque)
        push(client, body, state, force, torque)
        pybullet.stepSimulation(physicsClientId=client)
        read_state(client, body, state)
        states.append(state.copy())
    return np.array(states)


@pytest.mark.flight
def test_without_thrust_it_falls_as_gravity_and_drag_say(client, config):
    states = fly(client, config, 96, np.zeros(4))
    t, k = 96 * STEP_S, config.vehicle.drag / config.vehicle.mass_kg
    assert math.isclose(states[-1, 9], -GRAVITY_MPS2 / k * (1 - math.exp(-k * t)), rel_tol=1e-3)
    assert np.allclose(states[-1, 3:7], states[0, 3:7])


@pytest.mark.flight
def test_with_its_weight_in_thrust_it_stays(client, config):
    states = fly(client, config, 240, np.full(4, config.vehicle.mass_kg * GRAVITY_MPS2 / 4))
    assert np.allclose(states[-1], states[0], atol=1e-9)


@pytest.mark.flight
def test_nothing_but_the_rotors_turns_it(client, config):
    vehicle = config.vehicle
    thrust = np.full(4, vehicle.mass_kg * GRAVITY_MPS2 / 4) + 0.1 * vehicle.spins
    states = fly(client, config, 48, thrust)
    expected = 0.06 * 0.4 / vehicle.inertia[2] * 48 * STEP_S
    assert np.allclose(states[-1, 10:13], (0, 0, expected), atol=1e-9)
    free = fly(client, config, 240, np.full(4, vehicle.mass_kg * GRAVITY_MPS2 / 4), spin=[0, 0, 1.0])
    assert np.allclose(free[-1, 10:13], (0, 0, 1))


@pytest.mark.flight
def test_it_starts_where_and_as_it_is_told(client, config):
    states = fly(client, config, 0, np.zeros(4))
    assert np.allclose(states[0], [0, 4, 1.5, 0, 0, math.sin(0.15), math.cos(0.15), 0, 0, 0, 0, 0, 0])
