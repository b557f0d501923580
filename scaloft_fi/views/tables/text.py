"""A table as text for a terminal of some width: columns side by side, or a record for each row where there is no room.

First the columns are made narrower between words; then those are left out that the table can spare, which a note names;
at last each row becomes a record, a line for each of its values.  Ids, paths and commands are never broken.
"""

from __future__ import annotations

from collections.abc import Sequence

from scaloft_fi.console import PROSE, Style, broken, styled, wrapped
from scaloft_fi.views.tables.columns import height, limits
from scaloft_fi.views.tables.meaning import commands, style_of

INDENT = "  "
Cells = Sequence[Sequence[str]]


def body_text(headers: Sequence[str], rows: Cells, width: int, spare: Sequence[str] = (), *, marked: bool) -> str:
    """Headers and rows as text without a line break at its end.

    Args:
        headers: of the columns, printable.
        rows: printable, a line each.
        width: of the terminal [characters].
        spare: headers of the columns that the table can spare, in the order in which they are left out.
        marked: whether words with a meaning get colours.
    """
    most = sum(1 + len(row) for row in rows)  # lines of the records
    gone: list[str] = []
    while True:
        kept = [at for at, header in enumerate(headers) if header not in gone]
        names, cells = [headers[at] for at in kept], [[row[at] for at in kept] for row in rows]
        widths = limits(names, cells, width)
        if widths is not None and height([names, *cells], widths) <= 1 + most:
            body = _columns(names, cells, widths, marked=marked)
            return f"{body}\n{_left_out(gone, width, marked=marked)}" if gone else body
        if len(gone) == len(spare):
            return "\n\n".join(_record(headers, row, width, marked=marked) for row in rows)
        gone.append(spare[len(gone)])


def heading(title: str, width: int, *, marked: bool) -> str:
    """The title of a table; a word with a meaning before a colon gives it its colour."""
    text = wrapped(title, width)
    if not marked:
        return text
    meaning = style_of(title.partition(":")[0])
    strong = "\n".join(styled(line, Style.STRONG) for line in text.split("\n"))
    return styled(strong, meaning) if meaning else strong


def note(text: str, width: int, *, marked: bool) -> str:
    """A sentence under a table."""
    return commands(wrapped(text, min(width, PROSE)), marked=marked)


def _left_out(gone: Sequence[str], width: int, *, marked: bool) -> str:
    text = f"Left out for want of room: {', '.join(gone)}; `--format csv` has every column."
    return note(text, width, marked=marked)


def _columns(headers: Sequence[str], rows: Cells, widths: Sequence[int], *, marked: bool) -> str:
    import tabulate

    tabulate.MIN_PADDING = 0  # a header needs no more room than its letters
    cells = [[_cell(cell, width, marked=marked) for cell, width in zip(row, widths, strict=True)] for row in rows]
    names = [_cell(header, width, marked=False) for header, width in zip(headers, widths, strict=True)]
    return tabulate.tabulate(cells, names, "simple", disable_numparse=True)


def _cell(cell: str, width: int, *, marked: bool) -> str:
    lines = [cell] if len(cell) <= width else broken(cell, width)
    meaning = style_of(cell) if marked else None
    return "\n".join(styled(line, meaning) for line in lines) if meaning else "\n".join(lines)


def _record(headers: Sequence[str], row: Sequence[str], width: int, *, marked: bool) -> str:
    """A row as lines: what names it, then below it each other value behind its header."""
    label = max(map(len, headers[1:]), default=0) + len(INDENT)
    name = wrapped(row[0], width)
    lines = ["\n".join(styled(each, Style.STRONG) for each in name.split("\n")) if marked else name]
    for header, value in zip(headers[1:], row[1:], strict=True):
        if value:
            meaning = style_of(value) if marked else None
            text = wrapped(value, width, f"{INDENT}{header.ljust(label)}", INDENT + " " * label)
            head = len(INDENT) + label
            lines.append(text[:head] + styled(text[head:], meaning) if meaning else text)
    return "\n".join(lines)
