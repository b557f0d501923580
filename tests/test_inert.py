"""Nothing that shows or reads a text of a study, a store or a path obeys it."""

from __future__ import annotations

import json
import unicodedata

import pytest
from hypothesis import given
from hypothesis import strategies as st

from scaloft_fi.inert import all_printable, json_text, line, printable

texts = st.text(st.characters(), max_size=40)  # lone surrogates too
values = st.recursive(
    texts | st.integers() | st.booleans() | st.none(),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(texts, inner, max_size=3),
    max_leaves=8,
)
OBEYED = "\x00\x07\x08\x0c\r\x1b\x7f\x85\x9b\xad\u200b\u200d\u200e\u2028\u202e\u2066\u2069\ufeff\udc80\ufffe\U000e0041"
VISIBLE_FORMATS = "\u0600\u0601\u0602\u0603\u0604\u0605\u06dd\u070f\u0890\u0891\u08e2"
"""Signs of Arabic and Syriac that Unicode counts as formatting and every font draws."""


def _obeyed(text: str) -> set[str]:
    """The characters of a text that are drawn as nothing, obeyed, or in no text at all; but line breaks and tabs."""
    hidden = {c for c in text if unicodedata.category(c) in {"Cc", "Cf", "Cs", "Zl", "Zp"} and c.isprintable() is False}
    return {c for c in hidden - {*"\n\t", *VISIBLE_FORMATS} if ord(c) < 0x10000 or 0xE0000 <= ord(c) < 0xE0080}


@given(texts)
def test_no_printable_text_holds_what_a_terminal_obeys_or_hides(text: str) -> None:
    shown = printable(text)
    assert _obeyed(shown) == set()
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
def test_json_comes_back_and_shows_nothing_that_is_obeyed(content: object, letters: bool) -> None:
    text = json_text(content, indent=1, letters=letters)
    assert _obeyed(text) == set()
    assert json.loads(text) == content
    text.encode()


def test_a_number_that_is_not_finite_is_no_json() -> None:
    with pytest.raises(ValueError, match="Out of range"):
        json_text([float("nan")])


@given(values)
def test_all_texts_of_json_values_become_printable(content: object) -> None:
    assert _obeyed(json.dumps(all_printable(content), ensure_ascii=False)) == set()
