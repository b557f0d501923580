"""Shapes, OBJ files with their limits, and the flaws of a surface."""

from __future__ import annotations

import math
from collections import Counter
from pathlib import Path

import numpy as np
import pytest
import trimesh
from hypothesis import given
from hypothesis import strategies as st
from refused import refusal
from studies import build

from scaloft_fi.errors import InputError
from scaloft_fi.sim import mesh
from scaloft_fi.sim.mesh import (
    MeshFile,
    MeshLimits,
    Stated,
    box,
    cylinder,
    decimated,
    lathe,
    read_mesh,
    read_obj,
    stated,
    surface_flaws,
    turn_back,
    turn_up,
)

sizes = st.floats(0.1, 3.0)
SHAPES = {
    "box": mesh.box((0.5, 0.4, 1.8)),
    "cylinder": mesh.cylinder(0.03, 2.7),
    "capsule": mesh.capsule(0.25, 1.7),
    "ball": mesh.capsule(0.25, 0.5),
}


def volume(form):
    a, b, c = (form.triangles[:, i] for i in range(3))
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6)


@pytest.mark.parametrize("name", SHAPES)
def test_every_shape_is_closed_wound_outwards_and_without_faces_that_have_no_area(name):
    form = SHAPES[name]
    edges = Counter((a, b) for face in form.faces.tolist() for a, b in zip(face, face[1:] + face[:1], strict=True))
    assert all(edges[b, a] == count == 1 for (a, b), count in edges.items())
    a, b, c = (form.triangles[:, i] for i in range(3))
    assert np.linalg.norm(np.cross(b - a, c - a), axis=1).min() > 1e-6
    assert volume(form) > 0


@given(sizes, sizes, sizes)
def test_boxes_and_capsules_have_their_size(x, y, z):
    form, capsule = mesh.box((x, y, z)), mesh.capsule(x, 2 * x + y)
    assert np.allclose(np.ptp(form.vertices, axis=0), (x, y, z))
    assert math.isclose(volume(form), x * y * z, rel_tol=1e-9)
    assert math.isclose(np.ptp(capsule.vertices[:, 2]), 2 * x + y)
    assert math.isclose(np.linalg.norm(capsule.vertices[:, :2], axis=1).max(), x)


@given(st.tuples(sizes, sizes, sizes), st.tuples(*[st.floats(-2, 2)] * 3))
def test_the_winding_number_tells_inside_from_outside(size, point):
    offset = np.abs(point) - np.array(size) / 2
    if np.abs(offset).min() < 1e-3:
        return
    inside = bool((offset < 0).all())
    assert math.isclose(mesh.winding(mesh.box(size).triangles, point), float(inside), abs_tol=1e-6)
    assert mesh.box(size).encloses(point) == inside


def test_heights_sections_and_joins_are_those_of_the_triangles():
    form = mesh.box((1, 1, 2)).triangles
    assert sorted(set(np.round(mesh.heights_at(form, 0.1, 0.3), 9))) == [-1, 1]
    assert len(mesh.heights_at(form, 0.6, 0.3)) == 0
    assert math.isclose(sum(math.dist(*ends) for ends in mesh.section(mesh.box((2, 1, 1)).triangles, 0.1)), 6)
    parts = list(SHAPES.values())
    assert np.array_equal(mesh.join(parts).triangles, np.concatenate([part.triangles for part in parts]))


def test_without_a_name_the_floor_is_what_is_level_and_has_nothing_below():
    form = mesh.box((4, 4, 3))
    rock, floor = mesh.split_floor(form, [""] * len(form.faces), [], "world.yaml:3")
    assert (len(rock.faces), len(floor.faces)) == (10, 2)
    assert np.all(floor.vertices[:, 2] == -1.5)


