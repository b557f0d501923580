"""Tables: what a study says appears as it is in every format, and a terminal of any width shows every word whole."""

from __future__ import annotations

import csv
import io
import re
from textwrap import wrap
from xml.etree import ElementTree

import pytest
from click import unstyle
from fuzzing import HOSTILE
from hypothesis import given
from hypothesis import strategies as st
from outputs import recorded
from printed import headings, no_terms, printed_enumerations

from scaloft_fi.analysis.detection import Verdict
from scaloft_fi.analysis.score import By, Score
from scaloft_fi.judge.outcome import BASELINE, PLACEBO_ID
from scaloft_fi.judge.requirement import Kind
from scaloft_fi.output import Marked, line, printable
from scaloft_fi.verbs import first_screen, listing, signals, situations
from scaloft_fi.verbs.first_screen import NAMES
from scaloft_fi.verbs.worksheet import COLUMNS
from scaloft_fi.views.table import (
    _LATEX,
    FORMULA,
    GAP,
    TERMS,
    Format,
    Table,
    _lines,
    latex,
    limits,
    markdown,
    render,
    spreadsheet_text,
    term,
    xml,
)

texts = st.text(max_size=60) | st.sampled_from(HOSTILE)


@given(texts)
def test_xml_taken_back_is_what_was_said(text: str):
    assert (ElementTree.fromstring(f"<a>{xml(text)}</a>").text or "") == line(text)


@given(texts)
def test_markdown_taken_back_is_what_was_said(text: str):
    assert re.sub(r"\\([!-/:-@\[-`{-~])", r"\1", markdown(text)) == line(text)
    assert not re.search(r"(?<!\\)(?:\\\\)*[|<>`*_\[\]]", markdown(text))


@given(texts)
def test_latex_taken_back_is_what_was_said(text: str):
    back = {written: letter for letter, written in _LATEX.items()}
    pattern = "|".join(re.escape(written) for written in sorted(back, key=len, reverse=True))
    assert re.sub(pattern, lambda found: back[found[0]], latex(text)) == line(text)
    assert not re.search(r"(?<!\\)[%$&#_]", latex(text))


@given(texts)
def test_a_text_in_a_spreadsheet_never_begins_a_formula(text: str):
    shown = spreadsheet_text(text)
    assert not shown.startswith(FORMULA)
    assert (shown[1:] if re.match(f"'+[{re.escape(''.join(FORMULA))}]", shown) else shown) == printable(text)
    written = io.StringIO()
    csv.writer(written).writerow([shown])
    ((back,),) = csv.reader(io.StringIO(written.getvalue(), newline=""))
    assert back == shown
    for ordinary in ("LATE-human@3s", "1.4 s", "8/15 = 53 %"):
        assert spreadsheet_text(ordinary) == ordinary


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


IDS = st.sampled_from(["LATE-human@3s", "NO-depth@3s#5s", "UNINTENDED-collision@20s#waypoint", "T0O0W0D0H1"])
TEXTS = st.lists(st.sampled_from(["no", "contact", "LATE-human@3s", "results/campaigns", "violates"]), max_size=12)
WIDTHS = st.sampled_from([40, 60, 80, 100, 160])
ROW = ("LATE-human@3s", "8/9", "SR2 8/8", "human & light", "no contact")
TABLE = Table("Detected: 1", ("mutant", "killed in", "by", "where", "effect"), (ROW,), spare=("where", "by"))


def shown(table: Table, width: int, *, marked: bool = False) -> str:
    return render([table], Format.TABLE, width=width, marked=marked)


@given(st.lists(st.tuples(IDS, TEXTS.map(" ".join), TEXTS.map(" ".join)), min_size=1, max_size=8), WIDTHS)
def test_a_table_fits_every_width_with_every_word_whole(rows: list[tuple[str, str, str]], width: int):
    text = shown(Table("Title", ("mutant", "effect", "next"), tuple(rows), ("A note of `scaloft-fi run`.",)), width)
    assert max(map(len, text.splitlines())) <= width
    words = text.split()
    for word in {word for row in rows for cell in row for word in cell.split()}:
        assert words.count(word) >= sum(cell.split().count(word) for row in rows for cell in row)


def test_columns_that_can_be_spared_go_in_their_order_and_a_note_names_them():
    cells = tuple((f"mutant-{i}", "word " * 3 + "x" * 15, "y" * 15, "z" * 15) for i in range(3))
    table = Table("T", ("mutant", "effect", "where", "next"), cells, spare=("where",))
    assert "Left out" not in shown(table, 100)
    narrow = shown(table, 50)
    assert "Left out for want of room: where; `--format csv`" in narrow
    assert "y" * 15 not in narrow
    assert "z" * 15 in narrow


def test_without_room_for_columns_each_row_is_a_record_that_lacks_nothing_but_empty_values():
    table = Table("T", ("mutant", "path", "note"), (("LATE-human@3s", "p" * 30, ""), ("NO-depth@3s", "q" * 30, "why")))
    assert shown(table, 40) == (
        f"T\n\nLATE-human@3s\n  path  {'p' * 30}\n\nNO-depth@3s\n  path  {'q' * 30}\n  note  why\n"
    )


def test_a_table_without_rows_says_none_instead_of_its_headers():
    assert shown(Table("T", ("mutant", "path"), (), ("Why.",)), 40) == "T\n\nnone\nWhy.\n"


def test_a_table_that_would_be_taller_than_its_records_becomes_records():
    prose = "a word or two " * 12
    text = shown(Table("T", ("cell", "deviation", "cause", "effect"), (("NO-human", prose, prose, prose),)), 44)
    assert text.startswith("T\n\nNO-human\n  deviation  a word")


@pytest.mark.parametrize("width", [44, 60, 100])
def test_colours_change_no_letter(width: int):
    rows = (("a", "detected"), ("b", "Not detected"), ("c", "violated at 8.10 s"), ("d", "redrawn"))
    table = Table("Not detected: 1", ("mutant", "verdict"), rows, ("See `scaloft-fi kills`.",))
    marked = shown(table, width, marked=True)
    assert isinstance(marked, Marked)
    assert unstyle(marked) == shown(table, width)
    assert "\x1b[32mdetected\x1b[0m" in marked
    assert "\x1b[31mviolated at 8.10 s\x1b[0m" in marked
    assert "redrawn\n" in marked
    assert "\x1b[36m`scaloft-fi kills`\x1b[0m" in marked


@pytest.mark.parametrize("how", [form for form in Format if form is not Format.TABLE])
def test_no_other_format_depends_on_the_width_or_has_colours(how: Format):
    assert render([TABLE], how, width=40, marked=True) == render([TABLE], how, width=160, marked=False)


def test_what_a_study_says_stays_inert_in_a_coloured_table():
    text = shown(Table("\x1b[2J", ("\x1b[31m", "b"), (("\x1b[5mheld", "held"),), ("\x9b1m",)), 80, marked=True)
    assert all(raw not in text for raw in ("\x1b[2J", "\x1b[5m", "\x9b"))


@pytest.mark.parametrize("width", [60, 100])
def test_sentences_in_a_table_of_one_column_are_wrapped(width: int):
    table = Table("Answer", ("finding",), (("a sentence of many words " * 20,), ("another",)))
    lines = render([table], Format.TABLE, width=width).splitlines()
    assert max(map(len, lines)) <= width


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
