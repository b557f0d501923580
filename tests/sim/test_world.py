from __future__ import annotations

import math

import numpy as np
import pytest

from scaloft_fi.errors import InputError
from scaloft_fi.sim.load import load
from scaloft_fi.sim.world import MARGIN_M


def test_the_benign_world_has_no_obstacle_and_no_person(config):
    assert [body.name for body in config.world.present] == ["bar"]
    assert config.world.surfaces == ("wall", "ground", "bar", "obstacle", "person")


def test_the_scene_names_the_owner_of_every_triangle(config):
    world = config.scenario(config.grid.situation("T1O1W0D0H1")).world
    scene = world.scene
    assert scene.names == ("wall", "ground", "bar", "obstacle", "person")
    assert len(scene.owner) == len(scene.faces)
    for number, name in enumerate(scene.names[2:], 2):
        vertices = scene.vertices[scene.faces[scene.owner == number]].reshape(-1, 3)
        assert np.allclose(vertices.min(axis=0), world.bodies[name].mesh.vertices.min(axis=0))
        assert scene.reflectivity[number] == world.bodies[name].reflectivity


def test_published_places_are_kept(config):
    world = config.scenario(config.grid.situation("T1O1W0D0H1")).world
    assert world.route == ((0, 7, 1.65), (-3, 8, 1.65), (0, 7, 1.65), (0, 0, 1.65))
    person = world.bodies["person"].mesh.vertices
    assert np.allclose(0.5 * (person.min(axis=0) + person.max(axis=0)), (-0.5, 3.25, 0.85))
    assert world.bodies_with(lambda role: role.is_person) == ("person",)


def test_the_core_of_a_body_is_smaller_by_bullets_margin(config):
    for body in config.world.bodies.values():
        assert np.allclose(np.ptp(body.mesh.vertices, axis=0) - np.ptp(body.core.vertices, axis=0), 2 * MARGIN_M)


BAD = [
    ("corner: [0.0, 7.0]", "corner: [1.6, 7.0]", "corner=[1.6, 7.0] must be in the open space of the mine"),
    ("corner: [0.0, 7.0]", "corner: [-1.9, 7.7]", "corner=[-1.9, 7.7] must be in open space, not inside 'bar'"),
    ("corner: [0.0, 7.0]", "corner: [0.0, 30.0]", "must be in the open space"),
    ("corner: [0.0, 7.0]", "corner: [0.0, seven]", "must be a number"),
    ("home: [0.0, 0.0]", "home: [1.8, 0.0]", "home=[1.8, 0.0] must be in the open space"),
    ("home: [0.0, 0.0]", "home: [50.0, 0.0]", "must have the floor at z=0, but there is none"),
    ("position: [-1.9, 7.7]", "position: [0.0, 0.0]", "home=[0.0, 0.0] must be in open space, not inside 'bar'"),
    ("altitude_m: 1.65", "altitude_m: 4.0", "must be in the open space"),
    ("altitude_m: 1.65", "altitude_m: -1.65", "altitude_m=-1.65 must be > 0"),
    ("size_m: [0.5, 0.5, 1.8]", "size_m: [0.5, -0.5, 1.8]", "size_m[1]=-0.5 must be >= 0.005"),
    ("radius_m: 0.03", "radius_m: -0.03", "radius_m=-0.03 must be >= 0.005"),
    ("height_m: 1.7", "height_m: 0.3", "height_m=0.3 must be >= 0.5"),
    ("shape: cylinder", "shape: cilinder", "did you mean 'cylinder'"),
    ("role: person", "role: human", "role='human' is not known"),
    ("route: [corner, home]", "route: [coner, home]", "no waypoint 'coner'; did you mean 'corner'"),
    ("route: [corner, home]", "route: []", "route=[...] must be a list of waypoints, where the mission lands"),
    ("corner: [0.0, 7.0]", "corner: [0.0]", "corner=[...] must be [x, y] or [x, y, z]"),
    ("corner: [0.0, 7.0]", "corner: [0.0, 7.0, 2.9]", "must be in the open space of the mine"),
    ("light: 0.9", "light: 1.9", "light=1.9 must be >= 0 and <= 1"),
    ("light: 0.9", "ligth: 0.9", "unknown key 'ligth' in world.yaml; did you mean 'light'?"),
    ("present: true", "present: perhaps", "present='perhaps' must be true or false"),
    ("present: true", "present: true\n    colour: red", "unknown key 'colour'"),
    ("cruise_mps: 0.5", "cruise_mps: 0", "cruise_mps=0 must be > 0"),
    ("  bar: ", "  wall: ", "name 'wall' must be a name"),
    ("position: [-1.9, 7.7]", "position: [-1.9]", "must be [x, y] or [x, y, z of the foot]"),
    ("corner: [0.0, 7.0]", "corner: [0.0, 7.0]\n  home: [0, 1]", "home is no waypoint of its own"),
    ("corner: [0.0, 7.0]", "corner: [0.0, 7.0", "not valid YAML"),
]


