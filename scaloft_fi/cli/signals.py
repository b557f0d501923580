"""`scaloft-fi signals`: list the study's signals, without flying."""

from __future__ import annotations

from pathlib import Path

import click

from scaloft_fi.cli import names as known
from scaloft_fi.cli.answer import tables_option
from scaloft_fi.cli.listing import tell_listing
from scaloft_fi.cli.options import format_option, grid_of_study_option, study_option
from scaloft_fi.cli.verb import verb


@verb(
    "signals",
    examples=(
        ("List all signals", "scaloft-fi signals"),
        ("Show two of them whole", "scaloft-fi signals person_sight_m speed_mps"),
        ("List what the grid `wide` adds, as CSV", "scaloft-fi signals --grid wide --format csv"),
    ),
)
@click.argument("names", nargs=-1, shell_complete=known.signals, metavar="[NAME]...")
@study_option
@grid_of_study_option
@format_option
@tables_option
def signals_command(
    names: tuple[str, ...], study_folder: Path | None, grid: str | None, style: str, tables_folder: Path | None
) -> None:
    """List the signals that the study's requirements and the predicates of its axes may use.

    Without a NAME an overview; NAME, or a pattern with *, ? or [, shows these whole: range, unit, what the signal
    reads where there is nothing to measure, where it comes from, and a formula that uses it.
    """
    from scaloft_fi.views.lists.signals import signal_list

    tell_listing(signal_list, names, style, study_folder, grid, tables=tables_folder)
