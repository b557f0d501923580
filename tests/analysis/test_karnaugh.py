from __future__ import annotations

from itertools import pairwise, product

from builders import GRID

from scaloft_fi.analysis.kill_matrix import cyclic, fold
from scaloft_fi.judge.space import Space

THREE = Space(
    axes=("light", "floor", "people"),
    values=(("0", "1", "2"), ("0", "1", "2"), ("0", "1")),
    words=(("bright", "dim", "dark"), ("dry", "wet", "gone"), ("nobody", "human")),
    points=tuple((f"L{a}F{b}P{c}", (a, b, c)) for a, b, c in product("012", "012", "01") if (a, b) != ("2", "2")),
)


def test_five_axes_make_four_rows_of_eight_and_every_situation_is_on_the_map_once() -> None:
    folded = fold(GRID)
    assert [len(keys) for keys in folded.keys] == [8] * 4
    assert sorted(key for keys in folded.keys for key in keys if key) == sorted(GRID.point)


def test_neighbours_on_the_map_differ_on_one_axis_also_across_its_edges() -> None:
    folded = fold(GRID)
    assert cyclic(folded.rows)
    assert cyclic(folded.columns)
    for r, c in product(range(4), range(8)):
        for other in (folded.keys[(r + 1) % 4][c], folded.keys[r][(c + 1) % 8]):
            here, there = GRID.point[folded.keys[r][c] or ""], GRID.point[other or ""]
            assert sum(a != b for a, b in zip(here, there, strict=True)) == 1


def test_axes_of_three_values_fold_too_and_what_a_constraint_excludes_is_empty() -> None:
    folded = fold(THREE)
    assert sorted(key for keys in folded.keys for key in keys if key) == sorted(THREE.point)
    assert sum(key is None for keys in folded.keys for key in keys) == 2
    for side in (folded.rows, folded.columns):
        assert all(sum(a != b for a, b in zip(*pair, strict=True)) == 1 for pair in pairwise(side))
    assert not cyclic(folded.columns)
