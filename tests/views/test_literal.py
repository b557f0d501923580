"""What a study says appears as it is in every format: each escape is undone here and compared with what was said."""

from __future__ import annotations

import csv
import io
import re
from xml.etree import ElementTree

import pytest
from hypothesis import given
from hypothesis import strategies as st

from scaloft_fi.console import line, printable
from scaloft_fi.views.table import _LATEX, FORMULA, latex, markdown, spreadsheet_text, xml

HOSTILE = (
    "<script>alert(1)</script>",
    "\"quotes\" and 'others'",
    "=cmd|' /C calc'!A0",
    "@SUM(1+1)*cmd|' /C calc'!A0",
    "+1",
    "-1+1",
    "=HYPERLINK(...)",
    "人が検出されない — Ürümqi ñ ٣",
    "a|b||c",
    r"\input{/etc/passwd} $x_1^2$ 100 % #1 & ~ {} \\",
    "line one\nline two\r\nline three\ttab",
    "[x](javascript:1) *b* _i_ `c` ![i](u) &lt; # h",
    "\x1b[31mred\x1b[0m\x07\x00",
    "x" * 40_000,
    "--- \\ | \\| \\\\|",
)
texts = st.text(max_size=60) | st.sampled_from(HOSTILE)


@given(texts)
def test_xml_taken_back_is_what_was_said(text: str) -> None:
    assert (ElementTree.fromstring(f"<a>{xml(text)}</a>").text or "") == line(text)


@given(texts)
def test_markdown_taken_back_is_what_was_said(text: str) -> None:
    assert re.sub(r"\\([!-/:-@\[-`{-~])", r"\1", markdown(text)) == line(text)
    assert not re.search(r"(?<!\\)(?:\\\\)*[|<>`*_\[\]]", markdown(text))


@given(texts)
def test_latex_taken_back_is_what_was_said(text: str) -> None:
    back = {written: letter for letter, written in _LATEX.items()}
    pattern = "|".join(re.escape(written) for written in sorted(back, key=len, reverse=True))
    assert re.sub(pattern, lambda found: back[found[0]], latex(text)) == line(text)
    assert not re.search(r"(?<!\\)[%$&#_]", latex(text))


@given(texts)
def test_a_text_in_a_spreadsheet_never_begins_a_formula(text: str) -> None:
    shown = spreadsheet_text(text)
    assert not shown.startswith(FORMULA)
    assert (shown[1:] if re.match(f"'+[{re.escape(''.join(FORMULA))}]", shown) else shown) == printable(text)
    written = io.StringIO()
    csv.writer(written).writerow([shown])
    ((back,),) = csv.reader(io.StringIO(written.getvalue(), newline=""))
    assert back == shown


@pytest.mark.parametrize("text", ["LATE-human@3s", "1.4 s", "8/15 = 53 %"])
def test_ordinary_texts_stay_as_they_are_in_a_spreadsheet(text: str) -> None:
    assert spreadsheet_text(text) == text