@pytest.mark.parametrize(
    ("asked", "sentence"),
    [
        ("flor", r"world.yaml:3: ground='flor' is no object of the mesh; did you mean 'floor'"),
        ("floor", "must have a floor and walls"),
    ],
)
def test_a_floor_that_the_mesh_lacks_and_a_mesh_that_is_all_floor_are_refused(asked, sentence):
    form = mesh.box((4, 4, 3))
    with pytest.raises(InputError, match=sentence):
        mesh.split_floor(form, ["floor"] * len(form.faces), [asked], "world.yaml:3")


def test_the_lowest_level_faces_are_the_floor_however_many_columns_there_are(monkeypatch):
    rng = np.random.default_rng(0)
    layers = [mesh.box((8, 8, 0.1)).moved((0, 0, z)) for z in (0.0, 3.0)]
    bumps = [mesh.box(rng.uniform(0.1, 3.0, 3)).moved(rng.uniform(-4, 4, 3)) for _ in range(60)]
    form = mesh.join([*layers, *bumps])
    names, floors = [""] * len(form.faces), []
    for columns in (1, 2, 7, 128):
        monkeypatch.setattr(mesh, "COLUMNS", columns)
        floors.append(mesh.split_floor(form, names, [], "")[1].triangles)
    assert all(np.array_equal(floor, floors[0]) for floor in floors)
    monkeypatch.setattr(mesh, "MOST_PAIRS", 1000)
    with pytest.raises(InputError, match="overlap too often; name the floor's objects under `ground`"):
        mesh.split_floor(form, names, [], "world.yaml:3")


SQUARE = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n# two triangles\nf 1 2 3 4\n"


@pytest.fixture
def read(tmp_path):
    """Read a text as an OBJ file."""

    def make(content, scale=1.0, limits=None):
        if content is not None:
            (tmp_path / "mine.obj").write_bytes(content if isinstance(content, bytes) else content.encode())
        return read_obj(tmp_path / "mine.obj", "world.yaml:3", scale, limits)

    return make


def test_an_obj_file_is_read_with_quads_negative_indices_objects_and_lines(read):
    text = (
        "# a square and a triangle\r\no floor\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1/1/1 2/2/1 3/3/1 4/4/1 # two\n"
        "g roof top\nv 0 0 1\nf -1 1 2\n"
    )
    form, names, lines, _ = read(text, 2.0)
    assert names == ("floor", "floor", "roof top")
    assert np.array_equal(form.triangles[2], [[0, 0, 2], [0, 0, 0], [2, 0, 0]])
    assert lines.tolist() == [7, 7, 10]


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("v 0 0\nf 1 1 1\n", ":1: 'v 0 0' must be a vertex"),
        ("v 0 0 nan\n", ":1: 'v 0 0 nan' must be"),
        ("v 0 0 0\nf 1 2 3\n", ":2: 'f 1 2 3' must be"),
        ("v 0 0 0\nv 0 0 1\nf 1 2\n", ":3: 'f 1 2' must be"),
        ("v 0 0 0\nf 0 1 1\n", ":2: 'f 0 1 1' must be"),
        ("v 0 0 0\n", "world.yaml:3: mesh="),
        (None, "world.yaml:3: mesh="),
        (b"\xff\xfe\x00", "must have faces"),
    ],
)
def test_a_broken_obj_file_is_refused_with_its_line_or_the_place_that_names_it(read, text, sentence):
    assert sentence in refusal(read, text)


@pytest.mark.parametrize(
    ("limits", "sentence"),
    [
        (MeshLimits(triangles=1), ":4: the mesh must have at most 1 triangles"),
        (MeshLimits(corners=3), ":6: a face must have at most 3 corners"),
        (MeshLimits(size_bytes=len(SQUARE) - 1), f"larger than {len(SQUARE) - 1} bytes"),
    ],
)
def test_a_limit_is_told_with_the_setting_that_raises_it(read, limits, sentence):
    with pytest.raises(InputError, match=rf"{sentence}.*`mesh_limits: \{{"):
        read(SQUARE, 1.0, limits)


