from __future__ import annotations

import math
from collections import Counter

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from scaloft_fi.errors import InputError
from scaloft_fi.sim import mesh

sizes = st.floats(0.1, 3.0)

SHAPES = {
    "box": mesh.box((0.5, 0.4, 1.8)),
    "cylinder": mesh.cylinder(0.03, 2.7),
    "capsule": mesh.capsule(0.25, 1.7),
    "ball": mesh.capsule(0.25, 0.5),
}


def volume(form: mesh.Mesh) -> float:
    a, b, c = (form.triangles[:, i] for i in range(3))
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6)


@pytest.mark.parametrize("name", SHAPES)
def test_every_shape_is_closed_and_wound_outwards(name):
    form = SHAPES[name]
    edges = Counter((a, b) for face in form.faces.tolist() for a, b in zip(face, face[1:] + face[:1], strict=True))
    assert all(edges[b, a] == count == 1 for (a, b), count in edges.items())
    assert volume(form) > 0


@pytest.mark.parametrize("name", SHAPES)
def test_no_face_of_a_shape_is_without_area(name):
    a, b, c = (SHAPES[name].triangles[:, i] for i in range(3))
    assert np.linalg.norm(np.cross(b - a, c - a), axis=1).min() > 1e-6


@given(sizes, sizes, sizes)
def test_a_box_has_its_size_and_volume(x, y, z):
    form = mesh.box((x, y, z))
    assert np.allclose(np.ptp(form.vertices, axis=0), (x, y, z))
    assert math.isclose(volume(form), x * y * z, rel_tol=1e-9)


@given(sizes, sizes)
def test_a_capsule_has_its_height_over_all(radius, waist):
    form = mesh.capsule(radius, 2 * radius + waist)
    assert math.isclose(np.ptp(form.vertices[:, 2]), 2 * radius + waist)
    assert math.isclose(np.linalg.norm(form.vertices[:, :2], axis=1).max(), radius)


@given(st.tuples(sizes, sizes, sizes), st.tuples(*[st.floats(-2, 2)] * 3))
def test_the_winding_number_tells_inside_from_outside(size, point):
    offset = np.abs(point) - np.array(size) / 2
    if np.abs(offset).min() < 1e-3:
        return
    inside = bool((offset < 0).all())
    assert math.isclose(mesh.winding(mesh.box(size).triangles, point), float(inside), abs_tol=1e-6)
    assert mesh.box(size).encloses(point) == inside


def test_heights_are_those_where_the_upright_line_meets_the_surface():
    heights = mesh.heights_at(mesh.box((1, 1, 2)).triangles, 0.1, 0.3)
    assert sorted(set(np.round(heights, 9))) == [-1, 1]
    assert len(mesh.heights_at(mesh.box((1, 1, 2)).triangles, 0.6, 0.3)) == 0


def test_a_section_of_a_box_runs_along_its_four_sides():
    segments = mesh.section(mesh.box((2, 1, 1)).triangles, 0.1)
    length = sum(math.dist(p, q) for p, q in segments)
    assert math.isclose(length, 6)


def test_joining_keeps_every_triangle():
    parts = list(SHAPES.values())
    assert np.array_equal(mesh.join(parts).triangles, np.concatenate([part.triangles for part in parts]))


def test_without_a_name_the_floor_is_what_is_level_and_has_nothing_below():
    form = mesh.box((4, 4, 3))
    rock, floor = mesh.split_floor(form, [""] * len(form.faces), [], "world.yaml:3")
    assert (len(rock.faces), len(floor.faces)) == (10, 2)
    assert np.all(floor.vertices[:, 2] == -1.5)


def test_a_floor_name_that_the_mesh_lacks_is_refused_with_the_nearest():
    form = mesh.box((4, 4, 3))
    with pytest.raises(InputError, match=r"world.yaml:3: ground='flor' is no object of the mesh; did you mean 'floor'"):
        mesh.split_floor(form, ["floor"] * len(form.faces), ["flor"], "world.yaml:3")


def test_a_mesh_that_is_all_floor_is_refused():
    form = mesh.box((4, 4, 3))
    with pytest.raises(InputError, match="must have a floor and walls"):
        mesh.split_floor(form, ["floor"] * len(form.faces), ["floor"], "world.yaml:3")


def test_the_lowest_level_faces_are_the_floor_however_many_columns_there_are(monkeypatch):
    rng = np.random.default_rng(0)
    layers = [mesh.box((8, 8, 0.1)).moved((0, 0, z)) for z in (0.0, 3.0)]
    bumps = [mesh.box(rng.uniform(0.1, 3.0, 3)).moved(rng.uniform(-4, 4, 3)) for _ in range(60)]
    form = mesh.join([*layers, *bumps])
    names = [""] * len(form.faces)
    monkeypatch.setattr(mesh, "COLUMNS", 1)
    whole = mesh.split_floor(form, names, [], "")
    for columns in (2, 7, 128):
        monkeypatch.setattr(mesh, "COLUMNS", columns)
        for part, same in zip(mesh.split_floor(form, names, [], ""), whole, strict=True):
            assert np.array_equal(part.triangles, same.triangles)
    monkeypatch.setattr(mesh, "MOST_PAIRS", 1000)
    with pytest.raises(InputError, match="overlap too often; name the floor's objects under `ground`"):
        mesh.split_floor(form, names, [], "world.yaml:3")
