"""`scaloft-fi check`: the whole study dry."""

from __future__ import annotations

from pathlib import Path

import click

from scaloft_fi.cli.answer import answer, tables_option
from scaloft_fi.cli.options import format_option, study_option
from scaloft_fi.cli.verb import verb
from scaloft_fi.errors import ExitCode


@verb(
    "check",
    examples=(
        ("Check the study before the first flight", "scaloft-fi check"),
        ("See too which seams the stack polls, by one flight", "scaloft-fi check --fly"),
        ("Let a script read the findings", "scaloft-fi check --study my_study --format json"),
    ),
)
@study_option
@click.option("--fly", is_flag=True, help="Fly one baseline flight too, and show which seams the stack polls.")
@format_option
@tables_option
def check_command(study_folder: Path | None, *, fly: bool, style: str, tables_folder: Path | None) -> int:
    """Check the whole study without flying, and print every finding with its place and remedy.

    An error (exit code 2) is what a verb would refuse, or what no flight can mean; a note (exit code 0) is what
    somebody should know.  Nothing in the study is written.
    """
    from scaloft_fi.checks.check import check_study
    from scaloft_fi.hazop.load import find_study
    from scaloft_fi.views.answers.check import checked

    check = check_study(find_study(study_folder), fly=fly)

    answer(checked(check), style, tables_folder)
    return ExitCode.BAD_INPUT if check.errors else ExitCode.DONE
