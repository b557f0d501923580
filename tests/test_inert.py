"""Nothing that shows or reads a text of a study, a store or a path obeys it."""

from __future__ import annotations

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st
from obeyed import obeyed

from scaloft_fi.console import all_printable, json_text, line, printable

texts = st.text(st.characters(), max_size=40)  # lone surrogates too
values = st.recursive(
    texts | st.integers() | st.booleans() | st.none(),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(texts, inner, max_size=3),
    max_leaves=8,
)
OBEYED = "\x00\x07\x08\x0c\r\x1b\x7f\x85\x9b\xad\u200b\u200d\u200e\u2028\u202e\u2066\u2069\ufeff\udc80\ufffe\U000e0041"


@given(texts)
def test_no_printable_text_holds_what_a_terminal_obeys_or_hides(text: str) -> None:
    shown = printable(text)
    assert obeyed(shown) == set()
    assert printable(shown) == shown
    shown.encode()


@pytest.mark.parametrize("letter", OBEYED)
def test_what_is_obeyed_is_spelled_out(letter: str) -> None:
    assert printable(f"a{letter}b") == f"a{ascii(letter)[1:-1]}b"


@pytest.mark.parametrize("text", ["人が検出されない — Ürümqi ñ ٣ 🙂", "two\nlines\tand a tab", "a\xa0b", ""])
def test_letters_of_every_script_line_breaks_and_tabs_stay(text: str) -> None:
    assert printable(text) == text


@given(texts)
def test_a_line_is_one_line(text: str) -> None:
    assert len(line(text).splitlines()) <= 1
    assert line(line(text)) == line(text)


@given(values, st.booleans())
def test_json_comes_back_and_shows_nothing_that_isobeyed(content: object, letters: bool) -> None:
    text = json_text(content, indent=1, letters=letters)
    assert obeyed(text) == set()
    assert json.loads(text) == content
    text.encode()


def test_a_number_that_is_not_finite_is_no_json() -> None:
    with pytest.raises(ValueError, match="Out of range"):
        json_text([float("nan")])


@given(values)
def test_all_texts_of_json_values_become_printable(content: object) -> None:
    assert obeyed(json.dumps(all_printable(content), ensure_ascii=False)) == set()
