"""A table as data, and how it is printed: text, Markdown, CSV, JSON or LaTeX."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from functools import cache, lru_cache
from textwrap import fill

from scaloft_fi.results.telling.literal import markdown, printable

WIDTH = 120
"""Columns of a terminal that a text table keeps within."""

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
    """A titled table with notes under it; its widest columns but the first are wrapped when it is too wide."""

    title: str
    headers: tuple[str, ...]
    rows: tuple[tuple[Cell, ...], ...]
    notes: tuple[str, ...] = ()

    def records(self) -> list[dict[str, Cell]]:
        """The rows as plain JSON values, by header."""
        return [dict(zip(self.headers, row, strict=True)) for row in self.rows]


def render(tables: Sequence[Table], how: Format) -> str:
    """The tables as one text, ending in a line break."""
    if how is Format.JSON:
        return json.dumps([_plain(table) for table in tables], indent=2, allow_nan=False) + "\n"
    return "\n".join(_one(table, how) for table in tables)


def _plain(table: Table) -> dict[str, object]:
    return {"title": table.title, "rows": table.records(), "notes": list(table.notes)}


def _one(table: Table, how: Format) -> str:
    if how is Format.CSV:
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(table.headers)
        writer.writerows(["" if cell is None else cell for cell in row] for row in table.rows)
        return f"# {table.title}\n{text.getvalue()}"
    from tabulate import tabulate

    literal = markdown if how is Format.MARKDOWN else printable
    rows = [["" if cell is None else literal(str(cell)) for cell in row] for row in table.rows]
    if how is Format.TABLE and rows:
        limits = _limits(table.headers, rows)
        rows = [list(map(_wrapped, row, limits)) for row in rows]
    body = tabulate(rows, table.headers, _TABULATE[how], disable_numparse=True)
    if how is Format.LATEX:
        notes = "".join(f"% {note}\n" for note in table.notes)
        return f"% {table.title}\n{body}\n{notes}"
    if how is Format.MARKDOWN:
        return f"### {markdown(table.title)}\n\n{body}\n" + "".join(f"\n{note}\n" for note in table.notes)
    notes = "".join(fill(note, WIDTH) + "\n" for note in table.notes)
    return f"{table.title}\n\n{body}\n{notes}"


def _wrapped(cell: str, limit: int | None) -> str:
    return cell if limit is None or len(cell) <= limit else fill(cell, limit)


def _limits(headers: Sequence[str], rows: Sequence[Sequence[str]]) -> list[int | None]:
    """What each column may take of the terminal: first to give way is the column that costs the fewest lines.

    The first column names its row and gives way last; words are broken only when nothing else helps.
    """
    columns = list(zip(*rows, strict=True))
    # tabulate keeps a column two wider than its header
    least = [len(header) + 2 for header in headers]
    words = [max(low, max(map(_longest_word, column))) for low, column in zip(least, columns, strict=True)]
    natural = [max(low, *map(len, column)) for low, column in zip(least, columns, strict=True)]
    words[0] = natural[0]
    widths = _narrowed(_narrowed(natural, words, rows), least, rows)
    return [width if width < wanted else None for width, wanted in zip(widths, natural, strict=True)]


def _longest_word(cell: str) -> int:
    return max(map(len, cell.split()), default=0)


def _narrowed(widths: Sequence[int], least: Sequence[int], rows: Sequence[Sequence[str]]) -> list[int]:
    """`widths` taken in until the table fits the terminal or every column is at its `least`."""
    found = list(widths)
    columns = list(zip(*rows, strict=True))

    @cache
    def lines(column: int, width: int) -> list[int]:
        return [1 if len(cell) <= width else _lines(cell, width) for cell in columns[column]]

    def cost(column: int) -> int:
        """Lines that the table gains when this column is narrower by one."""
        narrower = lines(column, found[column] - 1)
        return sum(now - height for now, height in zip(narrower, heights, strict=True) if now > height)

    while sum(found) + 2 * (len(found) - 1) > WIDTH:
        able = [column for column, width in enumerate(found) if width > least[column]]
        if not able:
            break
        heights = [max(row) for row in zip(*map(lines, range(len(found)), found), strict=True)]
        found[min(able, key=lambda able: (cost(able), -found[able], -able))] -= 1
    return found


@lru_cache(maxsize=100_000)
def _lines(cell: str, width: int) -> int:
    """Lines that a cell takes, wrapped between its words, and within those that are longer."""
    lines, left = 1, width
    for word in cell.split():
        need = len(word) + (left < width)
        if need > left:
            lines += left < width
            lines += (len(word) - 1) // width
            left = width - ((len(word) - 1) % width + 1)
        else:
            left -= need
    return lines
