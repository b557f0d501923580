"""The glossary has every word that the tables, screens and files of results use, looked for in the code itself."""

from __future__ import annotations

import re

import pytest
from outputs import recorded
from printed import headings, no_terms, printed_enumerations

from scaloft_fi.analysis.detection import Verdict
from scaloft_fi.analysis.score import By, Score
from scaloft_fi.judge.outcome import BASELINE, PLACEBO_ID
from scaloft_fi.judge.requirement import Kind
from scaloft_fi.verbs import first_screen, listing, signals, situations
from scaloft_fi.verbs.first_screen import NAMES
from scaloft_fi.verbs.worksheet import COLUMNS
from scaloft_fi.views.table import TERMS, term


def test_every_heading_of_every_table_is_a_term():
    """Tables of verbs that the record lacks are looked at where these are tested, with `no_terms`."""
    pages = [text for words, (_, text, _) in recorded().items() if words.endswith(("markdown", "sace"))]
    assert len({head for page in pages for head in headings(page)}) > 120
    assert {head for page in pages for head in no_terms(page)} == set()
    listed = [*situations.AXIS_OVERVIEW, *signals.OVERVIEW, *listing.SEAM_OVERVIEW, *listing.OPERATOR_OVERVIEW]
    of_screens = [*first_screen.COLUMNS, *first_screen.CONTROL_COLUMNS]
    assert [head for head in (*listed, *of_screens, *(one.title for one in COLUMNS), *By) if term(head) is None] == []


def test_every_value_that_is_printed_is_a_term():
    printed = printed_enumerations()
    assert {Verdict, Kind} <= set(printed)
    assert {f"{one.__name__}.{value}" for one in printed for value in one if term(value) is None} == set()


@pytest.mark.parametrize(
    "words", [NAMES, [name.replace("_", " ") for name in Score.KEYS], Score.KEYS, (BASELINE, PLACEBO_ID)]
)
def test_every_row_of_the_first_screens_is_a_term(words: list[str]):
    assert [word for word in words if term(word) is None] == []


def test_a_form_belongs_to_one_term():
    forms = [form.casefold() for entry in TERMS for form in (entry.name, *entry.also)]
    assert sorted({form for form in forms if forms.count(form) > 1}) == []


def test_terms_are_in_alphabetical_order_and_end_in_a_full_stop():
    names = [entry.name.casefold() for entry in TERMS]
    assert names == sorted(names)
    assert [entry.name for entry in TERMS if not re.search(r"[.]$", entry.meaning)] == []
