"""How a verb answers: as text for people, as JSON of a declared form, or as CSV, one table a file."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from scaloft_fi.cli.files import check_folder, make_folder, write
from scaloft_fi.console import say, tell

if TYPE_CHECKING:
    from scaloft_fi.views.outputs.answer import Answer

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


def answer(given: Answer, style: str, folder: Path | None = None) -> None:
    """Print a verb's answer and its warnings, and write its tables where `--tables` asks for them.

    Args:
        given: the answer.
        style: `--format`.
        folder: `--tables`.

    Raises:
        InputError: a table cannot be written.
    """
    tell_warnings(given)
    if folder is not None:
        make_folder(folder, "--tables")
        for name, text in given.csv().items():
            write(folder / f"{name}.csv", text.encode(), "--tables")
    tell(given.text(style))


def tell_warnings(given: Answer) -> None:
    """Say on standard error what a reader must know beside an answer."""
    for warning in given.warnings:
        say(f"warning: {warning}")


def _checked(_context: click.Context, _option: click.Parameter, folder: Path | None) -> Path | None:
    if folder is not None:
        check_folder(folder, "--tables")
    return folder
