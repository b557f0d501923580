"""`scaloft-fi score`: what a campaign's flights say, again, without flying."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from datetime import date
from pathlib import Path
from typing import TYPE_CHECKING

import click

from scaloft_fi.cli.finds import told
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
from scaloft_fi.console import say, tell
from scaloft_fi.errors import InputError
from scaloft_fi.inert import json_text
from scaloft_fi.terminal import coloured

if TYPE_CHECKING:
    from scaloft_fi.analysis.noise import Noise
    from scaloft_fi.analysis.scoring.score import Score
    from scaloft_fi.judge.outcome import Outcome
    from scaloft_fi.judge.rulings import Rulings
    from scaloft_fi.study import Study
    from scaloft_fi.views.tables.table import Table

GROUPINGS = ("guideword", "parameter", "situation", "requirement", "axis")
BELOW = 3
"""Exit code of a score under --fail-under."""


@verb(
    "score",
    examples=(
        ("Ask which faults the tests would have shown", "scaloft-fi score"),
        ("See every mutant, and the score of each guideword", "scaloft-fi score --all --by guideword"),
        ("Hold a pipeline to what a team has accepted", "scaloft-fi score --fail-under 0.3 --ratchet"),
    ),
)
@study_option
@campaign_option
@click.option("--by", "grouping", type=click.Choice(GROUPINGS), help="The score part by part as well.")
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
@today_option
def score_command(
    study_folder: Path | None,
    campaign: str,
    grouping: str | None,
    baseline_from: str | None,
    everything: bool,
    style: str,
    fail_under: float | None,
    ratcheting: bool,
    today: date | None,
) -> int:
    """Say which faults the tests would have shown, which not, how sure that is, and what to do next."""
    from scaloft_fi.analysis.noise import noise_of
    from scaloft_fi.analysis.scoring.score import score_of
    from scaloft_fi.campaign.runs.baseline_pool import borrowed
    from scaloft_fi.study import Study
    from scaloft_fi.views.snapshot import snapshot

    study = Study.open(study_folder)
    with snapshot(study, campaign) as now:
        noise = noise_of(now.outcomes) if not now.study.stack.deterministic else ()
        study, rulings, spending, warning = now.study, now.rulings, now.spending, now.platform_warning
    others: Iterable[Outcome] = ()
    if baseline_from:
        flown = rulings.situations
        listed = study.space.holding(flown).situations
        others = borrowed(study, baseline_from, [key for key, _ in listed if key in flown])
    if warning:
        say(f"warning: {warning}")
    scored = score_of(rulings, study.roster, study.space, spending, others)
    code = report(
        study,
        rulings,
        scored,
        campaign=campaign,
        grouping=grouping,
        everything=everything,
        style=style,
        fail_under=fail_under,
        noise=noise,
    )
    if not ratcheting:
        return code
    from scaloft_fi.cli.dispositions import ratchet

    return ratchet(study, scored, today) or code


def report(
    study: Study,
    rulings: Rulings,
    scored: Score,
    *,
    campaign: str,
    grouping: str | None,
    everything: bool,
    style: str,
    fail_under: float | None,
    noise: Sequence[Noise] = (),
    extra: Sequence[Table] = (),
) -> int:
    """Print what a campaign says; returns the exit code.

    Args:
        study: what was flown.
        rulings: of the campaign.
        scored: its score.
        campaign: its name.
        grouping: `--by`.
        everything: `--all`.
        style: `--format`.
        fail_under: `--fail-under`.
        noise: of a stack that is not deterministic.
        extra: tables that stand behind the others.

    Raises:
        InputError: `--fail-under` where there is no pool to decide by.
    """
    if fail_under is not None and not scored.pooled:
        raise InputError(
            f"--fail-under={fail_under:g} needs a baseline pool: campaign {campaign!r} has fewer than ten baseline "
            "flights wherever a mutant infects; `scaloft-fi run` flies them"
        )
    tell(
        _text(study, rulings, scored, campaign, grouping, everything, style, noise, extra),
        styled=style == "table" and coloured(),
    )
    ratio = scored.mutation_score
    if fail_under is None or (ratio.value is not None and ratio.value >= fail_under):
        return 0
    say(f"mutation score {ratio} is below --fail-under {fail_under:g}")
    return BELOW


def _text(
    study: Study,
    rulings: Rulings,
    scored: Score,
    campaign: str,
    grouping: str | None,
    everything: bool,
    style: str,
    noise: Sequence[Noise],
    extra: Sequence[Table],
) -> str:
    from scaloft_fi.analysis.kills.background import backgrounds
    from scaloft_fi.analysis.plain import by_field
    from scaloft_fi.analysis.scoring.baseline import findings
    from scaloft_fi.analysis.scoring.grouping import By, groups
    from scaloft_fi.analysis.situations.coverage import coverage_of
    from scaloft_fi.views.score.first_screen import first_screen, screen_text
    from scaloft_fi.views.score.score_record import score_json
    from scaloft_fi.views.score.tables import group_table, tables_behind
    from scaloft_fi.views.tables.table import Format, render

    by = By(grouping) if grouping else None
    covered = coverage_of(rulings.baselines, rulings.draws, study.space)
    if style == Format.JSON:
        violated = [(finding.situation, finding.violated) for finding in findings(rulings.baselines, study.space)]
        parts = groups(scored, by, study.space) if by else ()
        values = score_json(scored, covered, violated, parts)
        if noise:
            values["noise"] = [by_field(one) for one in noise]
        for table in extra:
            values[table.title.lower().replace(",", "").replace(" ", "_")] = table.records()
        return json_text(values, indent=2) + "\n"
    screen = first_screen(
        scored,
        study.roster,
        study.space,
        covered,
        lambda id_: backgrounds(study.matrix, [id_])[id_],
        campaign=campaign,
        finds=told(study.finds),
        noise=noise,
        whole=everything or style != Format.TABLE,
    )
    behind: Sequence[Table] = ()
    if everything:
        behind = tables_behind(scored, rulings, covered, study.space, by)
    elif by:
        behind = (group_table(scored, by, study.space),)
    if style != Format.TABLE:
        return render((*screen, *behind, *extra), Format(style))
    text = screen_text(screen)
    return "\n".join([text, render((*behind, *extra), Format.TABLE)] if behind or extra else [text])
