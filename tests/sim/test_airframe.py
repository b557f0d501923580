from __future__ import annotations

import math

import numpy as np
import pytest

from scaloft_fi.sim.build import GRAVITY_MPS2, build
from scaloft_fi.sim.vehicle import Airframe
from scaloft_fi.stack.declaration import STEP_S

pytestmark = pytest.mark.flight


def fly(client, config, steps, thrust, spin=None, wind_mps=(0.0, 0.0, 0.0)):
    import pybullet

    build(client, config.world)
    airframe = Airframe(client, config.vehicle, (0, 4, 1.5), 0.3)
    if spin is not None:
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


def test_without_thrust_it_falls_as_gravity_and_drag_say(client, config):
    states = fly(client, config, 96, np.zeros(4))
    t, k = 96 * STEP_S, config.vehicle.drag_ns_per_m / config.vehicle.mass_kg
    assert math.isclose(states[-1, 9], -GRAVITY_MPS2 / k * (1 - math.exp(-k * t)), rel_tol=1e-3)
    assert np.allclose(states[-1, 3:7], states[0, 3:7])


def test_with_its_weight_in_thrust_it_stays(client, config):
    states = fly(client, config, 240, np.full(4, config.vehicle.mass_kg * GRAVITY_MPS2 / 4))
    assert np.allclose(states[-1], states[0], atol=1e-9)


def test_nothing_but_the_rotors_turns_it(client, config):
    vehicle = config.vehicle
    thrust = np.full(4, vehicle.mass_kg * GRAVITY_MPS2 / 4) + 0.1 * np.array(vehicle.spins)
    states = fly(client, config, 48, thrust)
    expected = 0.06 * 0.4 / vehicle.inertia_kgm2[2] * 48 * STEP_S
    assert np.allclose(states[-1, 10:13], (0, 0, expected), atol=1e-9)
    free = fly(client, config, 240, np.full(4, vehicle.mass_kg * GRAVITY_MPS2 / 4), spin=[0, 0, 1.0])
    assert np.allclose(free[-1, 10:13], (0, 0, 1))


def test_it_starts_where_and_as_it_is_told(client, config):
    states = fly(client, config, 0, np.zeros(4))
    assert np.allclose(states[0], [0, 4, 1.5, 0, 0, math.sin(0.15), math.cos(0.15), 0, 0, 0, 0, 0, 0])


def test_wind_carries_it_along_as_fast_as_the_drag_lets_it(client, config):
    hover = np.full(4, config.vehicle.mass_kg * GRAVITY_MPS2 / 4)
    states = fly(client, config, 240, hover, wind_mps=(0.4, -0.2, 0.1))
    share = 1 - math.exp(-config.vehicle.drag_ns_per_m / config.vehicle.mass_kg * 240 * STEP_S)
    assert states[-1, 7:10] == pytest.approx(np.array((0.4, -0.2, 0.1)) * share, rel=1e-2)
    calm = fly(client, config, 240, hover)
    assert np.array_equal(calm, fly(client, config, 240, hover, wind_mps=(0.0, 0.0, 0.0)))
