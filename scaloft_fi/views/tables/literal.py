"""Texts of a study that must appear as they are, whatever a format makes of its characters."""

from __future__ import annotations

import re
from html import escape

from scaloft_fi.console import line, printable

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


def markdown(text: str) -> str:
    r"""The text as a cell of a Markdown table.

    >>> markdown("<b> a|b")
    '\\<b\\> a\\|b'
    """
    return _MARKDOWN.sub(r"\\\1", line(text))


def code(text: str) -> str:
    r"""The text as code in a line of Markdown, in a fence longer than any within it.

    >>> code("a `b`"), code("a")
    ('`` a `b` ``', '`a`')
    """
    shown = line(text)
    runs = [len(run) for run in re.findall("`+", shown)]
    fence = "`" * (max(runs, default=0) + 1)
    return f"{fence} {shown} {fence}" if runs else f"{fence}{shown}{fence}"


def latex(text: str) -> str:
    r"""The text in LaTeX; letters that are not Latin need a Unicode engine.

    >>> latex("5 % & x_y")
    '5 \\% \\& x\\_y'
    """
    return "".join(_LATEX.get(letter, letter) for letter in line(text))


def xml(text: str) -> str:
    r"""The text on one line as the content of an element or an attribute of XML.

    >>> xml("<a>\x1b & \n b")
    '&lt;a&gt;\\x1b &amp; b'
    """
    return escape(line(text))


def spreadsheet_text(text: str) -> str:
    r"""The text as a cell of a CSV that a spreadsheet opens: what would be a formula there gets OWASP's leading `'`.

    So does a text that would look like one with it: who reads the file back takes one `'` away from each cell that
    matches `'+[=+@-]` or the like (see `FORMULA`).

    >>> spreadsheet_text("=1+1"), spreadsheet_text("1+1"), spreadsheet_text("'=1")
    ("'=1+1", '1+1', "''=1")
    """
    shown = printable(text)
    return f"'{shown}" if shown.lstrip("'").startswith(FORMULA) else shown
