"""Bodies of the physics server, and the geometry of the ground truth beside plain formulas."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pybullet
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from scaloft_fi.sim import mesh
from scaloft_fi.sim.build import blocked, build, nearest, outside, place
from scaloft_fi.sim.contact import contacts
from scaloft_fi.sim.vehicle import Airframe, spawn
from scaloft_fi.sim.world import Box

points = st.tuples(*[st.floats(-2, 2)] * 3).map(np.array)
FORM = mesh.join([mesh.box((0.5, 0.6, 0.7)), mesh.capsule(0.2, 1.0).moved((0.9, 0.2, 0.1))])
OWNER = np.repeat(np.array([0, 1], np.int16), [12, len(FORM.faces) - 12])


@pytest.fixture
def world(scenario):
    return scenario("T1O1W0D0H1").world


@pytest.fixture
def touched(client, config):
    """The contacts after some steps from a place, and the height then."""

    def fall(world, position, steps):
        ids, half = build(client, world), config.vehicle.half_height_m
        airframe = Airframe(client, config.vehicle, position, 0)
        for _ in range(steps):
            pybullet.stepSimulation(physicsClientId=client)
        airframe.read()
        return contacts(client, airframe.number, ids.name_of, airframe.state, half), airframe.state[2] - half

    return fall


def gap_m(client, ids, vehicle, name, position):
    body = spawn(client, vehicle, position, 0)
    points = pybullet.getClosestPoints(body, ids.by_name[name], 1.0, physicsClientId=client)
    return min(point[8] for point in points)


@pytest.mark.flight
def test_every_surface_that_is_there_is_a_body(client, config, world):
    ids = build(client, world)
    assert tuple(ids.by_name) == ("wall", "ground", "bar", "obstacle", "person")
    assert set(ids.by_name.values()) == set(ids.name_of)
    assert config.world.scene.names == ("wall", "ground", "bar")


@pytest.mark.flight
def test_nothing_touches_at_the_start_but_the_floor(touched, config, world):
    found, height_m = touched(world, (0, 0, config.vehicle.half_height_m), 60)
    assert (found, height_m) == ((("ground", True),), pytest.approx(0.0, abs=2e-3))


@pytest.mark.flight
def test_a_body_pushed_into_the_hull_is_a_touch_with_its_name(touched, world):
    assert touched(world, (-0.5 + 0.25 + 0.235 - 0.005, 3.25, 0.85), 1)[0] == (("person", False),)


@pytest.mark.flight
def test_a_users_mesh_mine_is_rock_and_floor(touched, config):
    wall, floor = mesh.split_floor(mesh.box((4, 12, 3)).moved((0, 4, 1.5)), [""] * 12, [], "here")
    mine = replace(config.world.mine, wall=wall, ground=floor, ground_is_slab=False, footprint=())
    found, height_m = touched(replace(config.world, mine=mine), (0, 2, 0.4), 240)
    assert (found, height_m) == ((("ground", True),), pytest.approx(0.0, abs=3e-3))


@pytest.mark.flight
@pytest.mark.parametrize(
    ("name", "position", "distance_m"),
    [
        ("person", (-0.5 + 0.25 + 0.235 + 0.2, 3.25, 0.85), 0.2),
        ("obstacle", (-0.15, 5 - 0.25 - 0.235 - 0.3, 0.9), 0.3),
        ("bar", (-1.9, 7.7 - 0.03 - 0.235 - 0.1, 1.3), 0.1),
        ("ground", (0, 3, 0.055 + 0.4), 0.4),
        ("wall", (0, 4, 2.7 - 0.055 - 0.2), 0.199),  # distances to rock are short by a millimetre
    ],
)
def test_distances_to_bodies_are_those_of_the_geometry(client, config, world, name, position, distance_m):
    assert gap_m(client, build(client, world), config.vehicle, name, position) == pytest.approx(distance_m, abs=1e-4)


@pytest.mark.flight
def test_the_line_of_sight_equals_a_ray_test(client, config, world):
    ids, scene = build(client, world), world.scene
    spawn(client, config.vehicle, (0, 4, 1.65), 0)  # rays pass through the vehicle
    draw, spared, differ = np.random.default_rng(0), scene.names.index("person"), 0
    for _ in range(300):
        start, end = (np.array([draw.uniform(-1.3, 1.3), draw.uniform(-1, 9), draw.uniform(0.1, 2.5)]) for _ in "ab")
        hits = pybullet.rayTest(start.tolist(), end.tolist(), physicsClientId=client)
        struck = ids.name_of.get(hits[0][0], "")
        # Bullet does not see a hull from inside
        if struck != "person" and not any(body.mesh.encloses(p) for body in world.present for p in (start, end)):
            differ += blocked(scene.vertices, scene.faces, scene.owner, spared, start, end) != bool(struck)
    assert differ <= 1  # a line along an edge may fall to either side


@given(points)
def test_the_nearest_point_of_a_box_is_as_far_as_the_formula_says(point):
    found, half = np.empty(3), np.array((0.25, 0.3, 0.35))
    distance = nearest(FORM.vertices, FORM.faces, OWNER, 0, point, found)
    beyond = np.abs(point) - half
    expected = np.linalg.norm(np.maximum(beyond, 0)) if (beyond > 0).any() else -beyond.max()
    assert [distance, np.linalg.norm(found - point)] == pytest.approx([expected, distance], abs=1e-9)


@given(points)
def test_no_corner_or_point_inside_a_face_is_nearer_than_the_nearest(point):
    distance = nearest(FORM.vertices, FORM.faces, OWNER, 1, point, np.empty(3))
    samples = np.random.default_rng(0).dirichlet((1, 1, 1), 30)
    dense = np.einsum("sk,fkx->fsx", samples, FORM.triangles[OWNER == 1]).reshape(-1, 3)
    assert np.linalg.norm(dense - point, axis=1).min() >= distance - 1e-9


def crosses(start, end, triangle):
    """How far inside the triangle the line crosses it: solve start + t (end - start) = a + u (b - a) + v (c - a)."""
    a, b, c = triangle
    matrix = np.column_stack([start - end, b - a, c - a])
    volume = abs(np.linalg.det(matrix))
    if volume < 1e-9:
        return -1.0 if volume == 0 else 0.0  # nearly edge-on: neither
    t, u, v = np.linalg.solve(matrix, start - a)
    return min(t, 1 - t, u, v, 1 - u - v)


@given(points, points)
def test_a_line_is_blocked_where_solving_for_each_triangle_says_so(start, end):
    for spared in (-1, 0, 1):
        inside = [crosses(start, end, t) for t, owner in zip(FORM.triangles, OWNER, strict=True) if owner != spared]
        assume(all(abs(margin) > 1e-9 for margin in inside))  # through an edge is neither
        assert blocked(FORM.vertices, FORM.faces, OWNER, spared, start, end) == (max(inside, default=-1.0) > 0)


@given(st.tuples(*[st.floats(-3, 3)] * 3), st.tuples(*[st.floats(0.1, 2)] * 3))
def test_a_box_is_as_far_as_the_nearest_of_its_points(point, size):
    box, found = np.array([[0.0, 0.0, 0.0, *size], [-9.0, -9.0, -9.0, 9.0, 9.0, 9.0]]), np.empty(2)
    outside(box, *point, found)
    assert found == pytest.approx([np.linalg.norm(np.clip(point, 0.0, size) - point), 0.0], abs=1e-12)


@pytest.mark.flight
@pytest.mark.parametrize(("yaw_deg", "half_m"), [(0.0, 0.2), (90.0, 0.6), (-270.0, 0.6)])
def test_a_turned_body_that_moves_stays_turned(client, config, world, yaw_deg, half_m):
    train = Box("train", "obstacle", (-0.5, 2.0), 0.3, True, "box", (0.4, 1.2, 1.8), yaw_deg=yaw_deg)
    ids = build(client, replace(world, bodies={"train": train}))
    place(client, ids, {"train": (0.3, 1.0, 0.0)})
    vehicle = config.vehicle
    gap = gap_m(client, ids, vehicle, "train", (-0.2 + half_m + 0.5 * vehicle.hull_m[0] + 0.1, 3.0, 1.0))
    assert gap == pytest.approx(0.1, abs=2e-3)
