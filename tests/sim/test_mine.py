from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from scaloft_fi import document
from scaloft_fi.errors import InputError
from scaloft_fi.sim.mine import inside, read_mine

ROOM = """
footprint: [[0, 0], [6, 0], [6, 4], [0, 4]]
pillars: [[[2, 1], [3, 1], [3, 2], [2, 2]]]
height_m: 3
cell_m: 1
roughness_m: 0.1
wall_reflectivity: 0.5
ground_reflectivity: 0.4
"""


def mine(tmp_path, text=ROOM, **changes):
    for old, new in changes.items():
        text = "\n".join(new if line.startswith(f"{old}:") else line for line in text.splitlines())
    (tmp_path / "mine.yaml").write_text(text)
    return read_mine(document.load(tmp_path / "mine.yaml"))


def normals(form):
    a, b, c = (form.triangles[:, i] for i in range(3))
    cross = np.cross(b - a, c - a)
    return form.triangles.mean(axis=1), cross / np.linalg.norm(cross, axis=1)[:, None]


def test_walls_face_the_open_space(tmp_path):
    room = mine(tmp_path)
    for centre, normal in zip(*normals(room.wall), strict=True):
        if 0.3 < centre[2] < 2.7:
            assert room.holds(centre + 0.3 * normal)
            assert not room.holds(centre - 0.3 * normal)


@pytest.mark.parametrize("footprint", ["[[0, 0], [6, 0], [6, 4], [0, 4]]", "[[0, 4], [6, 4], [6, 0], [0, 0]]"])
def test_a_footprint_may_run_either_way(tmp_path, footprint):
    room = mine(tmp_path, footprint=f"footprint: {footprint}")
    centres, directions = normals(room.wall)
    outer = (np.abs(centres[:, 0] - 3) > 2.5) & (np.abs(directions[:, 2]) < 0.5)
    assert np.all(((np.array([3, 2]) - centres[outer, :2]) * directions[outer, :2]).sum(axis=1) > 0)


def test_roughness_moves_walls_by_no_more_than_it_says_and_always_alike(tmp_path):
    rough, again, smooth = mine(tmp_path), mine(tmp_path), mine(tmp_path, roughness_m="roughness_m: 0")
    moved = np.linalg.norm(rough.wall.vertices - smooth.wall.vertices, axis=1)
    assert 0 < moved.max() <= 0.1 * np.sqrt(2) + 1e-12
    assert np.array_equal(rough.wall.vertices, again.wall.vertices)


def test_open_space_is_inside_the_footprint_outside_the_pillars_below_the_ceiling(tmp_path):
    room = mine(tmp_path)
    assert room.holds((1, 1, 1.5))
    for point in ((2.5, 1.5, 1.5), (7, 1, 1.5), (1, 1, 3.5), (1, 1, -0.5)):
        assert not room.holds(point)


def test_the_rock_that_stands_out_of_a_rough_wall_is_not_open_space(tmp_path):
    room = mine(tmp_path)
    grid = room.wall.vertices
    out = grid[
        (grid[:, 0] > 0.02) & (grid[:, 0] < 0.1) & (np.abs(grid[:, 1] - 2) < 1.5) & (np.abs(grid[:, 2] - 1.5) < 1)
    ]
    assert len(out)
    for x, y, z in out:
        assert not room.holds((x - 0.01, y, z))
        assert room.holds((x + 0.01, y, z))


def test_the_floor_is_at_height_0(tmp_path):
    assert mine(tmp_path).floor_m(1, 1) == 0


@given(st.floats(-3, 9), st.floats(-3, 7))
def test_a_point_is_in_a_rectangle_by_comparison(x, y):
    ring = ((0.0, 0.0), (6.0, 0.0), (6.0, 4.0), (0.0, 4.0))
    if min(abs(x), abs(x - 6), abs(y), abs(y - 4)) > 1e-9:
        assert inside(list(zip(ring, ring[1:] + ring[:1], strict=True)), x, y) == (0 < x < 6 and 0 < y < 4)


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"footprint": "footprint: [[0, 0], [6, 0]]"}, "at least 3 corners"),
        ({"footprint": "footprint: [[0, 0], [3, 0], [6, 0]]"}, "enclose an area"),
        ({"footprint": "footprint: [[0, 0], [0, 0], [6, 0], [6, 4]]"}, "corner twice"),
        ({"footprint": "footprint: [[0, 0], [6, 0], [2, 5], [4, 5]]"}, "cross"),
        ({"height_m": "height_m: -3"}, "height_m=-3 must be > 0"),
        ({"roughness_m": "roughness_m: 0.9"}, "roughness_m=0.9 must be"),
        ({"wall_reflectivity": "wall_reflectivity: 2"}, "wall_reflectivity=2 must be"),
        ({"cell_m": "cel_m: 1"}, "unknown key 'cel_m' in mine.yaml; did you mean 'cell_m'?"),
        ({"height_m": "height_m: 3\nheight: 3"}, "unknown key 'height'"),
    ],
)
def test_a_mine_that_cannot_be_is_refused(tmp_path, change, sentence):
    with pytest.raises(InputError) as error:
        mine(tmp_path, **change)
    assert sentence in str(error.value)
    assert "mine.yaml:" in str(error.value)


@pytest.mark.parametrize(
    ("point", "direction", "place", "inward"),
    [
        ((1.0, 1.5, 1.0), (1.0, 0.0), (2.0, 1.5), (-1.0, 0.0)),  # the pillar stands before the wall
        ((1.0, 3.0, 1.0), (1.0, 0.0), (6.0, 3.0), (-1.0, 0.0)),
        ((4.0, 1.5, 1.0), (-2.0, 0.0), (3.0, 1.5), (1.0, 0.0)),  # the length of the direction does not matter
        ((4.0, 1.0, 1.0), (0.0, -1.0), (4.0, 0.0), (0.0, 1.0)),
    ],
)
def test_the_wall_in_a_direction_is_the_nearest_and_faces_the_point(tmp_path, point, direction, place, inward):
    wall = mine(tmp_path).wall_towards(point, direction)
    assert wall.place == pytest.approx(place)
    assert wall.inward == pytest.approx(inward)


def test_the_wall_of_a_mesh_is_its_section_at_the_height_of_the_point(tmp_path):
    extruded = mine(tmp_path, roughness_m="roughness_m: 0")
    mesh = replace(extruded, footprint=())
    seen = extruded.wall_towards((1.0, 1.3, 1.1), (1.0, 0.2))
    again = mesh.wall_towards((1.0, 1.3, 1.1), (1.0, 0.2))
    assert again.place == pytest.approx(seen.place)
    assert again.inward == pytest.approx(seen.inward)


def test_outside_of_the_mine_there_may_be_no_wall(tmp_path):
    assert mine(tmp_path).wall_towards((7.0, 2.0, 1.0), (1.0, 0.0)) is None
