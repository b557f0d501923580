"""The JSON of a verb as CSV, one table a file; lists have `;` between, and nothing stands where JSON has null."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from scaloft_fi.views.outputs.flat import SUMMARY, Flat, flat_tables
from scaloft_fi.views.outputs.output import Output
from scaloft_fi.views.tables.table import csv_text


def csv_tables(output: Output, values: Mapping[str, Any]) -> dict[str, str]:
    """The CSV text of each table by its name; the summary has a line for each value."""
    return {name: _text(name, flat) for name, flat in flat_tables(output, values).items()}


def _text(name: str, flat: Flat) -> str:
    rows = [[cell(value) for value in row] for row in flat.rows]
    if name == SUMMARY:
        return csv_text(("what", "value"), zip(flat.columns, *rows, strict=True))
    return csv_text(flat.columns, rows)


def table_names(output: Output) -> list[str]:
    """The names of its tables."""
    return list(flat_tables(output, dict.fromkeys(output.keys)))


def cell(value: Any) -> Any:
    """A plain JSON value as one cell.

    >>> cell([["a", "b"], True])
    'a;b;true'
    """
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, list | tuple):
        return ";".join(str(cell(entry)) for entry in value)
    return value
