from __future__ import annotations

from textwrap import wrap

import pytest
from hypothesis import given
from hypothesis import strategies as st

from scaloft_fi.views.table import GAP, _lines, limits

WORDS = st.lists(st.text("ab-", min_size=1, max_size=12), max_size=30).map(" ".join)


@given(WORDS, st.integers(1, 40))
def test_the_lines_of_a_cell_are_those_that_it_is_wrapped_into(cell, width):
    lines = wrap(cell, width, break_on_hyphens=False, break_long_words=False)
    assert _lines(cell, width) == max(1, len(lines))


@given(st.lists(st.tuples(WORDS, WORDS, WORDS), min_size=1, max_size=6), st.integers(20, 90))
def test_a_table_fits_or_a_word_would_have_to_be_broken(rows, width):
    headers = ("first", "second", "third")
    listed = list(zip(headers, *rows, strict=True))
    words = [max(len(word) for cell in column for word in cell.split()) for column in listed]
    natural = [max(map(len, column)) for column in listed]
    found = limits(headers, rows, width)
    if found is None:
        assert natural[0] + sum(words[1:]) + 2 * GAP > width
        return
    assert sum(found) + 2 * GAP <= width
    assert all(low <= wide <= most for low, wide, most in zip(words, found, natural, strict=True))
    assert found == natural or sum(natural) + 2 * GAP > width


@pytest.mark.parametrize(
    ("rows", "found"),
    [
        ([("name", "a b", "c d")], [4, 6, 5]),
        ([("name", "aa bb cc dd", "x" * 30)], [4, 10, 30]),
        ([("name", "x" * 30, "aa bb cc dd ee ff")], [4, 30, 10]),
    ],
)
def test_the_column_gives_way_that_costs_the_fewest_lines(rows, found):
    assert limits(("n", "second", "third"), rows, 48) == found
