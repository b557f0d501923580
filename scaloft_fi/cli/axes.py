"""`scaloft-fi axes`: list the study's axes, without flying."""

from __future__ import annotations

from pathlib import Path

import click

from scaloft_fi.cli import names as known
from scaloft_fi.cli.answer import tables_option
from scaloft_fi.cli.listing import tell_listing
from scaloft_fi.cli.options import format_option, grid_of_study_option, study_option
from scaloft_fi.cli.verb import verb


@verb(
    "axes",
    examples=(
        ("List the axes of the study's own grid", "scaloft-fi axes"),
        ("Show one whole", "scaloft-fi axes H"),
        ("List those of the grid `search`, as Markdown", "scaloft-fi axes --grid search --format markdown"),
    ),
)
@click.argument("names", nargs=-1, shell_complete=known.axes, metavar="[NAME]...")
@study_option
@grid_of_study_option
@format_option
@tables_option
def axes_command(
    names: tuple[str, ...], study_folder: Path | None, grid: str | None, style: str, tables_folder: Path | None
) -> None:
    """List the axes of a grid of situations.

    Without a NAME an overview; NAME, or a pattern with *, ? or [, shows these whole: what each value sets, and the
    formula by which a flight is known to have met it.
    """
    from scaloft_fi.views.lists.axes import axis_list

    tell_listing(lambda study: axis_list(study.grid), names, style, study_folder, grid, tables=tables_folder)
