"""`scaloft-fi seams`: list the study's seams, without flying."""

from __future__ import annotations

from pathlib import Path

import click

from scaloft_fi.cli import names as known
from scaloft_fi.cli.answer import tables_option
from scaloft_fi.cli.listing import tell_listing
from scaloft_fi.cli.options import format_option, study_option
from scaloft_fi.cli.verb import verb


@verb(
    "seams",
    examples=(
        ("List all seams", "scaloft-fi seams"),
        ("Show one whole, with the operators that fit", "scaloft-fi seams velcmd"),
        ("Write them all as JSON", "scaloft-fi seams --format json"),
    ),
)
@click.argument("names", nargs=-1, shell_complete=known.seams, metavar="[NAME]...")
@study_option
@format_option
@tables_option
def seams_command(names: tuple[str, ...], study_folder: Path | None, style: str, tables_folder: Path | None) -> None:
    """List the seams of the study's stack, where faults can be patched in.

    Without a NAME an overview; NAME, or a pattern with *, ? or [, shows these whole: the fields with their units,
    what the consumer acts on, the operators that fit, and the cells that use the seam.
    """
    from scaloft_fi.views.lists.seams import seam_list

    tell_listing(seam_list, names, style, study_folder, tables=tables_folder)
