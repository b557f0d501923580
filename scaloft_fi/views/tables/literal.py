"""Texts of a study that must appear as they are, whatever a format makes of its characters."""

from __future__ import annotations

import re

_CONTROL = re.compile(r"[\x00-\x08\x0b-\x1f\x7f-\x9f\ud800-\udfff\ufffe\uffff]")
_MARKDOWN = re.compile(r"([\\`*_\[\]<>&|~$#])")
_LATEX = {
    "\\": r"\textbackslash{}",
    "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}",
    "<": r"\textless{}",
    ">": r"\textgreater{}",
    "|": r"\textbar{}",
    '"': r"{\char34}",  # in every font encoding
    "-": "{-}",  # two of them would become a dash
    "`": "{`}",
    "'": "{'}",
    **{mark: f"\\{mark}" for mark in "{}$&%#_"},
}
FORMULA = ("=", "+", "-", "@", "\t", "\r", "\n", "＝", "＋", "－", "＠")  # noqa: RUF001 - those, too, begin a formula
"""What makes a spreadsheet take a text for a formula (OWASP, CSV injection)."""


def printable(text: str) -> str:
    r"""The text with control characters and lone surrogates spelled out: no terminal and no XML obeys them.

    >>> printable("a\x1b[31mb\tc")
    'a\\x1b[31mb\tc'
    """
    return _CONTROL.sub(lambda control: repr(control[0])[1:-1], text)


def line(text: str) -> str:
    """The printable text on one line."""
    return " ".join(printable(text).split())


def markdown(text: str) -> str:
    r"""The text as a cell of a Markdown table.

    >>> markdown("<b> a|b")
    '\\<b\\> a\\|b'
    """
    return _MARKDOWN.sub(r"\\\1", line(text))


def latex(text: str) -> str:
    r"""The text in LaTeX; letters that are not Latin need a Unicode engine.

    >>> latex("5 % & x_y")
    '5 \\% \\& x\\_y'
    """
    return "".join(_LATEX.get(letter, letter) for letter in line(text))


def spreadsheet_text(text: str) -> str:
    """The text as a cell of a CSV that a spreadsheet opens: what would be a formula there gets OWASP's leading `'`.

    >>> spreadsheet_text("=1+1"), spreadsheet_text("1+1")
    ("'=1+1", '1+1')
    """
    shown = printable(text)
    return f"'{shown}" if shown.startswith(FORMULA) else shown
