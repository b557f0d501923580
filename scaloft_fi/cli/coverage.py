"""`scaloft-fi coverage`: how much of the situations a campaign covers."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from scaloft_fi.cli.options import campaign_option, format_option, study_option
from scaloft_fi.cli.verb import verb
from scaloft_fi.console import tell
from scaloft_fi.inert import json_text

if TYPE_CHECKING:
    from scaloft_fi.campaign.runs.choice import Remembered


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
def coverage_command(study_folder: Path | None, campaign: str, style: str) -> None:
    """Print the coverage of a campaign's situations, number by number."""
    from scaloft_fi.analysis.situations.coverage import coverage_json, coverage_of
    from scaloft_fi.study import Study
    from scaloft_fi.views.coverage.coverage_tables import coverage_tables
    from scaloft_fi.views.snapshot import snapshot
    from scaloft_fi.views.tables.table import Format, render

    study = Study.open(study_folder)
    with snapshot(study, campaign) as now:
        study, rulings, choices = now.study, now.rulings, now.choices
    covered = coverage_of(rulings.baselines, rulings.draws, study.space)
    if style == Format.JSON:
        content = {"coverage": coverage_json(covered), "choices": [_choice(one) for one in choices]}
        tell(f"{json_text(content, indent=2)}\n")
        return
    made = [(one.text, one.seed, len(one.draws), len({key for key, _ in one.draws})) for one in choices]
    tell(render(coverage_tables(covered, study.space, made), Format(style)))


def _choice(one: Remembered) -> dict[str, object]:
    return {"choose": one.text, "seed": one.seed, "pool": one.pool, "draws": [list(draw) for draw in one.draws]}
