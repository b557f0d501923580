r"""Texts of studies, stores, paths, stacks and plugins, made inert: nothing that shows or reads them obeys them.

Control characters (C0, C1, DEL), characters that are not seen or turn the direction of writing (zero width,
bidirectional formatting, tags), line separators and lone surrogates of file names are written as `\x1b`, `\u202e` and
so on.  Line breaks and tabs stay, except where a text must be one line.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from typing import Any

_OBEYED = re.compile(
    "[\x00-\x08\x0b-\x1f\x7f-\x9f\xad\u061c\u180e\u200b-\u200f\u2028-\u202e\u2060-\u206f"
    "\ud800-\udfff\ufeff\ufff9-\ufffb\ufffe\uffff\U000e0000-\U000e007f]"
)


def printable(text: str) -> str:
    r"""The text with every character spelled out that a terminal would obey or hide; other texts stay as they are.

    >>> printable("a\x1b[31mb\tc")
    'a\\x1b[31mb\tc'
    """
    return text if text.isprintable() else _OBEYED.sub(lambda found: repr(found[0])[1:-1], text)


def line(text: str) -> str:
    """The printable text on one line."""
    shown = printable(text)
    return " ".join(shown.split()) if "\n" in shown or "\t" in shown else shown.strip()


def json_text(values: Any, *, indent: int | None = None, letters: bool = False) -> str:
    r"""JSON in which everything is escaped that a terminal would obey or hide.

    Args:
        values: plain JSON values.
        indent: as of `json.dumps`.
        letters: whether letters beyond ASCII stand as they are.

    >>> json_text("\x7f\x9b Ü"), json_text("\x7f\x9b Ü", letters=True)
    ('"\\u007f\\u009b \\u00dc"', '"\\u007f\\u009b Ü"')

    Raises:
        ValueError: a number is not finite.
    """
    text = json.dumps(values, indent=indent, ensure_ascii=not letters, allow_nan=False).replace("\x7f", "\\u007f")
    return _OBEYED.sub(lambda found: json.dumps(found[0])[1:-1], text) if letters else text


def all_printable(values: Any) -> Any:
    r"""Plain JSON values with every text printable, keys too.

    >>> all_printable({"struck": ["\x1b[2J", 1.5]})
    {'struck': ['\\x1b[2J', 1.5]}
    """
    if isinstance(values, str):
        return printable(values)
    if isinstance(values, Mapping):
        return {all_printable(key): all_printable(value) for key, value in values.items()}
    if isinstance(values, list | tuple):
        return [all_printable(value) for value in values]
    return values
