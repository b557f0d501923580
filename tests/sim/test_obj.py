"""Meshes from OBJ files, and their limits."""

from __future__ import annotations

import numpy as np
import pytest

from scaloft_fi.document import load
from scaloft_fi.errors import InputError
from scaloft_fi.model import read
from scaloft_fi.sim.mesh import MeshLimits, read_obj


def test_an_obj_file_is_read_with_quads_negative_indices_and_objects(tmp_path):
    path = tmp_path / "mine.obj"
    path.write_text(
        "# a square and a triangle\no floor\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1/1/1 2/2/1 3/3/1 4/4/1\n"
        "g roof top\nv 0 0 1\nf -1 1 2\n"
    )
    form, names = read_obj(path, "world.yaml:3", 2.0)
    assert names == ("floor", "floor", "roof top")
    assert np.array_equal(form.triangles[2], [[0, 0, 2], [0, 0, 0], [2, 0, 0]])


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("v 0 0\nf 1 1 1\n", ":1: 'v 0 0' must be a vertex"),
        ("v 0 0 nan\n", ":1: 'v 0 0 nan' must be"),
        ("v 0 0 0\nf 1 2 3\n", ":2: 'f 1 2 3' must be"),
        ("v 0 0 0\nv 0 0 1\nf 1 2\n", ":3: 'f 1 2' must be"),
        ("v 0 0 0\nf 0 1 1\n", ":2: 'f 0 1 1' must be"),
        ("v 0 0 0\n", "world.yaml:3: mesh="),
    ],
)
def test_a_broken_obj_file_is_refused_with_its_line(tmp_path, text, sentence):
    path = tmp_path / "mine.obj"
    path.write_text(text)
    with pytest.raises(InputError, match="must") as error:
        read_obj(path, "world.yaml:3", 1.0)
    assert sentence in str(error.value)


@pytest.mark.parametrize("content", [None, b"\xff\xfe\x00"])
def test_an_unreadable_obj_file_is_refused_with_the_place_that_names_it(tmp_path, content):
    path = tmp_path / "mine.obj"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(InputError, match=r"^world.yaml:3: mesh=.* cannot be read"):
        read_obj(path, "world.yaml:3", 1.0)


SQUARE = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n# two triangles\nf 1 2 3 4\n"


@pytest.mark.parametrize(
    ("limits", "sentence"),
    [
        (MeshLimits(triangles=1), ":4: the mesh must have at most 1 triangles"),
        (MeshLimits(corners=3), ":6: a face must have at most 3 corners"),
        (MeshLimits(size_bytes=len(SQUARE) - 1), f"larger than {len(SQUARE) - 1} bytes"),
    ],
)
def test_a_limit_is_told_with_the_setting_that_raises_it(tmp_path, limits, sentence):
    path = tmp_path / "mine.obj"
    path.write_text(SQUARE)
    with pytest.raises(InputError) as error:
        read_obj(path, "world.yaml:3", 1.0, limits)
    assert sentence in str(error.value)
    assert "`mesh_limits: {" in str(error.value)


def test_a_mesh_at_its_limits_is_read_with_line_ends_of_any_system(tmp_path):
    path = tmp_path / "mine.obj"
    limits = MeshLimits(size_bytes=100, triangles=2, corners=4)
    for end in ("\n", "\r\n", "\r"):
        path.write_bytes(SQUARE.replace("\n", end).encode())
        assert len(read_obj(path, "", 1.0, limits)[0].faces) == 2


def test_limits_are_raised_in_the_study(tmp_path):
    (tmp_path / "a.yaml").write_text("triangles: 5000000\n")
    assert read(MeshLimits, load(tmp_path / "a.yaml")) == MeshLimits(triangles=5_000_000)