def test_a_mesh_at_its_limits_is_read_with_line_ends_of_any_system(read):
    limits = build(MeshLimits, {"size_bytes": 100, "triangles": 2, "corners": 4})
    assert [len(read(SQUARE.replace("\n", end), 1.0, limits).mesh.faces) for end in ("\n", "\r\n", "\r")] == [2, 2, 2]


ROOM, PILLAR = box((4.0, 6.0, 3.0)).triangles, cylinder(0.3, 1.0).triangles


def flaws(*parts):
    """The flaws of triangles whose lines count from 100."""
    triangles = np.concatenate(parts)
    return list(surface_flaws(triangles, np.arange(100, 100 + len(triangles)), Path("room.obj")))


def turned(triangles, *which):
    changed = triangles.copy()
    for face in which or range(len(changed)):
        changed[face] = changed[face, ::-1]
    return changed


def room_beyond(share):
    """A room that overlaps the first one, beyond it with this share."""
    alcove = box((1.0, 1.0, 1.0)).triangles
    east_m = ROOM[:, :, 0].max() - alcove[:, :, 0].max() + share
    return alcove + np.array([east_m, 0.0, ROOM[:, :, 2].min() - alcove[:, :, 2].min() + 0.5])


@pytest.mark.parametrize(
    "parts",
    [
        (ROOM,),
        (turned(ROOM),),
        (ROOM + 1e-8,),  # vertices that stand at one place are one
        (ROOM, turned(PILLAR)),
        (ROOM, ROOM + np.array([10.0, 0.0, 0.0])),
        *((ROOM, room_beyond(share)) for share in (0.4, 0.5, 0.9)),
    ],
)
def test_a_sound_surface_has_no_flaw_whichever_way_it_is_wound(parts):
    assert flaws(*parts) == []


@pytest.mark.parametrize("room", [ROOM, turned(ROOM)])
def test_the_fewer_faces_are_the_turned_ones_and_a_neighbour_is_named(room):
    (flaw,) = flaws(turned(room, 3, 7))
    assert (flaw.grave, flaw.place) == (True, "room.obj:103")
    assert flaw.sentence.startswith(
        "2 of 12 faces are wound the other way than their neighbours, the first at this line"
    )
    assert flaw.sentence.endswith("at line 104")


@pytest.mark.parametrize("top_first", [False, True])
@pytest.mark.parametrize(("low_m", "high_m"), [(1.0, 2.0), (0.0, 1.0), (-0.05, 1.0), (0.0, 3.0), (-0.05, 3.05)])
def test_a_pillar_is_wound_against_the_room_around_it_that_it_may_touch_or_enter(low_m, high_m, top_first):
    pillar = box((0.5, 0.5, high_m - low_m)).triangles
    moved = pillar + np.array([0.4, 0.3, ROOM[:, :, 2].min() + low_m - pillar[:, :, 2].min()])
    height_m = moved[:, :, 2].mean(axis=1)
    moved = moved[np.argsort(-height_m if top_first else height_m)]  # whichever face the file names first
    assert flaws(ROOM, turned(moved)) == []
    (flaw,) = flaws(ROOM, moved)
    assert (flaw.grave, flaw.place) == (True, "room.obj:112")
    assert "lies within another and is wound like it" in flaw.sentence


def test_a_hole_and_faces_without_area_are_told_and_not_grave():
    (hole,) = flaws(ROOM[1:])
    assert hole.sentence.startswith("the surface has holes: 3 edges have no second face")
    (point,) = flaws(ROOM, np.zeros((1, 3, 3)))
    assert [hole.grave, point.grave, point.place] == [False, False, "room.obj:112"]
    assert flaws(np.zeros((1, 3, 3)))[0].sentence.startswith("1 of 1 faces is without area")


