"""`scaloft-fi score`: the tables of a campaign again, without flying."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import date
from pathlib import Path
from typing import TYPE_CHECKING

import click

from scaloft_fi.cli.options import (
    baseline_from_option,
    campaign_option,
    fail_under_option,
    format_option,
    study_option,
    today_option,
)
from scaloft_fi.collector import uncollected

if TYPE_CHECKING:
    from scaloft_fi.results.outcome import Outcome
    from scaloft_fi.results.scoring.score import Score
    from scaloft_fi.results.telling.table import Table
    from scaloft_fi.study import Study

GROUPINGS = ("guideword", "parameter", "situation", "requirement", "axis")
BELOW = 3
"""Exit code of a score under --fail-under."""


@click.command("score")
@study_option
@campaign_option
@click.option("--by", "grouping", type=click.Choice(GROUPINGS), help="The score part by part as well.")
@baseline_from_option
@format_option
@fail_under_option
@click.option(
    "--ratchet",
    "ratcheting",
    is_flag=True,
    help="Exit with 3 when a counted mutant survives that the study's hazop/dispositions.yaml does not accept, or a "
    "disposition has expired.",
)
@today_option
@uncollected()
def score_command(
    study_folder: Path | None,
    campaign: str,
    grouping: str | None,
    baseline_from: str | None,
    style: str,
    fail_under: float | None,
    ratcheting: bool,
    today: date | None,
) -> int:
    """Print the score, the mutants, the baseline's findings and the coverage of a campaign."""
    from scaloft_fi.campaign.held.held import current
    from scaloft_fi.campaign.runs.baseline_pool import borrowed
    from scaloft_fi.study import Study

    study = Study.open(study_folder)
    outcomes = current(study, campaign, brief=True)
    others: Sequence[Outcome] = ()
    if baseline_from:
        flown = {outcome.situation for outcome in outcomes}
        others = borrowed(study, baseline_from, [key for key, _ in study.space.points if key in flown])
    code = report(study, outcomes, grouping, style, fail_under, others=others)
    if not ratcheting:
        return code
    from scaloft_fi.cli.dispositions import ratchet

    return ratchet(study, outcomes, today) or code


def report(
    study: Study,
    outcomes: Sequence[Outcome],
    grouping: str | None,
    style: str,
    fail_under: float | None,
    extra: Sequence[Table] = (),
    others: Sequence[Outcome] = (),
) -> int:
    """Print the tables of `outcomes`; returns the exit code.

    Args:
        study: what was flown.
        outcomes: of the campaign.
        grouping: `--by`.
        style: `--format`.
        fail_under: `--fail-under`.
        extra: tables that stand behind the others.
        others: baselines of another campaign, to decide by.
    """
    from scaloft_fi.campaign.runs.baseline_pool import joined
    from scaloft_fi.results.scoring.score import score
    from scaloft_fi.results.status import whole

    outcomes = whole(outcomes)
    scored = score(outcomes, study.roster, study.space, joined(outcomes, others))
    click.echo(_text(study, outcomes, scored, grouping, style, extra), nl=False)
    ratio = scored.mutation_score
    if fail_under is None or (ratio.value is not None and ratio.value >= fail_under):
        return 0
    click.echo(f"mutation score {ratio} is below --fail-under {fail_under:g}", err=True)
    return BELOW


def _text(
    study: Study,
    outcomes: Sequence[Outcome],
    scored: Score,
    grouping: str | None,
    style: str,
    extra: Sequence[Table],
) -> str:
    from scaloft_fi.results.scoring.baseline import findings
    from scaloft_fi.results.scoring.grouping import By
    from scaloft_fi.results.scoring.score_record import score_json
    from scaloft_fi.results.scoring.tables import tables_of
    from scaloft_fi.results.situations.coverage import coverage
    from scaloft_fi.results.telling.table import Format, render

    by = By(grouping) if grouping else None
    if style != Format.JSON:
        return render((*tables_of(scored, outcomes, study.roster, study.space, by), *extra), Format(style))
    import json

    violated = [(finding.situation, finding.violated) for finding in findings(outcomes, study.space)]
    values = score_json(scored, coverage(outcomes, study.space), violated)
    for table in extra:
        values[table.title.lower().replace(",", "").replace(" ", "_")] = table.records()
    return json.dumps(values, indent=2, allow_nan=False) + "\n"
