"""A table as data, and how it is printed: text, Markdown, CSV, JSON or LaTeX."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from enum import StrEnum

from scaloft_fi.console import Marked, coloured, json_text, line
from scaloft_fi.console import width as terminal_width
from scaloft_fi.views.tables.literal import markdown, spreadsheet_text
from scaloft_fi.views.tables.text import body_text, heading, note

TableCell = str | int | float | None


class Format(StrEnum):
    """How tables are printed."""

    TABLE = "table"
    MARKDOWN = "markdown"
    CSV = "csv"
    JSON = "json"
    LATEX = "latex"


_TABULATE = {Format.MARKDOWN: "github", Format.LATEX: "latex_booktabs"}
_HARMLESS = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?|-", re.ASCII)


@dataclass(frozen=True)
class Table:
    """A titled table.

    Attributes:
        title: of the table.
        headers: of the columns.
        rows: the values, those of a row in the order of the headers.
        notes: sentences under the table.
        spare: headers of the columns that a narrow terminal does without, in the order in which they are left out.
    """

    title: str
    headers: tuple[str, ...]
    rows: tuple[tuple[TableCell, ...], ...]
    notes: tuple[str, ...] = ()
    spare: tuple[str, ...] = ()

    def records(self) -> list[dict[str, TableCell]]:
        """The rows as plain JSON values, by header."""
        return [dict(zip(self.headers, row, strict=True)) for row in self.rows]


def render(tables: Sequence[Table], how: Format, *, width: int | None = None, marked: bool | None = None) -> str:
    """The tables as one text, ending in a line break.

    Args:
        tables: to render.
        how: the format.
        width: of the terminal, for text [characters]; that of standard output when None.
        marked: whether text has colours; as standard output has them when None.
    """
    if how is Format.JSON:
        return json_text([_plain(table) for table in tables], indent=2) + "\n"
    if how is Format.TABLE:
        columns = terminal_width() if width is None else width
        colours = coloured() if marked is None else marked
        text = "\n".join(_text(table, columns, marked=colours) for table in tables)
        return Marked(text) if colours else text
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
        how: Markdown or LaTeX.
        style: the table style of `tabulate`; by default the one of `how`.
    """
    import tabulate

    tabulate.MIN_PADDING = 0  # a header needs no more room than its letters

    literal = markdown if how is Format.MARKDOWN else line  # tabulate escapes LaTeX itself
    names = list(map(literal, headers))
    return tabulate.tabulate(_cells(rows, literal), names, style or _TABULATE[how], disable_numparse=True)


def _cells(rows: Iterable[Sequence[TableCell]], literal: Callable[[str], str]) -> list[list[str]]:
    return [["" if cell is None else literal(str(cell)) for cell in row] for row in rows]


def _plain(table: Table) -> dict[str, object]:
    return {"title": table.title, "rows": table.records(), "notes": list(table.notes)}


def _text(table: Table, width: int, *, marked: bool) -> str:
    """The table for a terminal, with a blank line between its title and its body."""
    headers, rows = list(map(line, table.headers)), _cells(table.rows, line)
    parts = [heading(line(table.title), width, marked=marked), ""]
    parts.append(body_text(headers, rows, width, table.spare, marked=marked))
    parts += [note(line(each), width, marked=marked) for each in table.notes]
    return "\n".join(parts) + "\n"


def _one(table: Table, how: Format) -> str:
    title, notes = line(table.title), list(map(line, table.notes))
    if how is Format.CSV:
        return csv_text([f"# {title}"], ()) + csv_text(table.headers, table.rows)
    body = tabulated(table.headers, table.rows, how)
    if how is Format.LATEX:
        return f"% {title}\n{body}\n" + "".join(f"% {note}\n" for note in notes)
    return f"### {markdown(title)}\n\n{body}\n" + "".join(f"\n{note}\n" for note in notes)


def _in_csv(value: object) -> object:
    """A text that a spreadsheet takes for a number, and the sign `-` alone, are no formulas."""
    if isinstance(value, str) and value[:1].isalnum() and value.isprintable():
        return value  # nearly every cell, without a search
    return spreadsheet_text(value) if isinstance(value, str) and not _HARMLESS.fullmatch(value) else value
