"""Bodies that move, as camera, oracle and physics server see them, beside plain geometry."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pybullet
import pytest
from effort import usually
from hypothesis import given, settings
from hypothesis import strategies as st

from scaloft_fi.sim.build import build, connect, place
from scaloft_fi.sim.contact import Clearances
from scaloft_fi.sim.load import SimConfig, load
from scaloft_fi.sim.observer import Observer
from scaloft_fi.sim.sensors.camera import look
from scaloft_fi.sim.vehicle import STATE_SIZE, spawn
from tests.sim.test_raster import CAMERA, UPRIGHT, cast

pytestmark = pytest.mark.flight

SIM = Path(__file__).parents[2] / "sim"
KEY = "T0O0W0D0H1"
WALK = "{kind: walk, active: true, body: person, path: [[-0.5, 6.0], [0.9, 6.0], [0.9, 1.0]], speed_mps: 1.0}"
times_s = st.floats(0.0, 12.0)


@pytest.fixture(scope="module")
def scenario(config: SimConfig):
    return lambda: config.scenario(config.grid.situation(KEY))


@pytest.fixture(scope="module")
def config(tmp_path_factory: pytest.TempPathFactory) -> SimConfig:
    import shutil

    study = Path(shutil.copytree(SIM, tmp_path_factory.mktemp("study") / "sim"))
    with (study / "world.yaml").open("a") as file:
        file.write(f"\nhappenings: {{walk: {WALK.replace('active: true', 'active: false')}}}\n")
    text = (study / "situations.yaml").read_text()
    set_ = "set: {bodies.person.present: true, happenings.walk.active: true}"
    (study / "situations.yaml").write_text(text.replace("set: {bodies.person.present: true}", set_))
    return load(study)


@pytest.fixture(scope="module")
def server(config: SimConfig):
    client = connect()
    scenario = config.scenario(config.grid.situation(KEY))
    ids = build(client, scenario.world)
    body = spawn(client, scenario.vehicle, (0.0, 4.0, 1.65), 0.0)
    yield lambda: (client, ids, body, scenario)  # a function, because Hypothesis prints arguments
    pybullet.disconnect(physicsClientId=client)


@settings(max_examples=25)
@given(now_s=times_s, yaw=st.floats(-math.pi, math.pi))
def test_the_rasteriser_agrees_with_ray_casting_wherever_the_person_walks(scenario, now_s, yaw) -> None:
    around = scenario().world.surroundings()
    around.update(now_s, 0.0, 0.0)
    attitude = np.array([0.0, 0.0, math.sin(yaw / 2), math.cos(yaw / 2)])
    place_m = np.array([0.0, 3.5, 1.2])
    view = look(around.scene, CAMERA, place_m, attitude)
    depth, segments = cast(around.scene, CAMERA, place_m, attitude)
    same = view.segments == segments
    assert same.mean() > 0.995  # an edge may fall between two pixels
    assert np.allclose(view.depth[same], depth[same], rtol=1e-6)


@settings(max_examples=usually(25, release=60))
@given(now_s=times_s, x=st.floats(-1.0, 1.0), y=st.floats(0.5, 6.5), z=st.floats(0.4, 2.2))
def test_the_oracles_clearance_is_the_servers_wherever_the_person_walks(server, now_s, x, y, z) -> None:
    client, ids, body, scenario = server()
    around = scenario.world.surroundings()
    asked = Clearances(client, ids, body, scenario.vehicle, scenario.world)
    for t_s in (now_s, now_s + 0.05):
        around.update(t_s, x, y)
        place(client, ids, around.shifts)
        pybullet.resetBasePositionAndOrientation(body, (x, y, z), UPRIGHT, physicsClientId=client)
        asked.look((x, y, z, *UPRIGHT), around.shifts)
        points = pybullet.getClosestPoints(body, ids.by_name["person"], 1.0, physicsClientId=client)
        clearance_m = min((point[8] for point in points), default=1.0)
        assert asked.measure("person") == clearance_m
        assert clearance_m <= 0.0 or clearance_m == 1.0 or asked.gaps_m["person"] <= clearance_m + 2e-3
        if 0.0 < clearance_m < 1.0:
            assert clearance_m == pytest.approx(_to_capsule_m(around, scenario.vehicle.hull_m, (x, y, z)), abs=0.02)


def _to_capsule_m(around, hull_m, centre) -> float:
    """Distance from an upright hull to the person, a vertical segment with a radius of 0.25 m, in plain geometry."""
    shift_x, shift_y, _ = around.shifts["person"]
    gaps = [
        max(0.0, abs(centre[0] - (-0.5 + shift_x)) - hull_m[0] / 2),
        max(0.0, abs(centre[1] - (3.25 + shift_y)) - hull_m[1] / 2),
        max(0.0, centre[2] - hull_m[2] / 2 - 1.45, 0.25 - centre[2] - hull_m[2] / 2),
    ]
    return math.hypot(*gaps) - 0.25


def test_the_observer_ranges_and_sights_the_person_where_it_is(server) -> None:
    client, ids, body, scenario = server()
    around = scenario.world.surroundings()
    observer = Observer(client, ids, body, scenario.vehicle, scenario, around)
    state = np.zeros(STATE_SIZE)
    state[:3], state[6] = (0.0, 2.0, 0.85), 1.0
    for now_s, place_m in ((0.0, (-0.5, 3.25)), (2.75, (-0.5, 6.0)), (9.15, (0.9, 1.0))):
        around.update(now_s, 0.0, 2.0)
        place(client, ids, around.shifts)
        row = dict(zip(observer.names, observer.sample(now_s, state, None), strict=True))
        assert (row["person_x_m"], row["person_y_m"]) == pytest.approx(place_m, abs=0.02)
        range_m = math.hypot(place_m[0], place_m[1] - 2.0) - 0.25
        assert row["person_range_m"] == pytest.approx(range_m, abs=0.03)
        assert row["person_sight_m"] == row["person_range_m"]


def test_the_line_of_sight_is_tried_to_where_the_person_is(server, monkeypatch) -> None:
    client, ids, body, scenario = server()
    around, tried = scenario.world.surroundings(), []

    def blocked(*arguments) -> bool:
        tried.append(arguments[-1][:2].copy())
        return True

    monkeypatch.setattr("scaloft_fi.sim.observer.blocked", blocked)
    observer = Observer(client, ids, body, scenario.vehicle, scenario, around)
    state = np.zeros(STATE_SIZE)
    state[:3], state[6] = (0.0, 2.0, 0.85), 1.0
    around.update(2.75, 0.0, 2.0)
    observer.sample(2.75, state, None)
    assert len(tried) == 4
    assert all(math.dist(point, (-0.5, 6.0)) < 0.26 for point in tried)


def test_the_nominal_flight_sights_a_person_where_it_has_walked_to(config: SimConfig, scenario) -> None:
    plain = load(SIM)
    there_s = plain.scenario(plain.grid.situation(KEY)).sighting_s
    away = replace(scenario().world, happenings=(_run_away(scenario().world.happenings[0]),))
    assert there_s is not None
    assert replace(scenario(), world=away).sighting_s is None


def _run_away(walk):
    """Round the corner before the drone has taken off."""
    return replace(walk, effect=replace(walk.effect, places=((-0.5, 8.2), (-5.0, 8.6)), speed_mps=10.0))
