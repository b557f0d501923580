from __future__ import annotations

from itertools import pairwise, product
from math import prod

from builders import GRID
from hypothesis import given
from hypothesis import strategies as st

from scaloft_fi.analysis.kill_matrix import gray_order, gray_rank, gray_words
from scaloft_fi.judge.space import Space

radices = st.lists(st.integers(1, 4), min_size=1, max_size=4)


def test_neighbouring_situations_of_the_grid_differ_on_one_axis() -> None:
    order = gray_order(GRID)
    assert sorted(order) == sorted(GRID.point)
    assert order[0] == "T0O0W0D0H0"
    for key, following in pairwise(order):
        assert sum(a != b for a, b in zip(GRID.point[key], GRID.point[following], strict=True)) == 1


@given(radices)
def test_neighbouring_words_differ_in_one_digit_by_one(sizes: list[int]) -> None:
    words = gray_words(sizes)
    assert sorted(words) == sorted(product(*map(range, sizes)))
    for word, following in pairwise(words):
        assert sum(abs(a - b) for a, b in zip(word, following, strict=True)) == 1


@given(radices)
def test_a_words_rank_is_its_place(sizes: list[int]) -> None:
    assert [gray_rank(word, sizes) for word in gray_words(sizes)] == list(range(prod(sizes)))


def test_a_grid_with_situations_left_out_keeps_the_order_of_the_rest() -> None:
    kept = tuple(entry for entry in GRID.points if entry[0] != "T0O0W0D1H1")
    partial = Space(GRID.axes, GRID.values, GRID.words, kept)
    assert gray_order(partial) == tuple(key for key in gray_order(GRID) if key != "T0O0W0D1H1")
