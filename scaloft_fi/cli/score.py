"""`scaloft-fi score`: the tables of a campaign again, without flying."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
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
    from scaloft_fi.results.rulings import Rulings
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
    from scaloft_fi.campaign.held.held import current_rulings
    from scaloft_fi.campaign.runs.baseline_pool import borrowed
    from scaloft_fi.study import Study

    study = Study.open(study_folder)
    rulings = current_rulings(study, campaign)
    others: Sequence[Outcome] = ()
    if baseline_from:
        flown = rulings.situations
        others = borrowed(study, baseline_from, [key for key, _ in study.space.points if key in flown])
    scored = score_beside(study, rulings, others)
    code = report(study, rulings, scored, grouping, style, fail_under)
    if not ratcheting:
        return code
    from scaloft_fi.cli.dispositions import ratchet

    return ratchet(study, scored, today) or code


def score_beside(study: Study, rulings: Rulings, others: Iterable[Outcome]) -> Score:
    """The score of a campaign that is decided by the baselines of another campaign too."""
    from scaloft_fi.campaign.runs.baseline_pool import joined
    from scaloft_fi.results.scoring.score import score_of

    return score_of(rulings, study.roster, study.space, joined(rulings.baselines, others))


def report(
    study: Study,
    rulings: Rulings,
    scored: Score,
    grouping: str | None,
    style: str,
    fail_under: float | None,
    extra: Sequence[Table] = (),
) -> int:
    """Print the tables of a campaign; returns the exit code.

    Args:
        study: what was flown.
        rulings: of the campaign.
        scored: its score.
        grouping: `--by`.
        style: `--format`.
        fail_under: `--fail-under`.
        extra: tables that stand behind the others.
    """
    click.echo(_text(study, rulings, scored, grouping, style, extra), nl=False)
    ratio = scored.mutation_score
    if fail_under is None or (ratio.value is not None and ratio.value >= fail_under):
        return 0
    click.echo(f"mutation score {ratio} is below --fail-under {fail_under:g}", err=True)
    return BELOW


def _text(
    study: Study,
    rulings: Rulings,
    scored: Score,
    grouping: str | None,
    style: str,
    extra: Sequence[Table],
) -> str:
    from scaloft_fi.results.scoring.baseline import findings
    from scaloft_fi.results.scoring.grouping import By
    from scaloft_fi.results.scoring.score_record import score_json
    from scaloft_fi.results.scoring.tables import tables_of
    from scaloft_fi.results.situations.coverage import coverage_of
    from scaloft_fi.results.telling.table import Format, render

    by = By(grouping) if grouping else None
    if style != Format.JSON:
        return render((*tables_of(scored, rulings, study.roster, study.space, by), *extra), Format(style))
    import json

    violated = [(finding.situation, finding.violated) for finding in findings(rulings.baselines, study.space)]
    values = score_json(scored, coverage_of(rulings.baselines, rulings.draws, study.space), violated)
    for table in extra:
        values[table.title.lower().replace(",", "").replace(" ", "_")] = table.records()
    return json.dumps(values, indent=2, allow_nan=False) + "\n"
