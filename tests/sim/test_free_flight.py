from __future__ import annotations

import numpy as np
import pybullet
import pytest
from hypothesis import given
from hypothesis import strategies as st

from scaloft_fi.sim import flight, stepper
from scaloft_fi.sim.build import VEHICLE_GROUP, WORLD_GROUP, connect, set_up
from scaloft_fi.sim.flight import fly
from scaloft_fi.sim.stepper import BLOCK
from scaloft_fi.sim.vehicle import KEPT_RATES, Airframe, attitude_of, free_step
from scaloft_fi.stack.declaration import PlainWire
from tests.sim.test_compiled_stepper import reference

pytestmark = pytest.mark.flight


@pytest.fixture(scope="module")
def client():
    client = connect()
    set_up(client)
    yield client
    pybullet.disconnect(physicsClientId=client)


def computed_step(airframe, drive, step):
    """`Airframe.step` for one step, outside the server."""
    inverse = airframe.inverse_attitude()
    drive(step)
    square = free_step(airframe.state, inverse, airframe.pushed, airframe.inertia)
    airframe.update_server()
    return square


def thrown(client, yaw_rad, pushes, computed):
    """A block under `pushes` (T, 6); the bits of its state after each step, those `computed` outside the server."""
    airframe = Airframe(client, BLOCK, (0.1, -0.2, 5.0), yaw_rad)
    states = []

    def drive(step):
        airframe.pushed[:] = pushes[step]

    for step in range(len(pushes)):
        top_square = computed_step(airframe, drive, step) if computed[step] else airframe.step(drive, step, 1)
        states.append((airframe.state.tobytes(), airframe.truth, top_square))
    pybullet.removeBody(airframe.number, physicsClientId=client)
    return states


@given(
    yaw_rad=st.floats(-4.0, 4.0),
    seed=st.integers(0, 2**31),
    size=st.sampled_from([0.0, 1e-6, 0.1, 10.0, 1e5]),
    computed=st.lists(st.booleans(), min_size=1, max_size=60),
)
def test_a_step_outside_the_server_has_the_bits_of_one_inside(client, yaw_rad, seed, size, computed):
    pushes = size * np.random.default_rng(seed).normal(0.0, (1, 1, 1, 0.05, 0.05, 0.05), (len(computed), 6))
    inside = thrown(client, yaw_rad, pushes, [False] * len(computed))
    assert thrown(client, yaw_rad, pushes, computed) == inside
    assert thrown(client, yaw_rad, pushes, [True] * len(computed)) == inside


def test_speeds_end_where_the_server_ends_them(client):
    pushes = np.tile([1e6, -1e6, 0.0, 1e3, 0.0, -1e3], (20, 1))
    inside = thrown(client, 0.3, pushes, [False] * 20)
    assert thrown(client, 0.3, pushes, [True] * 20) == inside
    assert max(inside[-1][1][7:10]) == 100.0


def test_the_hidden_attitude_is_known_through_touches_too(client):
    """A block that falls on a slab, bounces and tumbles, longer than rates are kept."""
    slab = pybullet.createMultiBody(
        0.0,
        pybullet.createCollisionShape(pybullet.GEOM_BOX, halfExtents=[9.0, 9.0, 0.5], physicsClientId=client),
        physicsClientId=client,
    )
    pybullet.setCollisionFilterGroupMask(slab, -1, WORLD_GROUP, VEHICLE_GROUP, physicsClientId=client)
    airframe = Airframe(client, BLOCK, (0.0, 0.0, 0.9), 0.4)
    touched, told = 0, np.empty(4)

    def drive(step):
        airframe.pushed[:] = 0.0, 0.0, 0.0, 0.05 * (step < 90), 0.02, 0.0

    for step in range(KEPT_RATES + 100):
        airframe.step(drive, step, 1)
        touched += bool(pybullet.getContactPoints(airframe.number, slab, physicsClientId=client))
        if step % 50 == 0:
            attitude_of(airframe.inverse_attitude(), told)
            assert told.tobytes() == airframe.state[3:7].tobytes(), step
    assert touched > 100
    pybullet.removeBody(airframe.number, physicsClientId=client)
    pybullet.removeBody(slab, physicsClientId=client)


def test_it_agrees_with_the_server_here():
    assert stepper.agrees()


def test_another_arithmetic_is_noticed(monkeypatch):
    def rounded(state, turned, pushed, inertia):
        free_step(state, turned, pushed, inertia)
        state[0] = np.nextafter(state[0], np.inf)

    monkeypatch.setattr(stepper, "free_step", rounded)
    assert not stepper.agrees.__wrapped__()


def test_without_agreement_a_flight_is_the_servers_and_the_same(monkeypatch):
    config = reference()
    situation = config.grid.situation("T0O0W0D0H0")
    asked = []

    def flown(answer):
        monkeypatch.setattr(flight, "agrees", lambda: asked.append(answer) or answer)
        return fly(config, situation, 1, PlainWire())

    with_it, without = flown(True), flown(False)
    assert (with_it.digest, with_it.perceived_digest) == (without.digest, without.perceived_digest)
    assert set(asked) == {True, False}
