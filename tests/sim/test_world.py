"""The world of the study: bodies with their roles, its scene, the rock of a ground plan, and a user's own mine."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from refused import refusal
from studies import item_of

from scaloft_fi.errors import InputError
from scaloft_fi.sim.load import load
from scaloft_fi.sim.mine import inside, read_mine
from scaloft_fi.sim.world import MARGIN_M, ROLES, Role
from scaloft_fi.views.picture import body_style


def test_the_scene_names_the_owner_of_every_triangle_that_is_there(config, scenario):
    world = scenario("T1O1W0D0H1").world
    scene = world.scene
    assert scene.names == world.surfaces == config.world.surfaces == ("wall", "ground", "bar", "obstacle", "person")
    assert [body.name for body in config.world.present] == ["bar"]
    assert len(scene.owner) == len(scene.faces)
    for number, name in enumerate(scene.names[2:], 2):
        vertices = scene.vertices[scene.faces[scene.owner == number]].reshape(-1, 3)
        assert np.allclose(vertices.min(axis=0), world.bodies[name].mesh.vertices.min(axis=0))
        assert scene.reflectivity[number] == world.bodies[name].reflectivity


def test_published_places_are_kept_and_cores_are_smaller_by_bullets_margin(scenario):
    world = scenario("T1O1W0D0H1").world
    assert world.route == ((0, 7, 1.65), (-3, 8, 1.65), (0, 7, 1.65), (0, 0, 1.65))
    person = world.bodies["person"].mesh.vertices
    assert np.allclose(0.5 * (person.min(axis=0) + person.max(axis=0)), (-0.5, 3.25, 0.85))
    for body in world.bodies.values():
        assert np.allclose(np.ptp(body.mesh.vertices, axis=0) - np.ptp(body.core.vertices, axis=0), 2 * MARGIN_M)


def told(config, key):
    """What detector and signals make of the bodies: labels, persons, obstacles."""
    one = config.scenario(config.grid.situation(key))
    return one.labels, one.persons, one.world.bodies_with(lambda role: role.is_obstacle)


def test_a_role_says_what_detector_signals_and_map_make_of_a_body(config, monkeypatch, edited):
    assert told(config, "T0O1W0D0H1") == ({"person": "person"}, ("person",), ("obstacle",))
    monkeypatch.setitem(ROLES._entries, "dog", Role("an animal", label="dog", is_obstacle=True, fill="#123456"))
    dogs = told(load(edited("world.yaml", "role: person", "role: dog")), "T0O1W0D0H1")
    assert dogs == ({"person": "dog"}, (), ("obstacle", "person"))
    assert 'fill="#123456"' in body_style("dog")


ROOM = {
    "footprint": [[0, 0], [6, 0], [6, 4], [0, 4]],
    "pillars": [[[2, 1], [3, 1], [3, 2], [2, 2]]],
    "height_m": 3,
    "cell_m": 1,
    "roughness_m": 0.1,
    "wall_reflectivity": 0.5,
    "ground_reflectivity": 0.4,
}


def mine(**changes):
    return read_mine(item_of(ROOM | changes, "mine"))


def normals(form):
    a, b, c = (form.triangles[:, i] for i in range(3))
    cross = np.cross(b - a, c - a)
    return form.triangles.mean(axis=1), cross / np.linalg.norm(cross, axis=1)[:, None]


@pytest.mark.parametrize("footprint", [ROOM["footprint"], ROOM["footprint"][::-1]])
def test_walls_face_the_open_space_whichever_way_a_footprint_runs(footprint):
    room = mine(footprint=footprint)
    for centre, normal in zip(*normals(room.wall), strict=True):
        if 0.3 < centre[2] < 2.7:
            assert room.holds(centre + 0.3 * normal)
            assert not room.holds(centre - 0.3 * normal)


def test_roughness_moves_walls_by_no_more_than_it_says_and_always_alike():
    rough, again, smooth = mine(), mine(), mine(roughness_m=0)
    moved = np.linalg.norm(rough.wall.vertices - smooth.wall.vertices, axis=1)
    assert 0 < moved.max() <= 0.1 * np.sqrt(2) + 1e-12
    assert np.array_equal(rough.wall.vertices, again.wall.vertices)


def test_open_space_is_inside_the_footprint_outside_the_pillars_below_the_ceiling_above_the_floor():
    room, points = mine(), ((1, 1, 1.5), (2.5, 1.5, 1.5), (7, 1, 1.5), (1, 1, 3.5), (1, 1, -0.5))
    assert [room.holds(point) for point in points] == [True, False, False, False, False]
    assert room.floor_m(1, 1) == 0


def test_the_rock_that_stands_out_of_a_rough_wall_is_not_open_space():
    room = mine()
    x, y, z = room.wall.vertices.T
    out = room.wall.vertices[(x > 0.02) & (x < 0.1) & (np.abs(y - 2) < 1.5) & (np.abs(z - 1.5) < 1)]
    assert len(out)
    for by_m, is_open in ((-0.01, False), (0.01, True)):
        assert {room.holds(point + np.array([by_m, 0, 0])) for point in out} == {is_open}


@given(st.floats(-3, 9), st.floats(-3, 7))
def test_a_point_is_in_a_rectangle_by_comparison(x, y):
    ring = ((0.0, 0.0), (6.0, 0.0), (6.0, 4.0), (0.0, 4.0))
    if min(abs(x), abs(x - 6), abs(y), abs(y - 4)) > 1e-9:
        assert inside(list(zip(ring, ring[1:] + ring[:1], strict=True)), x, y) == (0 < x < 6 and 0 < y < 4)


@pytest.mark.parametrize(
    ("point", "direction", "place", "inward"),
    [
        ((1.0, 1.5, 1.0), (1.0, 0.0), (2.0, 1.5), (-1.0, 0.0)),  # the pillar stands before the wall
        ((1.0, 3.0, 1.0), (1.0, 0.0), (6.0, 3.0), (-1.0, 0.0)),
        ((4.0, 1.5, 1.0), (-2.0, 0.0), (3.0, 1.5), (1.0, 0.0)),  # the length of the direction does not matter
        ((4.0, 1.0, 1.0), (0.0, -1.0), (4.0, 0.0), (0.0, 1.0)),
    ],
)
def test_the_wall_in_a_direction_is_the_nearest_and_faces_the_point(point, direction, place, inward):
    extruded = mine(roughness_m=0)
    for room in (extruded, replace(extruded, footprint=())):  # of a mesh its section at the height of the point
        wall = room.wall_towards(point, direction)
        assert (wall.place, wall.inward) == (pytest.approx(place), pytest.approx(inward))


def test_outside_of_the_mine_there_may_be_no_wall():
    assert mine().wall_towards((7.0, 2.0, 1.0), (1.0, 0.0)) is None


OBJ_ROOM = """o rock
v -200 -200 0
v 200 -200 0
v 200 900 0
v -200 900 0
v -200 -200 270
v 200 -200 270
v 200 900 270
v -200 900 270
f 1 5 6 2
f 2 6 7 3
f 3 7 8 4
f 4 8 5 1
f 5 8 7 6
o floor
f 1 2 3 4
"""


@pytest.fixture
def with_mesh(study):
    def build(mesh=OBJ_ROOM, keys="scale_m: 0.01"):
        head, rest = (study / "world.yaml").read_text().replace("end: [-3.0, 8.0]", "end: [1.5, 8.0]").split("mine:\n")
        own = ("mesh: room.obj", *keys.split("; "), "wall_reflectivity: 0.5", "ground_reflectivity: 0.5")
        rock = "".join(f"  {key}\n" for key in own)
        (study / "world.yaml").write_text(f"{head}mine:\n{rock}\nbodies:{rest.split('bodies:', 1)[1]}")
        sources = (study / "sources.yaml").read_text().splitlines()
        (study / "sources.yaml").write_text("\n".join(line for line in sources if not line.startswith("world.mine")))
        if mesh is not None:
            (study / "room.obj").write_text(mesh)
        return study

    return build


@pytest.mark.parametrize("keys", ["scale_m: 0.01", "scale_m: 0.01; ground: [floor]"])
def test_a_users_own_mine_is_read_from_an_obj_file(with_mesh, keys):
    config = load(with_mesh(keys=keys))
    mine = config.world.mine
    assert (len(mine.ground.faces), len(mine.wall.faces), config.world.floor_m) == (2, 10, 0)
    assert [mine.holds(point) for point in ((0, 5, 1.65), (0, 9.5, 1.65))] == [True, False]
    assert all(math.isfinite(config.scenario(situation).t_max_s) for situation in config.grid.situations)


@pytest.mark.parametrize(("limit", "most"), [("MOST_FACES_OF_ONE", 9), ("MOST_CORNERS", 7)])
def test_a_surface_that_the_physics_cannot_hold_is_refused_with_the_remedy(with_mesh, monkeypatch, limit, most):
    monkeypatch.setattr(f"scaloft_fi.sim.mesh.{limit}", most)
    with pytest.raises(InputError, match=r"PyBullet takes at most .* of one surface; `decimate_to: 100000`"):
        load(with_mesh())


def test_a_users_mine_may_be_wound_either_way(with_mesh):
    lines = (line.split() for line in OBJ_ROOM.splitlines())
    flipped = "\n".join(" ".join([word, *(rest[::-1] if word == "f" else rest)]) for word, *rest in lines)
    assert load(with_mesh(flipped)).world.mine.holds((0, 5, 1.65))


@pytest.mark.parametrize(
    ("mesh", "keys", "sentence"),
    [
        (None, "scale_m: 0.01", "room.obj' cannot be read: No such file"),
        ("hello\n", "scale_m: 0.01", "must have faces"),
        (OBJ_ROOM, "scale_m: -0.01", "scale_m=-0.01 must be > 0"),
        (OBJ_ROOM, "scale_m: 1.0; height_m: 2.7", "'mesh' in mine stands in place of 'height_m'; leave out"),
        (OBJ_ROOM, "scale_m: 0.001", "home=[0.0, 0.0] must be in the open space of the mine"),
        (OBJ_ROOM.replace("v 200 ", "v -100 "), "scale_m: 0.01", "must have the floor at z=0, but there is none"),
        (OBJ_ROOM.replace(" 0\n", " 30\n"), "scale_m: 0.01", "it is at z=0.30 m; the mine reaches from x -2 to 2"),
        (OBJ_ROOM, "scale_m: 0.01; ground: [flor]", "ground='flor' is no object of the mesh; did you mean 'floor'"),
        (OBJ_ROOM.replace("f 1 2 3 4", "f 1 2 3 9"), "scale_m: 0.01", "room.obj:16: 'f 1 2 3 9' must be"),
    ],
)
def test_a_users_mine_that_cannot_be_is_refused(with_mesh, mesh, keys, sentence):
    assert sentence in refusal(load, with_mesh(mesh, keys))
