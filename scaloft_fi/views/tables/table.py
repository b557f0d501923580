"""A table as data, and how it is printed: text, Markdown, CSV, JSON or LaTeX."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from enum import StrEnum
from textwrap import fill

from scaloft_fi.inert import json_text, line
from scaloft_fi.views.tables.columns import limits
from scaloft_fi.views.tables.literal import markdown, spreadsheet_text

WIDTH = 100
"""Columns of a terminal that a text table keeps within."""

TableCell = str | int | float | None


class Format(StrEnum):
    """How tables are printed."""

    TABLE = "table"
    MARKDOWN = "markdown"
    CSV = "csv"
    JSON = "json"
    LATEX = "latex"


_TABULATE = {Format.TABLE: "simple", Format.MARKDOWN: "github", Format.LATEX: "latex_booktabs"}
_HARMLESS = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?|-", re.ASCII)


@dataclass(frozen=True)
class Table:
    """A titled table with notes under it; its widest columns but the first are wrapped when it is too wide."""

    title: str
    headers: tuple[str, ...]
    rows: tuple[tuple[TableCell, ...], ...]
    notes: tuple[str, ...] = ()

    def records(self) -> list[dict[str, TableCell]]:
        """The rows as plain JSON values, by header."""
        return [dict(zip(self.headers, row, strict=True)) for row in self.rows]


def render(tables: Sequence[Table], how: Format) -> str:
    """The tables as one text, ending in a line break."""
    if how is Format.JSON:
        return json_text([_plain(table) for table in tables], indent=2) + "\n"
    return "\n".join(_one(table, how) for table in tables)


def csv_text(headers: Iterable[str], rows: Iterable[Iterable[object]]) -> str:
    """A line of headers and a line for each row, without a formula; nothing stands where there is no value."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(map(_in_csv, headers))
    writer.writerows(map(_in_csv, row) for row in rows)
    return text.getvalue()


def tabulated(headers: Sequence[str], rows: Iterable[Sequence[TableCell]], how: Format, style: str = "") -> str:
    """Headers and rows with `tabulate`, every cell a text of one line that the format takes literally.

    Args:
        headers: of the columns.
        rows: of the table; nothing stands where there is no value.
        how: text, Markdown or LaTeX.
        style: the table style of `tabulate`; by default the one of `how`.
    """
    import tabulate

    tabulate.MIN_PADDING = 0  # a header needs no more room than its letters
    literal = markdown if how is Format.MARKDOWN else line  # tabulate escapes LaTeX itself
    cells = [["" if cell is None else literal(str(cell)) for cell in row] for row in rows]
    names = list(map(literal, headers))
    if how is Format.TABLE and cells:
        widths = limits(names, cells, WIDTH)
        cells = [list(map(_wrapped, row, widths)) for row in cells]
    return tabulate.tabulate(cells, names, style or _TABULATE[how], disable_numparse=True)


def _plain(table: Table) -> dict[str, object]:
    return {"title": table.title, "rows": table.records(), "notes": list(table.notes)}


def _one(table: Table, how: Format) -> str:
    title, notes = line(table.title), list(map(line, table.notes))
    if how is Format.CSV:
        return csv_text([f"# {title}"], ()) + csv_text(table.headers, table.rows)
    body = tabulated(table.headers, table.rows, how)
    if how is Format.LATEX:
        return f"% {title}\n{body}\n" + "".join(f"% {note}\n" for note in notes)
    if how is Format.MARKDOWN:
        return f"### {markdown(title)}\n\n{body}\n" + "".join(f"\n{note}\n" for note in notes)
    return f"{title}\n\n{body}\n" + "".join(fill(note, WIDTH) + "\n" for note in notes)


def _wrapped(cell: str, limit: int | None) -> str:
    return cell if limit is None or len(cell) <= limit else fill(cell, limit, break_on_hyphens=False)


def _in_csv(value: object) -> object:
    """A text that a spreadsheet takes for a number, and the sign `-` alone, are no formulas."""
    if isinstance(value, str) and value[:1].isalnum() and value.isprintable():
        return value  # nearly every cell, without a search
    return spreadsheet_text(value) if isinstance(value, str) and not _HARMLESS.fullmatch(value) else value
