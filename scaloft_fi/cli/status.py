"""`scaloft-fi status`: what a campaign holds."""

from __future__ import annotations

from pathlib import Path

from scaloft_fi.cli.answer import answer, tables_option
from scaloft_fi.cli.options import campaign_option, format_option, study_option
from scaloft_fi.cli.verb import verb


@verb(
    "status",
    examples=(
        ("Count the flights of the campaign, and say why some are stale", "scaloft-fi status"),
        ("Look at another campaign", "scaloft-fi status --campaign night"),
        ("Let a script read it", "scaloft-fi status --format json"),
    ),
)
@study_option
@campaign_option
@format_option
@tables_option
def status_command(study_folder: Path | None, campaign: str, style: str, tables_folder: Path | None) -> None:
    """Print how many flights a campaign holds, by status, and why those are stale that do not count any more."""
    from scaloft_fi.study import Study
    from scaloft_fi.views.answers.status import status

    answer(status(Study.open(study_folder), campaign), style, tables_folder)
