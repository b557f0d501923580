"""`scaloft-fi operators`: list the study's operators, without flying."""

from __future__ import annotations

from pathlib import Path

import click

from scaloft_fi.cli import names as known
from scaloft_fi.cli.answer import tables_option
from scaloft_fi.cli.listing import tell_listing
from scaloft_fi.cli.options import format_option, study_option
from scaloft_fi.cli.verb import verb


@verb(
    "operators",
    examples=(
        ("List all operators", "scaloft-fi operators"),
        ("Show one whole, with its example", "scaloft-fi operators delay"),
        ("Write those that begin with `drop` as JSON", "scaloft-fi operators 'drop*' --format json"),
    ),
)
@click.argument("names", nargs=-1, shell_complete=known.operators, metavar="[NAME]...")
@study_option
@format_option
@tables_option
def operators_command(
    names: tuple[str, ...], study_folder: Path | None, style: str, tables_folder: Path | None
) -> None:
    """List the operators that faults can use.

    Without a NAME an overview; NAME, or a pattern with *, ? or [, shows these whole: arguments with units and
    ranges, the seams of this study that it fits, the package that declares it, and samples before and after it.
    """
    from scaloft_fi.views.lists.operators import operator_list

    tell_listing(operator_list, names, style, study_folder, tables=tables_folder)
