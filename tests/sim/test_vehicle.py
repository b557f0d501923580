"""Rotors and pushes of the vehicle, and its body in the physics server."""

from __future__ import annotations

import math

import numpy as np
import pybullet
import pytest
from hypothesis import given
from hypothesis import strategies as st

from scaloft_fi.sim.build import GRAVITY_MPS2, build
from scaloft_fi.sim.vehicle import Airframe, rotor_step, wrench
from scaloft_fi.stack.declaration import STEP_S
from tests.sim.conftest import state_at, turned_by

thrusts = st.tuples(*[st.floats(0, 10.35)] * 4).map(np.array)
units = st.tuples(*[st.floats(-1, 1)] * 4).filter(lambda q: np.linalg.norm(q) > 0.1).map(np.array)
velocities = st.tuples(*[st.floats(-3, 3)] * 3)


def pushed(vehicle, thrust, state):
    force, torque = np.empty(3), np.empty(3)
    wrench(thrust, state, vehicle.effect(), force, torque)
    return force, torque


@given(thrusts, thrusts, st.tuples(*[st.floats(allow_nan=True, allow_infinity=True)] * 4).map(np.array))
def test_rotors_approach_their_order_without_passing_it_within_their_limits_whatever_is_ordered(
    config, before, order, wild
):
    after = before.copy()
    rotor_step(after, order, config.vehicle.lag())
    assert np.all((after - before) * (order - after) >= -1e-12)
    for _ in range(5):
        rotor_step(before, wild, config.vehicle.lag())
    assert np.all((before >= 0) & (before <= config.vehicle.max_thrust_n))


def test_rotors_have_the_published_time_constants_and_thrust_to_weight(config):
    up, down = np.zeros(4), np.full(4, 10.0)
    for _ in range(3):
        rotor_step(up, np.full(4, 10.0), config.vehicle.lag())
        rotor_step(down, np.zeros(4), config.vehicle.lag())
    assert np.allclose(up, 10 * (1 - math.exp(-3 * STEP_S / 0.0125)))
    assert np.allclose(down, 10 * math.exp(-3 * STEP_S / 0.025))
    assert 4 * config.vehicle.max_thrust_n / (config.vehicle.mass_kg * GRAVITY_MPS2) == pytest.approx(2.75, rel=0.03)


@given(thrusts, units, velocities)
def test_the_wrench_is_the_body_wrench_turned_into_the_world(config, thrust, attitude, velocity):
    state = state_at(attitude=attitude, velocity=velocity)
    force, torque = pushed(config.vehicle, thrust, state)
    arms = np.column_stack([config.vehicle.rotors_m, np.zeros(4)])
    body_torque = np.cross(arms, np.outer(thrust, (0, 0, 1))).sum(axis=0)
    body_torque[2] += 0.06 * thrust @ config.vehicle.spins
    turn = turned_by(state[3:7])
    assert np.allclose(force, turn @ (0, 0, thrust.sum()) - config.vehicle.drag_ns_per_m * np.array(velocity))
    assert np.allclose(torque, turn @ body_torque)


@pytest.fixture
def fly(client, config):
    """The states of steps under a thrust, the first included."""

    def flown(steps, thrust, spin=(0, 0, 0), wind_mps=(0.0, 0.0, 0.0)):
        build(client, config.world)
        airframe = Airframe(client, config.vehicle, (0, 4, 1.5), 0.3)
        pybullet.resetBaseVelocity(airframe.number, [0, 0, 0], spin, physicsClientId=client)
        airframe.thrusts[:] = thrust
        airframe.blow(np.array(wind_mps))
        airframe.read()
        states = [airframe.state.copy()]
        for _ in range(steps):
            airframe.step(lambda _step: airframe.actuate(thrust), 0, 1)
            states.append(airframe.state.copy())
            assert np.array_equal(airframe.truth, airframe.state)
        return np.array(states)

    return flown


@pytest.fixture
def hover(config):
    return np.full(4, config.vehicle.mass_kg * GRAVITY_MPS2 / 4)


@pytest.mark.flight
def test_it_starts_where_it_is_told_and_falls_without_thrust_as_gravity_and_drag_say(fly, config):
    states = fly(96, np.zeros(4))
    assert np.allclose(states[0], [0, 4, 1.5, 0, 0, math.sin(0.15), math.cos(0.15), 0, 0, 0, 0, 0, 0])
    t, k = 96 * STEP_S, config.vehicle.drag_ns_per_m / config.vehicle.mass_kg
    assert math.isclose(states[-1, 9], -GRAVITY_MPS2 / k * (1 - math.exp(-k * t)), rel_tol=1e-3)
    assert np.allclose(states[-1, 3:7], states[0, 3:7])


@pytest.mark.flight
def test_with_its_weight_in_thrust_it_stays_and_nothing_but_the_rotors_turns_it(fly, config, hover):
    states, free = fly(240, hover), fly(240, hover, spin=[0, 0, 1.0])
    assert np.allclose(states[-1], states[0], atol=1e-9)
    assert np.allclose(free[-1, 10:13], (0, 0, 1))
    turned = fly(48, hover + 0.1 * np.array(config.vehicle.spins))
    expected = 0.06 * 0.4 / config.vehicle.inertia_kgm2[2] * 48 * STEP_S
    assert np.allclose(turned[-1, 10:13], (0, 0, expected), atol=1e-9)


@pytest.mark.flight
def test_wind_carries_it_along_as_fast_as_the_drag_lets_it(fly, config, hover):
    states = fly(240, hover, wind_mps=(0.4, -0.2, 0.1))
    share = 1 - math.exp(-config.vehicle.drag_ns_per_m / config.vehicle.mass_kg * 240 * STEP_S)
    assert states[-1, 7:10] == pytest.approx(np.array((0.4, -0.2, 0.1)) * share, rel=1e-2)
