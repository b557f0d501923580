"""How a verb answers: as text for people, as JSON of a declared form, or as CSV, one table a file."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from scaloft_fi.cli.files import check_folder, make_folder, write
from scaloft_fi.console import tell

if TYPE_CHECKING:
    from scaloft_fi.views.outputs.output import Output
    from scaloft_fi.views.tables.table import Format

F = TypeVar("F", bound=Callable[..., Any])


def tables_option(function: F) -> F:
    """`--tables DIR`: every table as a CSV file."""
    return click.option(
        "--tables",
        "tables_folder",
        type=click.Path(path_type=Path),
        callback=_checked,
        metavar="DIR",
        help="Also write each table of --format json as a CSV file of its own into the folder DIR, made if missing.",
    )(function)


def line_format_option(function: F) -> F:
    """`--format` of a verb whose answer is a few lines, not a table."""
    return click.option(
        "--format",
        "style",
        type=click.Choice(("table", "json")),
        default="table",
        show_default=True,
        help="How the answer is printed: a line for people, or JSON.",
    )(function)


def answer(
    output: Output,
    values: Callable[[], Mapping[str, Any]],
    style: str,
    shown: Callable[[Format], str],
    folder: Path | None = None,
    *,
    rows: str = "",
) -> None:
    """Print a verb's answer, and write its tables where `--tables` asks for them.

    Args:
        output: the form of its JSON.
        values: makes the plain JSON values of the form.
        style: `--format`; `csv` prints one table.
        shown: makes the text for people.
        folder: `--tables`.
        rows: name of the table that `csv` prints; by default the one of the form.

    Raises:
        InputError: a table cannot be written.
    """
    from scaloft_fi.views.outputs.csv_tables import csv_tables
    from scaloft_fi.views.tables.table import Format

    how = Format(style)
    if folder is not None or how in (Format.JSON, Format.CSV):
        given = values()
        if folder is not None:
            _write(csv_tables(output, given), folder)
        if how is Format.JSON:
            tell(output.json(given))
        elif how is Format.CSV:
            tell(csv_tables(output, given)[rows or output.rows])
    if how not in (Format.JSON, Format.CSV):
        tell(shown(how))


def _checked(_context: click.Context, _option: click.Parameter, folder: Path | None) -> Path | None:
    if folder is not None:
        check_folder(folder, "--tables")
    return folder


def _write(tables: Mapping[str, str], folder: Path) -> None:
    make_folder(folder, "--tables")
    for name, text in tables.items():
        write(folder / f"{name}.csv", text.encode(), "--tables")
