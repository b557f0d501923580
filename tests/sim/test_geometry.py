from __future__ import annotations

import math

import numpy as np
from hypothesis import assume, given
from hypothesis import strategies as st

from scaloft_fi.sim import mesh
from scaloft_fi.sim.build import blocked, nearest, outside

points = st.tuples(*[st.floats(-2, 2)] * 3).map(np.array)
FORM = mesh.join([mesh.box((0.5, 0.6, 0.7)), mesh.capsule(0.2, 1.0).moved((0.9, 0.2, 0.1))])
OWNER = np.repeat(np.array([0, 1], np.int16), [12, len(FORM.faces) - 12])


def box_distance(point, size):
    outside = np.maximum(np.abs(point) - np.array(size) / 2, 0)
    inside = min(np.min(np.array(size) / 2 - np.abs(point)), math.inf)
    return float(np.linalg.norm(outside)) if outside.any() else float(inside)


@given(points)
def test_the_nearest_point_of_a_box_is_as_far_as_the_formula_says(point):
    found = np.empty(3)
    distance = nearest(FORM.vertices, FORM.faces, OWNER, 0, point, found)
    assert math.isclose(distance, box_distance(point, (0.5, 0.6, 0.7)), abs_tol=1e-9)
    assert math.isclose(float(np.linalg.norm(found - point)), distance, abs_tol=1e-9)


@given(points)
def test_no_corner_or_point_inside_a_face_is_nearer_than_the_nearest(point):
    found = np.empty(3)
    distance = nearest(FORM.vertices, FORM.faces, OWNER, 1, point, found)
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
    nearest_point = np.clip(point, 0.0, size)
    assert math.isclose(found[0], float(np.linalg.norm(nearest_point - point)), abs_tol=1e-12)
    assert found[1] == 0.0
