from __future__ import annotations

import numpy as np
import pytest

from scaloft_fi.sim import mesh
from scaloft_fi.sim.build import blocked, build, connect
from scaloft_fi.sim.contact import contacts
from scaloft_fi.sim.vehicle import Airframe, spawn

pytestmark = pytest.mark.flight


@pytest.fixture
def world(config):
    return config.scenario(config.grid.situation("T1O1W0D0H1")).world


def test_every_surface_that_is_there_is_a_body(client, config, world):
    ids = build(client, world)
    assert tuple(ids.by_name) == ("wall", "ground", "bar", "obstacle", "person")
    assert {ids.by_name[name] for name in ids.by_name} == set(ids.name_of)


def test_absent_bodies_are_not_built(client, config):
    assert tuple(build(client, config.world).by_name) == ("wall", "ground", "bar")


def test_nothing_touches_at_the_start_but_the_floor(client, config, world):
    import pybullet

    ids = build(client, world)
    airframe = Airframe(client, config.vehicle, (0, 0, config.vehicle.half_height_m), 0)
    for _ in range(60):
        pybullet.stepSimulation(physicsClientId=client)
    airframe.read()
    assert abs(airframe.state[2] - config.vehicle.half_height_m) < 2e-3
    touched = contacts(client, airframe.number, ids.name_of, airframe.state, config.vehicle.half_height_m)
    assert touched == (("ground", True),)


@pytest.mark.parametrize(
    ("name", "position", "gap_m"),
    [
        ("person", (-0.5 + 0.25 + 0.235 + 0.2, 3.25, 0.85), 0.2),
        ("obstacle", (-0.15, 5 - 0.25 - 0.235 - 0.3, 0.9), 0.3),
        ("bar", (-1.9, 7.7 - 0.03 - 0.235 - 0.1, 1.3), 0.1),
        ("ground", (0, 3, 0.055 + 0.4), 0.4),
    ],
)
def test_distances_to_bodies_are_those_of_the_geometry(client, config, world, name, position, gap_m):
    import pybullet

    ids = build(client, world)
    body = spawn(client, config.vehicle, position, 0)
    points = pybullet.getClosestPoints(body, ids.by_name[name], 1.0, physicsClientId=client)
    assert min(point[8] for point in points) == pytest.approx(gap_m, abs=1e-4)


def test_distances_to_rock_are_short_by_a_millimetre(client, config, world):
    import pybullet

    ids = build(client, world)
    body = spawn(client, config.vehicle, (0, 4, 2.7 - 0.055 - 0.2), 0)
    points = pybullet.getClosestPoints(body, ids.by_name["wall"], 1.0, physicsClientId=client)
    assert min(point[8] for point in points) == pytest.approx(0.199, abs=1e-4)


def test_a_body_pushed_into_the_hull_is_a_touch_with_its_name(client, config, world):
    import pybullet

    ids = build(client, world)
    half = config.vehicle.half_height_m
    airframe = Airframe(client, config.vehicle, (-0.5 + 0.25 + 0.235 - 0.005, 3.25, 0.85), 0)
    pybullet.stepSimulation(physicsClientId=client)
    airframe.read()
    assert contacts(client, airframe.number, ids.name_of, airframe.state, half) == (("person", False),)


def test_the_line_of_sight_equals_a_ray_test(client, config, world):
    import pybullet

    ids = build(client, world)
    spawn(client, config.vehicle, (0, 4, 1.65), 0)  # rays pass through the vehicle
    scene = world.scene
    draw = np.random.default_rng(0)
    spared = scene.names.index("person")
    differ = 0
    for _ in range(300):
        start, end = (np.array([draw.uniform(-1.3, 1.3), draw.uniform(-1, 9), draw.uniform(0.1, 2.5)]) for _ in "ab")
        if any(abs(mesh.winding(b.mesh.triangles, p)) > 0.5 for b in world.present for p in (start, end)):
            continue  # Bullet does not see a hull from inside
        hits = pybullet.rayTest(start.tolist(), end.tolist(), physicsClientId=client)
        struck = ids.name_of.get(hits[0][0], "")
        if struck == "person":
            continue
        differ += blocked(scene.vertices, scene.faces, scene.owner, spared, start, end) != bool(struck)
    assert differ <= 1  # a line along an edge may fall to either side


def test_a_users_mesh_mine_is_rock_and_floor(client, config):
    from dataclasses import replace

    import pybullet

    room = mesh.box((4, 12, 3)).moved((0, 4, 1.5))
    wall, floor = mesh.split_floor(room, [""] * 12, [], "here")
    mine = replace(config.world.mine, wall=wall, ground=floor, ground_is_slab=False, footprint=())
    ids = build(client, replace(config.world, mine=mine))
    airframe = Airframe(client, config.vehicle, (0, 2, 0.4), 0)
    for _ in range(240):
        pybullet.stepSimulation(physicsClientId=client)
    airframe.read()
    assert airframe.state[2] == pytest.approx(config.vehicle.half_height_m, abs=3e-3)
    touched = contacts(client, airframe.number, ids.name_of, airframe.state, config.vehicle.half_height_m)
    assert touched == (("ground", True),)


def test_a_server_of_its_own_is_started():
    import pybullet

    client = connect()
    assert pybullet.isConnected(client)
    pybullet.disconnect(physicsClientId=client)