def test_a_surface_with_one_side_is_told():
    turn = np.linspace(0.0, 2.0 * np.pi, 13)
    middle = np.stack([np.cos(turn), np.sin(turn), 0.0 * turn], axis=1)
    half = np.stack([np.cos(turn) * np.cos(turn / 2), np.sin(turn) * np.cos(turn / 2), np.sin(turn / 2)], axis=1) * 0.3
    one, other = middle + half, middle - half
    strip = [f for i in range(12) for f in ((one[i], other[i], one[i + 1]), (other[i], other[i + 1], one[i + 1]))]
    assert any("one side only" in flaw.sentence for flaw in flaws(np.array(strip)))


ENDINGS = ("stl", "ply", "glb", "gltf", "off", "obj")


def _corners(triangles):
    """The faces of a mesh, whatever their order."""
    return sorted(tuple(sorted(map(tuple, np.round(face, 4)))) for face in triangles.tolist())


def _exported(folder, ending, triangles, swapped):
    """A file of triangles; `swapped`: with y up."""
    points = triangles.reshape(-1, 3)
    points = points @ np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]]) if swapped else points
    path = folder / f"room.{ending}"
    made = trimesh.Trimesh(points, np.arange(len(points)).reshape(-1, 3), process=False)
    if ending == "gltf":
        for name, content in trimesh.exchange.gltf.export_gltf(trimesh.Scene(made)).items():
            (folder / name.replace("model.gltf", path.name)).write_bytes(content)
    else:
        made.export(path)
    return path


@pytest.mark.parametrize("ending", ENDINGS)
@pytest.mark.parametrize("up", ["z", "y"])
def test_a_room_is_the_same_in_every_format_and_with_either_axis_up(ending, up, tmp_path):
    path = _exported(tmp_path, ending, 100.0 * ROOM, up == "y")
    file = read_mesh(path, "world.yaml:3", 0.01, up, MeshLimits())
    assert _corners(file.mesh.triangles) == _corners(ROOM)
    assert list(surface_flaws(file.mesh.triangles, file.lines, path, file.word)) == []
    assert len(file.names) == len(file.lines) == len(file.mesh.faces)


@pytest.mark.parametrize("ending", [*ENDINGS, "dae", "step"])
def test_what_is_no_mesh_is_one_sentence(ending, tmp_path):
    path = tmp_path / f"room.{ending}"
    path.write_bytes(b"solid nothing\n" * 3)
    with pytest.raises(InputError, match=r"^world\.yaml:3: mesh=.*(cannot be read|must have faces)"):
        read_mesh(path, "world.yaml:3", 1.0, "z", MeshLimits())


@pytest.mark.parametrize(
    ("limits", "said"), [(MeshLimits(size_bytes=100), "size_bytes"), (MeshLimits(triangles=3), "triangles")]
)
def test_a_mesh_of_any_format_has_the_limits_of_the_study(limits, said, tmp_path):
    path = _exported(tmp_path, "stl", ROOM, False)
    with pytest.raises(InputError, match=f"`mesh_limits: {{{said}: ...}}` beside `mesh` allows more"):
        read_mesh(path, "world.yaml:3", 1.0, "z", limits)


@pytest.mark.parametrize(
    "content",
    [
        b"# M\xf6ller\n" + SQUARE.encode(),
        SQUARE.encode().rstrip() + b" # M\xf6ller\n",
        b"# 5\x80 in Windows-1252, \x93quoted\x94\r\n" + SQUARE.replace("\n", "\r\n").encode(),
        b"mtllib M\xf6ller.mtl\nusemtl Stra\xdfe\n" + SQUARE.encode(),
        b"o M\xf6ller\n" + SQUARE.encode(),
        b"\xef\xbb\xbf" + SQUARE.encode(),
    ],
    ids=["comment", "end of a line", "Windows", "material", "name", "mark of its encoding"],
)
def test_bytes_that_are_no_utf_8_carry_no_geometry(content, read):
    assert read(content).mesh.triangles.tolist() == read(SQUARE).mesh.triangles.tolist()


