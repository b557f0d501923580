"""`scaloft-fi diff`: hold two campaigns against each other."""

from __future__ import annotations

from pathlib import Path

import click

from scaloft_fi.cli import names
from scaloft_fi.cli.answer import answer
from scaloft_fi.cli.options import format_option, study_option
from scaloft_fi.cli.verb import verb


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
    from scaloft_fi.views.answers.diff import diff

    answer(diff(Study.open(study_folder), first, second), style)
