"""`scaloft-fi coverage`: how much of the situations a campaign covers."""

from __future__ import annotations

from pathlib import Path

from scaloft_fi.cli.answer import answer, tables_option
from scaloft_fi.cli.options import campaign_option, format_option, study_option
from scaloft_fi.cli.verb import verb


@verb(
    "coverage",
    examples=(
        ("Ask how much of the grid was flown, pair by pair", "scaloft-fi coverage"),
        ("Look at another campaign", "scaloft-fi coverage --campaign night"),
        ("Let a script read it", "scaloft-fi coverage --format json"),
    ),
)
@study_option
@campaign_option
@format_option
@tables_option
def coverage_command(study_folder: Path | None, campaign: str, style: str, tables_folder: Path | None) -> None:
    """Print the coverage of a campaign's situations, number by number."""
    from scaloft_fi.study import Study
    from scaloft_fi.views.answers.coverage import coverage

    answer(coverage(Study.open(study_folder), campaign), style, tables_folder)
