"""A table as data, and how it is printed: text, Markdown, CSV, JSON or LaTeX."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from textwrap import fill

WIDTH = 120
"""Columns of a terminal that a text table keeps within."""
NARROWEST = 16
"""No column is wrapped below this."""

Cell = str | int | float | None


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
    """A titled table with notes under it; the last column is wrapped when the table is too wide."""

    title: str
    headers: tuple[str, ...]
    rows: tuple[tuple[Cell, ...], ...]
    notes: tuple[str, ...] = ()


def render(tables: Sequence[Table], how: Format) -> str:
    """The tables as one text, ending in a line break."""
    if how is Format.JSON:
        return json.dumps([_plain(table) for table in tables], indent=2, allow_nan=False) + "\n"
    return "\n".join(_one(table, how) for table in tables)


def _plain(table: Table) -> dict[str, object]:
    rows = [dict(zip(table.headers, row, strict=True)) for row in table.rows]
    return {"title": table.title, "rows": rows, "notes": list(table.notes)}


def _one(table: Table, how: Format) -> str:
    if how is Format.CSV:
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(table.headers)
        writer.writerows(["" if cell is None else cell for cell in row] for row in table.rows)
        return f"# {table.title}\n{text.getvalue()}"
    from tabulate import tabulate

    rows = [["" if cell is None else str(cell) for cell in row] for row in table.rows]
    limits = _limits(table.headers, rows) if how is Format.TABLE and rows else None
    body = tabulate(rows, table.headers, _TABULATE[how], disable_numparse=True, maxcolwidths=limits)
    if how is Format.LATEX:
        notes = "".join(f"% {note}\n" for note in table.notes)
        return f"% {table.title}\n{body}\n{notes}"
    if how is Format.MARKDOWN:
        return f"### {table.title}\n\n{body}\n" + "".join(f"\n{note}\n" for note in table.notes)
    notes = "".join(fill(note, WIDTH) + "\n" for note in table.notes)
    return f"{table.title}\n\n{body}\n{notes}"


def _limits(headers: Sequence[str], rows: Sequence[Sequence[str]]) -> list[int | None]:
    """The last column takes what the others leave of the terminal."""
    widths = [max(len(cell) for cell in column) for column in zip(headers, *rows, strict=True)]
    left = WIDTH - sum(widths[:-1]) - 2 * (len(widths) - 1)
    return [None] * (len(widths) - 1) + [max(NARROWEST, left) if widths[-1] > left else None]
