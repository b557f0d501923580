"""`scaloft-fi diff`: hold two campaigns against each other."""

from __future__ import annotations

from pathlib import Path

import click

from scaloft_fi.cli import names
from scaloft_fi.cli.answer import answer
from scaloft_fi.cli.options import format_option, study_option
from scaloft_fi.cli.verb import verb
from scaloft_fi.errors import InputError


@verb(
    "diff",
    examples=(
        ("Compare two campaigns", "scaloft-fi diff default night"),
        ("Compare with a folder from another machine", "scaloft-fi diff default /data/night/campaign"),
        ("Keep the comparison as a table in a document", "scaloft-fi diff default night --format markdown"),
    ),
)
@click.argument("first", shell_complete=names.campaigns, metavar="CAMPAIGN")
@click.argument("second", shell_complete=names.campaigns, metavar="CAMPAIGN")
@study_option
@format_option
def diff_command(first: str, second: str, study_folder: Path | None, style: str) -> None:
    """Print the flights of which two campaigns do not say the same.

    What was flown with other data or code counts too, unless the campaign has the flight as the study describes it now.
    """
    from scaloft_fi.study import Study
    from scaloft_fi.views.flights.compare import DIFF, compare, comparison_table, comparison_values
    from scaloft_fi.views.snapshot import snapshot
    from scaloft_fi.views.tables.table import render

    study = Study.open(study_folder)
    with snapshot(study, first) as here, snapshot(study, second) as there:
        if here.study.grid.name != there.study.grid.name:
            grids = f"{first!r} was flown over grid {here.study.grid.name!r}, {second!r} over {there.study.grid.name!r}"
            raise InputError(f"campaign {grids}; only campaigns of one grid have the same flights")
        compared = compare(here.latest, there.latest, here.study.roster, here.study.space)
    answer(
        DIFF,
        lambda: comparison_values(compared, first, second),
        style,
        lambda how: render((comparison_table(compared, first, second),), how),
    )
