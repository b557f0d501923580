"""`scaloft-fi score`: what a campaign's flights say, again, without flying."""

from __future__ import annotations

from datetime import date
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import click

from scaloft_fi.cli.answer import answer, tables_option
from scaloft_fi.cli.options import (
    all_option,
    baseline_from_option,
    campaign_option,
    fail_under_option,
    format_option,
    study_option,
    today_option,
)
from scaloft_fi.cli.verb import verb
from scaloft_fi.console import say
from scaloft_fi.errors import ExitCode, InputError

if TYPE_CHECKING:
    from scaloft_fi.views.outputs.output import Output
    from scaloft_fi.views.scored_campaign import ScoredCampaign

GROUPINGS = ("guideword", "parameter", "severity", "situation", "requirement", "axis")


@verb(
    "score",
    examples=(
        ("Ask which faults the tests would have shown", "scaloft-fi score"),
        ("See every mutant, and the score of each guideword", "scaloft-fi score --all --by guideword"),
        ("Hold a pipeline to what a team has accepted", "scaloft-fi score --fail-under-firm 0.25 --ratchet"),
    ),
    sections={
        "Where": "--study --campaign --baseline-from",
        "What fails": "--fail-under --fail-under-firm --ratchet --today",
        "What is printed": "--by --all --format --tables --help",
    },
)
@study_option
@campaign_option
@click.option(
    "--by",
    "grouping",
    type=click.Choice(GROUPINGS),
    metavar="WHAT",
    help=f"The score part by part as well, by {', '.join(GROUPINGS[:-1])} or {GROUPINGS[-1]}.",
)
@baseline_from_option
@all_option
@format_option
@fail_under_option
@click.option(
    "--ratchet",
    "ratcheting",
    is_flag=True,
    help="Exit with 3 when a counted mutant is not detected that the study's hazop/dispositions.yaml does not accept, "
    "or a disposition has expired.",
)
@tables_option
@today_option
def score_command(
    study_folder: Path | None,
    campaign: str,
    grouping: str | None,
    baseline_from: str | None,
    everything: bool,
    style: str,
    fail_under: float | None,
    fail_under_firm: float | None,
    ratcheting: bool,
    tables_folder: Path | None,
    today: date | None,
) -> int:
    """Say which faults the tests would have shown, which not, how sure that is, and what to do next."""
    from scaloft_fi.study import Study
    from scaloft_fi.views.score.score_form import SCORE
    from scaloft_fi.views.scored_campaign import scored_campaign

    scored = scored_campaign(Study.open(study_folder), campaign, baseline_from, today)
    code = report(
        scored,
        SCORE,
        grouping=grouping,
        everything=everything,
        style=style,
        tables=tables_folder,
        bars=Bars(fail_under, fail_under_firm),
    )
    if not ratcheting:
        return code
    from scaloft_fi.cli.dispositions import ratchet

    return ratchet(scored.study, scored.score, today) or code


class Bars(NamedTuple):
    """The least ratios that count as a success; None asks for nothing."""

    detected: float | None
    firm: float | None

    def __bool__(self) -> bool:
        return self.detected is not None or self.firm is not None

    def __str__(self) -> str:
        """The first option that is given, as the user wrote it."""
        if self.detected is not None:
            return f"--fail-under={self.detected:g}"
        return f"--fail-under-firm={self.firm:g}"


def report(
    scored: ScoredCampaign,
    output: Output,
    *,
    grouping: str | None,
    everything: bool,
    style: str,
    tables: Path | None,
    bars: Bars,
) -> int:
    """Print what a campaign says; returns the exit code.

    Args:
        scored: the campaign with its score.
        output: the form of its JSON.
        grouping: `--by`.
        everything: `--all`.
        style: `--format`.
        tables: `--tables`.
        bars: `--fail-under` and `--fail-under-firm`.

    Raises:
        InputError: one of the bars where there is no pool to decide by.
    """
    if bars and not scored.score.pooled:
        raise InputError(
            f"{bars} needs a baseline pool: campaign {scored.campaign!r} has fewer than ten "
            "baseline flights wherever a mutant infects; `scaloft-fi run` flies them"
        )
    from scaloft_fi.analysis.score import By

    by = By(grouping) if grouping else None
    answer(scored.answer(output, by, everything=everything), style, tables)
    detected, firm = scored.score.mutation_score, scored.score.firm
    below = [
        f"{option} {least:g}"
        for option, least, ratio in (
            ("--fail-under", bars.detected, detected),
            ("--fail-under-firm", bars.firm, firm),
        )
        if least is not None and (ratio.value is None or ratio.value < least)
    ]
    if not below:
        return 0
    say(f"mutation score {detected}, firm {firm}: below {' and '.join(below)}")
    return ExitCode.BELOW