def test_faces_that_are_there_twice_are_the_fault_of_the_mesh_and_not_of_the_waypoints():
    (both,) = flaws(ROOM, turned(ROOM))
    assert (
        both.sentence
        == "12 of 24 faces are there twice, turned around: an export of two-sided faces, the first again at this line"
    )
    assert (both.place, both.grave) == ("room.obj:112", True)
    (same,) = flaws(ROOM, ROOM[:3])
    assert same.sentence.startswith("3 of 15 faces are there twice, the first again")
    assert flaws(ROOM, np.roll(turned(ROOM), 1, axis=1))[0].sentence == both.sentence


@given(st.floats(-360, 360), st.floats(0.1, 3), st.floats(0.1, 3))
def test_a_turned_mesh_keeps_its_lengths_and_its_winding(yaw_deg, x_m, y_m):
    before, after = box((x_m, y_m, 1.0)), box((x_m, y_m, 1.0)).turned(math.radians(yaw_deg))
    assert np.linalg.norm(after.vertices, axis=1) == pytest.approx(np.linalg.norm(before.vertices, axis=1))
    volumes = [np.linalg.det(one.triangles).sum() for one in (before, after)]
    assert volumes[0] == pytest.approx(volumes[1])
    direction = before.vertices[:, :2] @ np.exp(1j * np.array([0.0, np.pi / 2])) * np.exp(1j * math.radians(yaw_deg))
    assert after.vertices[:, 0] + 1j * after.vertices[:, 1] == pytest.approx(direction)


@pytest.mark.parametrize(
    "text",
    [
        SQUARE.replace("f 1 2 3 4", "f 1 2 \\\n3 4"),
        SQUARE.replace("f 1 2 3 4", "f 1\\\r\n 2\\ \r\n 3 4 # one \\"),
        SQUARE.replace("v 1 0 0", "v 1 \\\n 0 \\\n 0"),
        SQUARE.replace("# two triangles", "# C:\\mines\\"),
        SQUARE.replace("v 0 1 0", "v 0 1 0 # C:\\mines\\"),
        SQUARE.replace("# two triangles", "usemtl C:\\mines\\\no C:\\mines\\"),
    ],
)
def test_a_backslash_at_the_end_of_a_vertex_or_a_face_joins_the_next_line_to_it(read, text):
    form, _, lines, _ = read(text)
    assert np.array_equal(form.triangles, read(SQUARE).mesh.triangles)
    assert lines[0] == 1 + text[: text.index("f 1")].count("\n")


@pytest.mark.parametrize("text", [SQUARE.replace("1 2 3", "1\\2\\3"), SQUARE.replace("4\n", "4 \\\nv 0 0 0\n")])
def test_a_backslash_elsewhere_is_no_white_space(read, text):
    with pytest.raises(InputError, match="must be a vertex"):
        read(text)


@pytest.mark.parametrize(
    ("name", "text", "said"),
    [
        ("a.dae", '<unit name="inch" meter="0.0254"/><up_axis>Z_UP</up_axis>', Stated("z", 0.0254)),
        ("a.dae", "<asset><up_axis> Y_UP</up_axis>", Stated("y", 1.0)),
        ("a.dae", "<unit meter='0.01' name='centimeter'/>", Stated("y", 0.01)),
        ("a.dae", '<unit meter="inf"/><up_axis>X_UP</up_axis>', Stated("y")),
        ("a.dae", '<unit meter="ten"/>', Stated("y")),
        ("a.glb", "", Stated("y", 1.0)),
        ("a.obj", "# unit mm", Stated()),
        ("a.stl", "", Stated()),
    ],
)
def test_a_file_says_its_unit_and_the_axis_that_is_up_or_does_not(name, text, said, tmp_path):
    (tmp_path / name).write_text(text)
    assert stated(tmp_path / name) == said


def test_a_file_that_is_not_there_says_nothing(tmp_path):
    assert stated(tmp_path / "none.dae") == Stated()


