from __future__ import annotations

import pytest
from click import unstyle
from hypothesis import given
from hypothesis import strategies as st

from scaloft_fi.console import Marked
from scaloft_fi.views.table import Format, Table, render

IDS = st.sampled_from(["LATE-human@3s", "NO-depth@3s#5s", "UNINTENDED-collision@20s#waypoint", "T0O0W0D0H1"])
TEXTS = st.lists(st.sampled_from(["no", "contact", "LATE-human@3s", "results/campaigns", "violates"]), max_size=12)
WIDTHS = st.sampled_from([40, 60, 80, 100, 160])
ROW = ("LATE-human@3s", "8/9", "SR2 8/8", "human & light", "no contact")
TABLE = Table("Detected: 1", ("mutant", "killed in", "by", "where", "effect"), (ROW,), spare=("where", "by"))


def shown(table: Table, width: int, *, marked: bool = False) -> str:
    return render([table], Format.TABLE, width=width, marked=marked)


@given(st.lists(st.tuples(IDS, TEXTS.map(" ".join), TEXTS.map(" ".join)), min_size=1, max_size=8), WIDTHS)
def test_a_table_fits_every_width_with_every_word_whole(rows: list[tuple[str, str, str]], width: int) -> None:
    text = shown(Table("Title", ("mutant", "effect", "next"), tuple(rows), ("A note of `scaloft-fi run`.",)), width)
    assert max(map(len, text.splitlines())) <= width
    words = text.split()
    for word in {word for row in rows for cell in row for word in cell.split()}:
        assert words.count(word) >= sum(cell.split().count(word) for row in rows for cell in row)


def test_columns_that_can_be_spared_go_in_their_order_and_a_note_names_them() -> None:
    cells = tuple((f"mutant-{i}", "word " * 3 + "x" * 15, "y" * 15, "z" * 15) for i in range(3))
    table = Table("T", ("mutant", "effect", "where", "next"), cells, spare=("where",))
    assert "Left out" not in shown(table, 100)
    narrow = shown(table, 50)
    assert "Left out for want of room: where; `--format csv`" in narrow
    assert "y" * 15 not in narrow
    assert "z" * 15 in narrow


def test_without_room_for_columns_each_row_is_a_record_that_lacks_nothing_but_empty_values() -> None:
    table = Table("T", ("mutant", "path", "note"), (("LATE-human@3s", "p" * 30, ""), ("NO-depth@3s", "q" * 30, "why")))
    assert shown(table, 40) == (
        f"T\n\nLATE-human@3s\n  path  {'p' * 30}\n\nNO-depth@3s\n  path  {'q' * 30}\n  note  why\n"
    )


def test_a_table_that_would_be_taller_than_its_records_becomes_records() -> None:
    prose = "a word or two " * 12
    text = shown(Table("T", ("cell", "deviation", "cause", "effect"), (("NO-human", prose, prose, prose),)), 44)
    assert text.startswith("T\n\nNO-human\n  deviation  a word")


@pytest.mark.parametrize("width", [44, 60, 100])
def test_colours_change_no_letter(width: int) -> None:
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
def test_no_other_format_depends_on_the_width_or_has_colours(how: Format) -> None:
    assert render([TABLE], how, width=40, marked=True) == render([TABLE], how, width=160, marked=False)


def test_what_a_study_says_stays_inert_in_a_coloured_table() -> None:
    text = shown(Table("\x1b[2J", ("\x1b[31m", "b"), (("\x1b[5mheld", "held"),), ("\x9b1m",)), 80, marked=True)
    assert all(raw not in text for raw in ("\x1b[2J", "\x1b[5m", "\x9b"))


@pytest.mark.parametrize("width", [60, 100])
def test_sentences_in_a_table_of_one_column_are_wrapped(width: int) -> None:
    table = Table("Answer", ("finding",), (("a sentence of many words " * 20,), ("another",)))
    lines = render([table], Format.TABLE, width=width).splitlines()
    assert max(map(len, lines)) <= width