@pytest.mark.parametrize(("old", "new", "sentence"), BAD)
def test_a_world_that_cannot_be_is_refused_in_one_sentence_with_its_line(edited, old, new, sentence):
    study = edited("world.yaml", old, new)
    with pytest.raises(InputError) as error:
        load(study)
    message = str(error.value)
    assert sentence in message
    assert "\n" not in message
    file, line, _ = message.split(":", 2)
    assert file.endswith("world.yaml")
    assert 1 <= int(line) <= 80


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
        path = study / "world.yaml"
        lines = path.read_text(encoding="utf-8").splitlines()
        begin, end = lines.index("mine:"), lines.index("bodies:")
        reflect = ["  wall_reflectivity: 0.5", "  ground_reflectivity: 0.5"]
        lines[begin + 1 : end] = ["  mesh: room.obj", *(f"  {key}" for key in keys.split("; ")), *reflect]
        text = "\n".join(lines).replace("end: [-3.0, 8.0]", "end: [1.5, 8.0]")
        path.write_text(text, encoding="utf-8")
        sources = study / "sources.yaml"
        kept = [line for line in sources.read_text(encoding="utf-8").splitlines() if not line.startswith("world.mine")]
        sources.write_text("\n".join(kept), encoding="utf-8")
        if mesh is not None:
            (study / "room.obj").write_text(mesh, encoding="utf-8")
        return study

    return build


@pytest.mark.parametrize("keys", ["scale_m: 0.01", "scale_m: 0.01; ground: [floor]"])
def test_a_users_own_mine_is_read_from_an_obj_file(with_mesh, keys):
    config = load(with_mesh(keys=keys))
    mine = config.world.mine
    assert len(mine.ground.faces) == 2
    assert len(mine.wall.faces) == 10
    assert config.world.floor_m == 0
    assert mine.holds((0, 5, 1.65))
    assert not mine.holds((0, 9.5, 1.65))
    for situation in config.grid.situations:
        assert math.isfinite(config.scenario(situation).t_max_s)


def test_a_users_mine_may_be_wound_either_way(with_mesh):
    flipped = "\n".join(
        "f " + " ".join(reversed(line.split()[1:])) if line.startswith("f ") else line for line in OBJ_ROOM.splitlines()
    )
    assert load(with_mesh(flipped)).world.mine.holds((0, 5, 1.65))


@pytest.mark.parametrize(
    ("mesh", "keys", "sentence"),
    [
        (None, "scale_m: 0.01", "room.obj' cannot be read: No such file"),
        ("hello\n", "scale_m: 0.01", "must have faces"),
        (OBJ_ROOM, "scale_m: -0.01", "scale_m=-0.01 must be > 0"),
        (OBJ_ROOM, "scale_m: 1.0; height_m: 2.7", "unknown key 'height_m'"),
        (OBJ_ROOM, "scale_m: 0.001", "home=[0.0, 0.0] must be in the open space of the mine"),
        (OBJ_ROOM.replace("v 200 ", "v -100 "), "scale_m: 0.01", "must have the floor at z=0, but there is none"),
        (OBJ_ROOM.replace(" 0\n", " 30\n"), "scale_m: 0.01", "it is at z=0.30 m; the mine reaches from x -2 to 2"),
        (OBJ_ROOM, "scale_m: 0.01; ground: [flor]", "ground='flor' is no object of the mesh; did you mean 'floor'"),
        (OBJ_ROOM.replace("f 1 2 3 4", "f 1 2 3 9"), "scale_m: 0.01", "room.obj:16: 'f 1 2 3 9' must be"),
    ],
)
def test_a_users_mine_that_cannot_be_is_refused(with_mesh, mesh, keys, sentence):
    study = with_mesh(mesh, keys)
    with pytest.raises(InputError) as error:
        load(study)
    assert sentence in str(error.value)
    assert "\n" not in str(error.value)
