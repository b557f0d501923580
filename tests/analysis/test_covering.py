from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest
from effort import usually
from grids import FIVE, keys_of, space_of, spaces
from hypothesis import given, settings
from hypothesis import strategies as st

from scaloft_fi.analysis.coverage import covering_array, forbidden, levels_of, t_way, table
from scaloft_fi.errors import InputError
from scaloft_fi.judge.space import Space


@pytest.mark.parametrize(("strength", "least"), [(1, 2), (2, 6), (3, 10), (4, 16), (5, 32)])
@pytest.mark.parametrize("seed", range(10))
def test_the_smallest_suites_of_five_binary_axes_are_found(strength: int, least: int, seed: int) -> None:
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


def test_fewer_than_6_10_and_16_situations_cannot_do() -> None:
    assert not smallest(axes=5, strength=2, size=5)
    assert smallest(axes=4, strength=2, size=5)
    # 3-way: the situations with 0 on one axis must have all pairs of the other four, and those with 1 too: 5 + 5
    assert not smallest(axes=4, strength=2, size=4)
    # 4-way: four axes alone have 16 combinations, one a situation


@settings(max_examples=usually(25, release=40), deadline=None)
@given(spaces(most=14), st.integers(1, 3), st.integers(0, 3))
def test_an_array_has_every_combination_of_the_situations_to_choose_from(
    space: Space, strength: int, seed: int
) -> None:
    strength = min(strength, len(space.axes))
    suite = covering_array(space, keys_of(space), strength, seed)
    assert set(suite) <= set(keys_of(space))
    assert len(suite) == len(set(suite))
    assert t_way(suite, space, strength).total.value == 1.0
    assert suite == covering_array(space, keys_of(space), strength, seed)


@given(spaces(most=14))
def test_what_is_forbidden_leaves_exactly_the_situations(space: Space) -> None:
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


def test_ten_axes_of_three_values_have_small_arrays() -> None:
    space = space_of([3] * 10)
    suite = covering_array(space, keys_of(space), 2, 0)
    assert len(suite) <= 17  # at least 14: Colbourn's tables of covering array numbers
    assert t_way(suite, space, 2).total.value == 1.0


@pytest.mark.parametrize("strength", [0, 6])
def test_a_strength_without_axes_is_refused(strength: int) -> None:
    with pytest.raises(InputError, match=f"strength={strength} of a covering array must be 1 to 5"):
        covering_array(FIVE, keys_of(FIVE), strength, 0)


def test_without_the_library_a_sentence_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "covertable", None)
    with pytest.raises(InputError, match=r"need covertable: pip install 'scaloft-fi\[covering\]'"):
        covering_array(FIVE, keys_of(FIVE), 2, 0)


def test_scattered_situations_are_covered_without_the_library(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "covertable", None)
    space = space_of([3] * 8)
    some = keys_of(space)[::97]
    suite = covering_array(space, some, 2, 0)
    assert set(suite) < set(some)
    assert t_way(suite, space, 2).axes == t_way(some, space, 2).axes
