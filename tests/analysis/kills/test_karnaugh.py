from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from itertools import product

import pytest
from builders import GRID, ROSTER, outcome, pool, seeded
from hypothesis import given, settings

from scaloft_fi.analysis.condition import condition
from scaloft_fi.analysis.kills.karnaugh import KarnaughMap, karnaugh_map
from scaloft_fi.analysis.kills.kill_matrix import Row, kill_matrix
from scaloft_fi.analysis.scoring.score import score
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.judge.space import Space
from scaloft_fi.views.pictures.karnaugh_picture import draw_karnaugh
from scaloft_fi.views.pictures.picture import png

LATE = "LATE-human@3s"


def row_of(outcomes: list[Outcome], space: Space = GRID) -> Row:
    return kill_matrix(score(outcomes, ROSTER, space), ROSTER, space).row[LATE]


def map_of(row: Row, space: Space = GRID) -> KarnaughMap:
    return karnaugh_map(space, row, condition(space, row.killing, row.surviving))


def flown(space: Space, killing: set[str]) -> list[Outcome]:
    late = [outcome(LATE, key, violated={"SR2": 9.0} if key in killing else {}) for key in space.point]
    return [*pool(*space.point), *late]


HUMAN_IN_LIGHT = {key for key in GRID.point if "D0" in key and "H1" in key}
THREE = Space(
    axes=("light", "<floor & walls>", "people"),
    values=(("0", "1", "2"), ("0", "1", "2"), ("0", "1")),
    words=(("bright", "dim", "dark"), ("dry", "wet", 'a "very" long & <strange> word'), ("nobody", "human")),
    points=tuple((f"L{a}F{b}P{c}", (a, b, c)) for a, b, c in product("012", "012", "01") if (a, b) != ("2", "2")),
)


def test_five_axes_make_four_rows_of_eight_and_every_situation_is_on_the_map_once() -> None:
    found = map_of(row_of(flown(GRID, HUMAN_IN_LIGHT)))
    assert [len(keys) for keys in found.keys] == [8] * 4
    assert sorted(key for keys in found.keys for key in keys if key) == sorted(GRID.point)


def test_neighbours_on_the_map_differ_on_one_axis_also_across_its_edges() -> None:
    found = map_of(row_of(flown(GRID, HUMAN_IN_LIGHT)))
    for r, c in product(range(4), range(8)):
        for other in (found.keys[(r + 1) % 4][c], found.keys[r][(c + 1) % 8]):
            here, there = GRID.point[found.keys[r][c] or ""], GRID.point[other or ""]
            assert sum(a != b for a, b in zip(here, there, strict=True)) == 1


@settings(deadline=None, max_examples=30)
@given(seeded())
def test_the_blocks_hold_every_kill_and_no_survivor(outcomes: list[Outcome]) -> None:
    for row in kill_matrix(score(outcomes, ROSTER, GRID), ROSTER, GRID).rows:
        found = map_of(row)
        inside = {found.keys[r][c] for block in found.blocks for r, c in block.places}
        assert set(row.killing) <= inside
        assert not set(row.surviving) & inside
        ET.fromstring(draw_karnaugh(GRID, found, row))


def test_the_picture_names_states_axes_and_terms_and_can_be_drawn() -> None:
    row = row_of(flown(GRID, HUMAN_IN_LIGHT))
    svg = draw_karnaugh(GRID, map_of(row), row)
    assert svg.count(">killed<") == 8
    assert svg.count(">survived<") == 24
    assert ">human &amp; light<" in svg
    assert all(f">{axis}<" in svg for axis in GRID.axes)
    assert png(svg).startswith(b"\x89PNG")


def test_a_violation_that_decides_nothing_is_seen_and_not_killed() -> None:
    row = row_of(flown(GRID, {"T0O0W0D0H1"}))
    svg = draw_karnaugh(GRID, map_of(row), row)
    assert (svg.count(">seen<"), svg.count(">killed<")) == (1, 0)
    assert "T0O0W0D0H1: seen, SR2 violated in 1 of 1 flights" in svg
    assert "Killed nowhere." in svg


def test_a_situation_without_a_steady_requirement_says_so() -> None:
    late = [*pool("T0O0W0D0H1", red=10, violated={"SR1": 30.0}, struck="bar"), outcome(LATE, "T0O0W0D0H1")]
    row = row_of(late)
    assert "survived, no safety requirement is steady here" in draw_karnaugh(GRID, map_of(row), row)


def test_a_mutant_killed_nowhere_has_a_map_that_says_so() -> None:
    row = row_of(flown(GRID, set()))
    assert "Killed nowhere." in draw_karnaugh(GRID, map_of(row), row)


def test_axes_of_three_values_constraints_and_hostile_words_are_drawn() -> None:
    row = row_of(flown(THREE, {key for key in THREE.point if "L1" in key or "F1" in key}), THREE)
    found = map_of(row, THREE)
    svg = draw_karnaugh(THREE, found, row)
    assert sum(key is None for keys in found.keys for key in keys) == 2
    assert "<strange>" not in svg
    assert "&lt;strange&gt;" in svg
    assert "opposite edges" not in svg
    ET.fromstring(svg)


def edges(killing: set[str], space: Space = GRID) -> tuple[int, int]:
    """Horizontal and vertical pieces of the outlines, without their halos."""
    row = row_of(flown(space, killing), space)
    svg = draw_karnaugh(space, map_of(row, space), row)
    return len(re.findall(r",[\d.]+H", svg)) // 2, len(re.findall(r",[\d.]+V", svg)) // 2


def test_an_outline_is_open_where_its_block_goes_on_at_the_opposite_edge() -> None:
    # light: columns 0, 1 and 6, 7 of all four rows, one block across the edge
    assert edges({key for key in GRID.point if "D0" in key}) == (2 * 4, 2 * 4)
    # dark: columns 2 to 5
    assert edges({key for key in GRID.point if "D1" in key}) == (2 * 4, 2 * 4)
    assert edges(set(GRID.point)) == (2 * 8, 2 * 4)
    assert edges(HUMAN_IN_LIGHT) == (2 * 2, 4 * 4)


def test_where_opposite_edges_are_no_neighbours_every_outline_is_shut() -> None:
    # columns 0, 1 and 4, 5 of 6: the last differs from the first on two axes
    assert edges({key for key in THREE.point if "F1" not in key}, THREE) == (2 * 4, 4 * 3)


def test_a_grid_too_large_to_read_is_refused_in_a_sentence() -> None:
    many = tuple("abcdefgh")
    wide = Space(tuple("xyzw"), (many,) * 4, (many,) * 4, ())
    with pytest.raises(ValueError, match="4096 situations would not be read; at most 512"):
        karnaugh_map(wide, row_of(flown(GRID, set())), "")
