"""Coverage of the grid and of combinations, and situations chosen to cover."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest
from builders import FIVE, GRID, RANGED, drawn, keys_of, outcome, space_of, spaces
from hypothesis import given, settings
from hypothesis import strategies as st
from options import usually

from scaloft_fi.analysis.coverage import coverage, covering_array, forbidden, levels_of, t_way, table
from scaloft_fi.analysis.roster import Ratio
from scaloft_fi.errors import InputError
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.judge.space import Space

KEYS = [key for key, _ in GRID.points]


@pytest.mark.parametrize(("strength", "combinations_"), [(1, 10), (2, 40), (3, 80), (4, 80), (5, 32)])
def test_the_whole_grid_covers_every_combination(strength: int, combinations_: int):
    assert t_way(KEYS, GRID, strength).total == Ratio(combinations_, combinations_)


def test_six_situations_cover_every_pair():
    # the smallest pairwise suite of five binary axes
    suite = [
        "".join(f"{a}{v}" for a, v in zip("TOWDH", p, strict=True))
        for p in ("00000", "01000", "10011", "11101", "00111", "11110")
    ]
    assert t_way(suite, GRID, 2).total == Ratio(40, 40)
    assert t_way(suite, GRID, 5).total == Ratio(6, 32)


def test_one_situation_covers_one_combination_of_each_choice_of_axes():
    assert [t_way(KEYS[:1], GRID, t).total.part for t in (1, 2, 3, 4, 5)] == [5, 10, 10, 5, 1]


def test_more_axes_than_there_are_cover_nothing_of_nothing():
    assert t_way(KEYS, GRID, 6).total == Ratio(0, 0)


@given(st.dictionaries(st.sampled_from(KEYS), st.floats(0, 1, exclude_max=True), min_size=1), st.booleans())
def test_drawn_numbers_cover_what_their_bins_cover(shares: dict[str, float], mutated: bool):
    def flown(keys: list[str]) -> list[Outcome]:
        clean = [outcome(situation=key, realised=place % 2 == 0) for place, key in enumerate(keys)]
        return clean + [outcome("LATE-human@3s", key) for key in keys if mutated]

    binned = coverage(flown(list(shares)), RANGED)
    assert coverage(flown([drawn(*entry) for entry in shares.items()]), RANGED) == binned


def test_two_numbers_of_a_bin_cover_one_situation_in_two_draws():
    keys = [drawn(KEYS[1], share) for share in (0.1, 0.9)]
    found = coverage([outcome(situation=key) for key in keys], RANGED)
    assert (found.situations, found.draws, found.realised) == (Ratio(1, 32), 2, Ratio(1, 32))


def test_a_found_situation_beside_that_of_its_point_counts_as_one_of_its_own():
    found = f"{KEYS[1]}Cs=0.8"
    space = replace(GRID, points=(*GRID.points, (found, GRID.point[KEYS[1]])))
    whole = coverage([outcome(situation=key) for key in (*KEYS, found)], space)
    assert (whole.situations, whole.realised, whole.t_way[1][1]) == (Ratio(33, 33), Ratio(33, 33), Ratio(40, 40))
    assert coverage([outcome(situation=key) for key in KEYS], space).situations == Ratio(32, 33)


def by_hand(keys: list[str], space: Space, strength: int) -> list[int]:
    return [
        len({tuple(space.point[key][axis] for axis in axes) for key in keys})
        for axes in combinations(range(len(space.axes)), strength)
    ]


@given(spaces(), st.data())
def test_only_combinations_that_some_situation_has_are_counted(space: Space, data: st.DataObject):
    flown = data.draw(st.lists(st.sampled_from(keys_of(space)), unique=True))
    for strength in range(1, len(space.axes) + 1):
        found = t_way(flown, space, strength)
        assert [one.part for one in found.axes] == by_hand(flown, space, strength)
        assert [one.whole for one in found.axes] == by_hand(keys_of(space), space, strength)
        assert t_way(keys_of(space), space, strength).complete(1.0).value == 1.0


def test_completeness_counts_choices_of_axes():
    # 00, 01 on the first two axes is half of their pairs, and the third axis is 0 in both
    found = t_way(["Aa0Ab0Ac0", "Aa0Ab1Ac0"], space_of([2, 2, 2]), 2)
    assert [one.part for one in found.axes] == [2, 1, 2]
    assert (found.complete(0.5), found.complete(0.25), found.complete(0.51)) == (Ratio(2, 3), Ratio(3, 3), Ratio(0, 3))


def test_ten_axes_of_three_values_are_counted_without_listing_the_product():
    space = space_of([3] * 10)
    some = keys_of(space)[:: 59049 // 50][:50]
    for strength, wanted in ((2, 405), (3, 3240), (5, 61236)):
        assert t_way(some, space, strength).total.whole == wanted


@pytest.mark.parametrize(("strength", "least"), [(1, 2), (2, 6), (3, 10), (4, 16), (5, 32)])
@pytest.mark.parametrize("seed", range(10))
def test_the_smallest_suites_of_five_binary_axes_are_found(strength: int, least: int, seed: int):
    suite = covering_array(FIVE, keys_of(FIVE), strength, seed)
    assert len(suite) == len(set(suite)) == least
    assert t_way(suite, FIVE, strength).total.value == 1.0


def smallest(axes: int, strength: int, size: int) -> bool:
    """Whether some `size` points of so many binary axes have every combination, by trying all."""
    codes, every = table(levels_of(keys_of(space_of([2] * axes)), space_of([2] * axes)), space_of([2] * axes), strength)
    masks = [sum(1 << int(code) for code in row) for row in codes]
    whole = (1 << every) - 1
    # the first point may be the benign one: any suite becomes such by renaming values
    for rest in combinations(masks[1:], size - 1):
        covered = masks[0]
        for mask in rest:
            covered |= mask
        if covered == whole:
            return True
    return False


def test_fewer_than_6_10_and_16_situations_cannot_do():
    assert not smallest(axes=5, strength=2, size=5)
    assert smallest(axes=4, strength=2, size=5)
    # 3-way: the situations with 0 on one axis must have all pairs of the other four, and those with 1 too: 5 + 5
    assert not smallest(axes=4, strength=2, size=4)
    # 4-way: four axes alone have 16 combinations, one a situation


@settings(max_examples=usually(25, release=40), deadline=None)
@given(spaces(most=14), st.integers(1, 3), st.integers(0, 3))
def test_an_array_has_every_combination_of_the_situations_to_choose_from(space: Space, strength: int, seed: int):
    strength = min(strength, len(space.axes))
    suite = covering_array(space, keys_of(space), strength, seed)
    assert set(suite) <= set(keys_of(space))
    assert len(suite) == len(set(suite))
    assert t_way(suite, space, strength).total.value == 1.0
    assert suite == covering_array(space, keys_of(space), strength, seed)


@given(spaces(most=14))
def test_what_is_forbidden_leaves_exactly_the_situations(space: Space):
    levels = levels_of(keys_of(space), space)
    values = [sorted(set(column)) for column in levels.T.tolist()]
    every = np.array(np.meshgrid(*values, indexing="ij")).reshape(len(values), -1).T
    terms = forbidden(levels)
    assert terms is not None
    left = [
        row for row in every.tolist() if not any(all(row[a] == v for a, v in zip(*term, strict=True)) for term in terms)
    ]
    assert sorted(left) == sorted(levels.tolist())
    for axes, _ in terms:
        assert len(axes) >= 2


def test_ten_axes_of_three_values_have_small_arrays():
    space = space_of([3] * 10)
    suite = covering_array(space, keys_of(space), 2, 0)
    assert len(suite) <= 17  # at least 14: Colbourn's tables of covering array numbers
    assert t_way(suite, space, 2).total.value == 1.0


@pytest.mark.parametrize("strength", [0, 6])
def test_a_strength_without_axes_is_refused(strength: int):
    with pytest.raises(InputError, match=f"strength={strength} of a covering array must be 1 to 5"):
        covering_array(FIVE, keys_of(FIVE), strength, 0)


def test_without_the_library_a_sentence_says_what_to_install(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setitem(__import__("sys").modules, "covertable", None)
    with pytest.raises(InputError, match=r"need covertable: pip install 'scaloft-fi\[covering\]'"):
        covering_array(FIVE, keys_of(FIVE), 2, 0)


def test_scattered_situations_are_covered_without_the_library(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setitem(__import__("sys").modules, "covertable", None)
    space = space_of([3] * 8)
    some = keys_of(space)[::97]
    suite = covering_array(space, some, 2, 0)
    assert set(suite) < set(some)
    assert t_way(suite, space, 2).axes == t_way(some, space, 2).axes
