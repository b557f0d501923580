"""The rock between the walls of a ground plan, and of a user's mesh."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from studies import item_of

from scaloft_fi.sim.mine import inside, read_mine

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
