from __future__ import annotations

import math

import numpy as np
import pybullet
import pytest
from effort import usually
from hypothesis import given, settings
from hypothesis import strategies as st

from scaloft_fi.sim.build import build, connect
from scaloft_fi.sim.contact import Clearances, moved_m
from scaloft_fi.sim.load import load
from scaloft_fi.sim.vehicle import spawn
from tests.sim.conftest import SIM

pytestmark = pytest.mark.flight

CONFIG = load(SIM)
SCENARIO = CONFIG.scenario(CONFIG.grid.situation("T1O1W1D0H1"))


@pytest.fixture(scope="module")
def placed():
    """Puts a vehicle somewhere; returns its pose, its clearances, and a way to ask the server for them plainly."""
    client = connect()
    ids = build(client, SCENARIO.world)
    body = spawn(client, CONFIG.vehicle, (0, 4, 1.65), 0.0)

    def put(position, turn):
        attitude = pybullet.getQuaternionFromEuler(turn)
        pybullet.resetBasePositionAndOrientation(body, position, attitude, physicsClientId=client)
        return (*position, *attitude)

    def plainly(name):
        points = pybullet.getClosestPoints(body, ids.by_name[name], 1.0, physicsClientId=client)
        return min((point[8] for point in points), default=1.0)

    def clearances():
        return Clearances(client, ids, body, CONFIG.vehicle, SCENARIO.world)

    yield put, clearances, plainly, tuple(ids.by_name)
    pybullet.disconnect(physicsClientId=client)


steps = st.tuples(
    st.tuples(st.floats(-0.3, 0.3), st.floats(-0.3, 0.3), st.floats(-0.2, 0.2)), st.tuples(*[st.floats(-0.6, 0.6)] * 3)
)


@settings(max_examples=usually(25, release=300))
@given(
    start=st.tuples(st.floats(-1.5, 1.5), st.floats(0.0, 8.0), st.floats(0.3, 2.4)), ways=st.lists(steps, max_size=8)
)
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


def test_a_second_question_is_asked_of_a_server_that_moved_the_vehicle_unseen(placed):
    put, clearances, plainly, _ = placed
    asked = clearances()
    asked.look(put((0.0, 4.0, 0.2), (0.0, 0.0, 0.0)))
    near_m = asked.measure("ground")
    asked.look(put((0.0, 4.0, 0.2), (0.0, 0.0, 0.0)))
    put((0.0, 4.0, 0.8), (0.0, 0.0, 0.0))
    assert asked.measure("ground") == plainly("ground") > near_m + 0.5


def test_a_surface_that_is_not_there_is_far(placed):
    put, clearances, _, _ = placed
    asked = clearances()
    asked.look(put((0.0, 4.0, 1.0), (0.0, 0.0, 0.0)))
    assert asked.measure("nothing") == 1.0


@given(
    place=st.tuples(*[st.floats(-1.0, 1.0)] * 3),
    turns=st.tuples(*[st.floats(-3.0, 3.0)] * 6),
    point=st.tuples(*[st.floats(-1.0, 1.0)] * 3),
)
def test_no_point_within_the_radius_moved_farther(place, turns, point):
    before, after = (pybullet.getQuaternionFromEuler(turn) for turn in (turns[:3], turns[3:]))
    was = np.reshape(pybullet.getMatrixFromQuaternion(before), (3, 3)) @ point
    now = np.reshape(pybullet.getMatrixFromQuaternion(after), (3, 3)) @ point + place
    most_m = moved_m((0.0, 0.0, 0.0, *before), (*place, *after), math.hypot(*point))
    assert float(np.linalg.norm(now - was)) <= most_m + 1e-6