@given(st.lists(st.tuples(*[st.floats(-9, 9)] * 3), min_size=1))
def test_points_that_are_turned_up_and_back_are_where_they_were(points):
    assert np.array_equal(turn_back(turn_up(np.array(points))), np.array(points))
    assert turn_up(np.array([0.0, 1.0, 0.0])).tolist() == [0, 0, 1]


@pytest.mark.parametrize("inside_out", [False, True])
def test_an_outer_hull_around_a_mine_is_told_where_a_place_in_the_mine_counts_as_outside(inside_out):
    block, tunnel = box((20.0, 20.0, 9.0)).triangles, turned(ROOM)
    surface = np.concatenate([turned(block), ROOM] if inside_out else [block, tunnel])
    lines = np.arange(1, len(surface) + 1)
    (told,) = surface_flaws(surface, lines, Path("room.obj"), "line", [(0.0, 0.0, 0.0)])
    assert told.sentence.startswith("this closed surface of 12 faces lies around the mine and is wound against it")
    assert (told.place, told.grave) == ("room.obj:1", True)
    assert not list(surface_flaws(surface, lines, Path("room.obj"), "line", [(8.0, 0.0, 0.0)]))  # in the rock
    assert not list(surface_flaws(tunnel, lines[:12], Path("room.obj"), "line", [(0.0, 0.0, 0.0)]))


def _ball(rings):
    """A closed ball of many faces, whose upper half has a name."""
    angles = np.pi * np.arange(rings + 1) / rings
    form = lathe([(abs(math.sin(a)) * (0 < i < rings), -math.cos(a)) for i, a in enumerate(angles)], 2 * rings)
    names = tuple("top" if z > 0 else "" for z in form.triangles[:, :, 2].mean(axis=1))
    return MeshFile(form, names, np.arange(1, len(form.faces) + 1))


@pytest.mark.parametrize("most", [200, 700, 2000])
def test_a_decimated_mesh_has_few_triangles_is_closed_and_keeps_names_and_lines(most):
    file = _ball(40)
    fewer = decimated(file, most, "world.yaml:3")
    assert 0.9 * most <= len(fewer.mesh.faces) <= most
    triangles = fewer.mesh.triangles
    assert not list(surface_flaws(triangles, fewer.lines, Path("ball.obj")))
    assert np.linalg.norm(fewer.mesh.vertices, axis=1) == pytest.approx(1.0, abs=0.1)
    middles = triangles[:, :, 2].mean(axis=1)
    assert all((name == "top") == (z > 0) for name, z in zip(fewer.names, middles, strict=True) if abs(z) > 0.2)
    assert set(fewer.lines) <= set(file.lines)
    again = decimated(file, most, "world.yaml:3")
    assert again.mesh.vertices.tobytes() == fewer.mesh.vertices.tobytes()


def test_a_mesh_that_is_small_already_is_not_decimated():
    file = _ball(10)
    assert decimated(file, len(file.mesh.faces), "world.yaml:3") is file


def test_decimation_without_its_library_is_one_sentence(monkeypatch):
    monkeypatch.setattr("scaloft_fi.sim.mesh.find_spec", lambda _: None)
    with pytest.raises(InputError, match=r"^world.yaml:3: decimate_to=100 needs pip install fast-simplification$"):
        decimated(_ball(10), 100, "world.yaml:3")


def test_an_edge_of_three_faces_is_told_apart_from_a_hole():
    inner = np.array([[ROOM[0][0], ROOM[0][1], [0.0, 0.0, 0.0]]])
    hole, crowd = sorted(flaws(ROOM, inner), key=lambda flaw: flaw.sentence, reverse=True)
    assert hole.sentence.startswith("the surface has holes: 2 edges have no second face")
    assert crowd.sentence.startswith("3 or more faces meet at an edge of 3 faces, the first at this line")
    assert (crowd.place, crowd.grave) == ("room.obj:100", False)
