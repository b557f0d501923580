"""A table as data, and how it is printed: text, Markdown, CSV, JSON or LaTeX."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from enum import StrEnum
from textwrap import fill

from scaloft_fi.views.tables.columns import limits
from scaloft_fi.views.tables.literal import markdown, printable

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
        return json.dumps([_plain(table) for table in tables], indent=2, allow_nan=False) + "\n"
    return "\n".join(_one(table, how) for table in tables)


def csv_text(headers: Iterable[str], rows: Iterable[Iterable[object]]) -> str:
    """A line of headers and a line for each row; nothing stands where there is no value."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(headers)
    writer.writerows(rows)
    return text.getvalue()


def _plain(table: Table) -> dict[str, object]:
    return {"title": table.title, "rows": table.records(), "notes": list(table.notes)}


def _one(table: Table, how: Format) -> str:
    if how is Format.CSV:
        return f"# {table.title}\n{csv_text(table.headers, table.rows)}"
    import tabulate

    tabulate.MIN_PADDING = 0  # a header needs no more room than its letters
    literal = markdown if how is Format.MARKDOWN else printable
    rows = [["" if cell is None else literal(str(cell)) for cell in row] for row in table.rows]
    if how is Format.TABLE and rows:
        widths = limits(table.headers, rows, WIDTH)
        rows = [list(map(_wrapped, row, widths)) for row in rows]
    body = tabulate.tabulate(rows, table.headers, _TABULATE[how], disable_numparse=True)
    if how is Format.LATEX:
        notes = "".join(f"% {note}\n" for note in table.notes)
        return f"% {table.title}\n{body}\n{notes}"
    if how is Format.MARKDOWN:
        return f"### {markdown(table.title)}\n\n{body}\n" + "".join(f"\n{note}\n" for note in table.notes)
    notes = "".join(fill(note, WIDTH) + "\n" for note in table.notes)
    return f"{table.title}\n\n{body}\n{notes}"


def _wrapped(cell: str, limit: int | None) -> str:
    return cell if limit is None or len(cell) <= limit else fill(cell, limit)
