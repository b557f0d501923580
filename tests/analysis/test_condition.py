from __future__ import annotations

from itertools import product

import pytest
from builders import GRID, RANGED, drawn
from hypothesis import given
from hypothesis import strategies as st

from scaloft_fi.analysis.kill_matrix import order
from scaloft_fi.analysis.score import admits, condition, cover
from scaloft_fi.judge.space import Space

KEYS = [key for key, _ in GRID.points]
THREE = Space(
    axes=("light", "floor"),
    values=(("0", "1", "2"), ("0", "1")),
    words=(("bright", "dim", "dark"), ("dry", "wet")),
    points=tuple((f"L{a}F{b}", (a, b)) for a, b in product("012", "01")),
)


def where(**fixed: str) -> list[str]:
    return [key for key, point in GRID.points if all(point[GRID.axes.index(a)] == v for a, v in fixed.items())]


def but(keys: list[str]) -> list[str]:
    return [key for key in KEYS if key not in keys]


def test_a_block_of_the_grid_is_the_axes_that_are_fixed_in_it():
    killing = where(D="0", H="1")
    assert condition(GRID, killing, but(killing)) == "human & light"


def test_nothing_is_said_of_a_mutant_that_is_killed_nowhere():
    assert condition(GRID, [], KEYS) == ""


def test_everywhere_is_everywhere():
    assert condition(GRID, KEYS, []) == "everywhere"
    assert condition(GRID, KEYS[:1], []) == "wherever tested"


def test_two_blocks_are_joined():
    killing = sorted({*where(H="1"), *where(T="1", O="1")})
    assert condition(GRID, killing, but(killing)) == "human or (obstacle & corner)"


def test_where_nothing_is_known_the_condition_may_fall_either_way():
    # light with a person is killed, light without survives; of the dark nothing is known
    assert condition(GRID, where(D="0", H="1"), where(D="0", H="0")) == "human"


def test_a_point_is_all_its_values():
    assert condition(GRID, ["T0O0W0D0H1"], but(["T0O0W0D0H1"])) == "human & light & wide & clear & straight"


def test_an_axis_of_three_values_names_those_that_kill():
    keys = [key for key, _ in THREE.points]
    dim_or_dark = [key for key in keys if key[1] in "12"]
    assert condition(THREE, dim_or_dark, [key for key in keys if key not in dim_or_dark]) == "dim or dark"
    assert condition(THREE, ["L2F1"], [key for key in keys if key != "L2F1"]) == "wet & dark"


def test_a_situation_cannot_both_kill_and_be_survived():
    with pytest.raises(ValueError, match="both killing and surviving"):
        condition(GRID, KEYS[:2], KEYS[1:3])


def with_fate(fates: list[str], wanted: str) -> list[str]:
    return [key for key, fate in zip(KEYS, fates, strict=True) if fate == wanted]


split = st.lists(st.sampled_from(["kill", "survive", "unknown"]), min_size=32, max_size=32)


@given(split)
def test_the_condition_covers_every_kill_and_no_survivor(fates: list[str]):
    killing, surviving = with_fate(fates, "kill"), with_fate(fates, "survive")
    terms = cover(GRID, killing, surviving)
    covered = {key for key, point in GRID.points if any(admits(term, point) for term in terms)}
    assert set(killing) <= covered
    assert not covered & set(surviving)
    assert len(terms) <= max(1, len(killing))


@given(split)
def test_no_term_of_the_condition_could_be_left_out_or_widened(fates: list[str]):
    killing, surviving = with_fate(fates, "kill"), with_fate(fates, "survive")
    terms = cover(GRID, killing, surviving)
    for term in terms:
        others = [other for other in terms if other != term]
        assert any(not any(admits(other, GRID.point[key]) for other in others) for key in killing)
        for axis, values in enumerate(GRID.values):
            wider = (*term[:axis], frozenset(values), *term[axis + 1 :])
            assert wider == term or any(admits(wider, GRID.point[key]) for key in surviving)


@given(split)
def test_the_way_for_large_grids_finds_what_the_way_for_small_ones_finds(fates: list[str]):
    killing, surviving = with_fate(fates, "kill"), with_fate(fates, "survive")
    with pytest.MonkeyPatch.context() as patch:
        found = cover(GRID, killing, surviving)
        patch.setattr("scaloft_fi.analysis.score.MOST_BOXES", 0)
        assert cover(GRID, killing, surviving) == found


def test_ten_axes_of_three_values_are_answered_at_once():
    values = tuple("abc")
    points = tuple(("".join(p), p) for p in product(values, repeat=10))
    wide = Space(tuple("qrstuvwxyz"), (values,) * 10, (values,) * 10, points)
    flown = [key for key, _ in points[::97]]
    killing = [key for key in flown if key[3] == "b" and key[7] == "c"]
    assert condition(wide, killing, [key for key in flown if key not in killing]) == "c & b"


def test_many_axes_of_many_values_are_still_answered():
    values = tuple("abcd")
    points = tuple(("".join(p), p) for p in product(values, repeat=5))
    wide = Space(tuple("vwxyz"), (values,) * 5, (values,) * 5, points)
    keys = [key for key, _ in points]
    assert condition(wide, [k for k in keys if k[0] == "a"], [k for k in keys if k[0] != "a"]) == "a"


def test_numbers_of_a_bin_count_as_the_bin_and_one_kill_as_a_kill():
    killing = [drawn(key, 0.5) for key, point in GRID.points if point[4] == "1"]
    surviving = [drawn(key, 0.9) for key, _ in GRID.points]
    assert condition(RANGED, killing, surviving) == "human"
    assert condition(RANGED, [drawn(key, 0.1) for key, _ in GRID.points], surviving) == "everywhere"
    assert order(RANGED, killing, surviving) == 1
