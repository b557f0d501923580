from __future__ import annotations

import math

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from scaloft_fi.sim.build import GRAVITY_MPS2
from scaloft_fi.sim.vehicle import STATE_SIZE, actuate, rotor_step, wrench
from scaloft_fi.stack.declaration import STEP_S

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
    for rotor, (x, y) in enumerate(config.vehicle.rotors_m):
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
    arms = np.column_stack([config.vehicle.rotors_m, np.zeros(4)])
    body_torque = np.cross(arms, np.outer(thrust, (0, 0, 1))).sum(axis=0)
    body_torque[2] += 0.06 * thrust @ config.vehicle.spins
    assert np.allclose(force, turn @ (0, 0, thrust.sum()) - config.vehicle.drag_ns_per_m * np.array(velocity))
    assert np.allclose(torque, turn @ body_torque)


@given(thrusts, thrusts, units, st.tuples(*[st.floats(-3, 3)] * 3))
def test_actuating_is_turning_the_rotors_and_then_pushing(config, before, order, attitude, velocity):
    vehicle, state, pushed_by = config.vehicle, still(attitude, velocity), np.empty(6)
    after, plain = before.copy(), before.copy()
    actuate(after, order, vehicle.lag(), vehicle.effect(), state, pushed_by)
    rotor_step.py_func(plain, order, vehicle.lag())
    force, torque = np.empty(3), np.empty(3)
    wrench.py_func(plain, state, vehicle.effect(), force, torque)
    assert np.array_equal(after, plain)
    assert np.array_equal(pushed_by, np.concatenate([force, torque]))


def test_thrust_to_weight_is_that_of_the_vehicle(config):
    ratio = 4 * config.vehicle.max_thrust_n / (config.vehicle.mass_kg * GRAVITY_MPS2)
    assert math.isclose(ratio, 2.75, rel_tol=0.03)
