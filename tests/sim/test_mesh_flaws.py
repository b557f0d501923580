from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from scaloft_fi.sim.mesh import Array, Flaw, MeshLimits, box, cylinder, lines_of_faces, read_obj, surface_flaws

FILE = Path("room.obj")
ROOM = box((4.0, 6.0, 3.0)).triangles
PILLAR = cylinder(0.3, 1.0).triangles


def flaws(*parts: Array) -> list[Flaw]:
    """The flaws of triangles whose lines count from 100."""
    triangles = np.concatenate(parts)
    return list(surface_flaws(triangles, np.arange(100, 100 + len(triangles)), FILE))


def turned(triangles: Array, *which: int) -> Array:
    changed = triangles.copy()
    for face in which or range(len(changed)):
        changed[face] = changed[face, ::-1]
    return changed


def test_a_closed_surface_has_no_flaw_whichever_way_it_is_wound() -> None:
    assert flaws(ROOM) == flaws(turned(ROOM)) == []


def test_vertices_that_stand_at_one_place_are_one() -> None:
    assert flaws(ROOM + 1e-8) == []


@pytest.mark.parametrize("room", [ROOM, turned(ROOM)])
def test_the_fewer_faces_are_the_turned_ones_and_a_neighbour_is_named(room: Array) -> None:
    (flaw,) = flaws(turned(room, 3, 7))
    assert flaw.grave
    assert flaw.place == "room.obj:103"
    assert flaw.sentence.startswith(
        "2 of 12 faces are wound the other way than their neighbours, the first at this line"
    )
    assert flaw.sentence.endswith("at line 104")


def test_a_pillar_is_wound_against_the_room_around_it() -> None:
    assert flaws(ROOM, turned(PILLAR)) == []
    (flaw,) = flaws(ROOM, PILLAR)
    assert (flaw.grave, flaw.place) == (True, "room.obj:112")
    assert "lies within another and is wound like it" in flaw.sentence


@pytest.mark.parametrize("top_first", [False, True])
@pytest.mark.parametrize(("low_m", "high_m"), [(0.0, 1.0), (-0.05, 1.0), (0.0, 3.0), (-0.05, 3.05)])
def test_a_pillar_that_touches_floor_or_roof_or_enters_them_is_told_too(
    low_m: float, high_m: float, top_first: bool
) -> None:
    pillar = box((0.5, 0.5, high_m - low_m)).triangles
    moved = pillar + np.array([0.4, 0.3, ROOM[:, :, 2].min() + low_m - pillar[:, :, 2].min()])
    height_m = moved[:, :, 2].mean(axis=1)
    moved = moved[np.argsort(-height_m if top_first else height_m)]  # whichever face the file names first
    assert flaws(ROOM, turned(moved)) == []
    (flaw,) = flaws(ROOM, moved)
    assert (flaw.grave, flaw.place) == (True, "room.obj:112")


@pytest.mark.parametrize("share_beyond", [0.4, 0.5, 0.9])
def test_a_second_room_that_overlaps_the_first_may_be_wound_as_it_is(share_beyond: float) -> None:
    alcove = box((1.0, 1.0, 1.0)).triangles
    east_m = ROOM[:, :, 0].max() - alcove[:, :, 0].max() + share_beyond
    height_m = ROOM[:, :, 2].min() - alcove[:, :, 2].min() + 0.5
    assert flaws(ROOM, alcove + np.array([east_m, 0.0, height_m])) == []


def test_a_second_room_beside_the_first_may_be_wound_as_it_is() -> None:
    assert flaws(ROOM, ROOM + np.array([10.0, 0.0, 0.0])) == []


def test_a_hole_is_told_with_the_edge_that_it_begins_at_and_is_not_grave() -> None:
    (flaw,) = flaws(ROOM[1:])
    assert not flaw.grave
    assert flaw.sentence.startswith("the surface has holes: 3 edges have no second face")


def test_faces_without_area_are_told_first_and_do_not_disturb() -> None:
    point = np.zeros((1, 3, 3))
    (flaw,) = flaws(ROOM, point)
    assert (flaw.place, flaw.grave) == ("room.obj:112", False)
    assert flaws(point)[0].sentence.startswith("1 of 1 faces is without area")


def test_a_surface_with_one_side_is_told() -> None:
    turn = np.linspace(0.0, 2.0 * np.pi, 13)
    middle = np.stack([np.cos(turn), np.sin(turn), 0.0 * turn], axis=1)
    half = np.stack([np.cos(turn) * np.cos(turn / 2), np.sin(turn) * np.cos(turn / 2), np.sin(turn / 2)], axis=1) * 0.3
    one, other = middle + half, middle - half
    strip = [f for i in range(12) for f in ((one[i], other[i], one[i + 1]), (other[i], other[i + 1], one[i + 1]))]
    assert any("one side only" in flaw.sentence for flaw in flaws(np.array(strip)))


def test_every_triangle_has_the_line_of_its_face(tmp_path: Path) -> None:
    path = tmp_path / "room.obj"
    path.write_text(
        "# a room\r\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n\no floor\nf 1 2 3 4 # two triangles\ng x\nf 1 2 3\n"
    )
    mesh, _ = read_obj(path, "world.yaml:1", 1.0)
    assert lines_of_faces(path, MeshLimits()).tolist() == [8, 8, 10]
    assert len(mesh.faces) == 3
