"""The glossary has every word that the tables, screens and files of results use, looked for in the code itself."""

from __future__ import annotations

import re

import pytest
from printed import printed_enumerations
from table_heads import headings

from scaloft_fi.analysis.detection import Verdict
from scaloft_fi.analysis.score import By
from scaloft_fi.judge.outcome import BASELINE, PLACEBO_ID
from scaloft_fi.judge.requirement import Kind
from scaloft_fi.verbs import axes, first_screen, operators, seams, signals
from scaloft_fi.verbs.first_screen import POPULATIONS
from scaloft_fi.verbs.verdict import NAMES
from scaloft_fi.verbs.worksheet import COLUMNS
from scaloft_fi.views.glossary import TERMS, term

TOLD_BY_A_RUN = {
    "verbs/matrix.py: (word.id for word in matrix.guidewords)": "guidewords of the study",
    "verbs/matrix.py: cell.name": "a cell of the study",
    "verbs/matrix.py: header": "of the callers, which are read too",
    "verbs/matrix.py: header[1:]": "guidewords of the study",
    "views/output.py: tuple(names)": "columns of a data frame, which the reference of Python has",
    "verbs/diff.py: first": "a campaign's name",
    "verbs/diff.py: second": "a campaign's name",
    "verbs/export/rows.py: columns": "columns of the export, which the reference has",
    "verbs/replay.py: log.signals": "signals, which `scaloft_fi.sim.log` explains",
    "verbs/listing.py: tuple(columns)": tuple(
        head for module in (axes, operators, seams, signals) for head in module.OVERVIEW
    ),
    "views/output.py: flat.columns": "keys of JSON, which the reference has",
    "verbs/score.py: header": ("parameter", "situation"),
    "verbs/first_screen.py: columns": tuple(
        column for columns in (*first_screen.COLUMNS.values(), first_screen.CONTROL_COLUMNS) for column in columns
    ),
    "verbs/first_screen.py: by.value": tuple(by.value for by in By),
    "views/table.py: f'# {title}'": "a table's title in CSV",
    "views/table.py: table.headers": "of the callers, which are read too",
    "verbs/worksheet.py: tuple((column.title for column in shown))": tuple(column.title for column in COLUMNS),
}
"""Heads that the code around a table does not tell: what they are, or why they need no term."""


def _texts() -> dict[str, str]:
    """Every heading with the place that makes it."""
    texts = {heading.text: heading.place for heading in headings() if heading.text}
    for place, told in TOLD_BY_A_RUN.items():
        texts |= dict.fromkeys(told if isinstance(told, tuple) else (), place)
    return texts


def test_every_heading_of_every_table_is_a_term() -> None:
    assert {text: place for text, place in _texts().items() if term(text) is None} == {}


def test_a_heading_that_the_code_does_not_tell_is_explained_here() -> None:
    unknown = {heading.place.removeprefix("scaloft_fi/") for heading in headings() if heading.text is None}
    assert unknown == set(TOLD_BY_A_RUN)


def test_headings_are_found() -> None:
    assert {"kills", "stopped at", "least robustness", "p = 0.75", "with a kill/tested"} <= set(_texts())
    assert len(_texts()) > 150


def test_every_value_that_is_printed_is_a_term() -> None:
    printed = printed_enumerations()
    assert {Verdict, Kind} <= set(printed)
    assert {f"{one.__name__}.{value}" for one in printed for value in one if term(value) is None} == set()


@pytest.mark.parametrize(
    "words",
    [
        NAMES,
        [name.replace("_", " ") for name in POPULATIONS],
        POPULATIONS,
        (BASELINE, PLACEBO_ID),
    ],
)
def test_every_row_of_the_first_screens_is_a_term(words: list[str]) -> None:
    assert [word for word in words if term(word) is None] == []


def test_a_form_belongs_to_one_term() -> None:
    forms = [form.casefold() for entry in TERMS for form in (entry.name, *entry.also)]
    assert sorted({form for form in forms if forms.count(form) > 1}) == []


def test_terms_are_in_alphabetical_order_and_end_in_a_full_stop() -> None:
    names = [entry.name.casefold() for entry in TERMS]
    assert names == sorted(names)
    assert [entry.name for entry in TERMS if not re.search(r"[.]$", entry.meaning)] == []
