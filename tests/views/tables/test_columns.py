from __future__ import annotations

from textwrap import wrap

import pytest
from hypothesis import given
from hypothesis import strategies as st

from scaloft_fi.views.tables import columns
from scaloft_fi.views.tables.columns import limits
from scaloft_fi.views.tables.table import _wrapped

WORDS = st.lists(st.text("ab-", min_size=1, max_size=12), max_size=30).map(" ".join)


@given(WORDS, st.integers(1, 40))
def test_the_lines_of_a_cell_are_those_that_it_is_wrapped_into(cell, width):
    assert columns._lines(cell, width) == max(1, len(wrap(cell, width, break_on_hyphens=False)))


def test_a_name_is_not_cut_at_its_hyphen_where_a_cell_is_wrapped():
    """A terminal takes a command that goes on in the next line, and no name that is in two parts."""
    command = "`scaloft-fi run --campaign one-of-many --mutant LATE-human@3s --seeds 3`"
    for wide in range(20, 60):
        cells = _wrapped(command, wide).split()
        assert {"--campaign", "one-of-many", "LATE-human@3s"} <= {*cells}


@given(st.lists(st.tuples(WORDS, WORDS, WORDS), min_size=1, max_size=6), st.integers(40, 90))
def test_a_table_fits_where_its_columns_can_be_made_narrow_enough(rows, width):
    headers = ("first", "second", "third")
    found = limits(headers, rows, width)
    natural = [
        max(len(header), *map(len, column)) for header, column in zip(headers, zip(*rows, strict=True), strict=True)
    ]
    widths = [wanted if limit is None else limit for limit, wanted in zip(found, natural, strict=True)]
    assert sum(widths) + 4 <= width or widths == [len(header) for header in headers]
    assert all(limit is None or limit < wanted for limit, wanted in zip(found, natural, strict=True))
    assert sum(natural) + 4 > width or found == [None] * 3


@pytest.mark.parametrize(
    ("rows", "found"),
    [
        ([("name", "a b", "c d")], [None, None, None]),
        ([("name", "aa bb cc dd", "x" * 30)], [None, 10, None]),
        ([("name", "x" * 30, "aa bb cc dd ee ff")], [None, None, 10]),
    ],
)
def test_the_column_gives_way_that_costs_the_fewest_lines(rows, found):
    assert limits(("n", "second", "third"), rows, 48) == found
