"""`scaloft-fi check`: the whole study dry."""

from __future__ import annotations

from pathlib import Path

import click

from scaloft_fi.cli.options import format_option, study_option
from scaloft_fi.console import tell

WRONG = 2
"""Exit code of a study with an error, as of any verb that refuses it."""


@click.command("check")
@study_option
@click.option("--fly", is_flag=True, help="Fly one baseline flight too, and show which seams the stack polls.")
@format_option
def check_command(study_folder: Path | None, *, fly: bool, style: str) -> int:
    """Check the whole study without flying, and print every finding with its place and remedy.

    An error (exit code 2) is what a verb would refuse, or what no flight can mean; a note (exit code 0) is what
    somebody should know.  Nothing is written.
    """
    from scaloft_fi.checks.check import check_study
    from scaloft_fi.hazop.folder import find_study
    from scaloft_fi.views.checks import checked_table, finding_lines, findings_table
    from scaloft_fi.views.tables.table import Format, render

    check = check_study(find_study(study_folder), fly=fly)
    if Format(style) is Format.TABLE:
        lines, summary = finding_lines(check), render((checked_table(check),), Format.TABLE)
        tell(f"{lines}\n{summary}" if lines else summary)
    else:
        tell(render((findings_table(check), checked_table(check)), Format(style)))
    return WRONG if check.errors else 0
