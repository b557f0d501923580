"""`scaloft-fi dispositions`: the survivors of a campaign beside those that were accepted."""

from __future__ import annotations

from datetime import date
from pathlib import Path
from typing import TYPE_CHECKING

import click

from scaloft_fi.cli.answer import answer
from scaloft_fi.cli.options import campaign_option, format_option, study_option, today_option
from scaloft_fi.cli.verb import verb
from scaloft_fi.console import say
from scaloft_fi.errors import ExitCode
from scaloft_fi.views.own_study import check_own

if TYPE_CHECKING:
    from scaloft_fi.analysis.score import Score
    from scaloft_fi.study import Study
    from scaloft_fi.views.columns import Columns


@verb(
    "dispositions",
    examples=(
        ("List what survives, and what was accepted", "scaloft-fi dispositions"),
        ("Draft an entry for each open survivor", "scaloft-fi dispositions --write"),
        ("See what will have expired by a day", "scaloft-fi dispositions --today 2027-01-31"),
    ),
)
@study_option
@campaign_option
@click.option(
    "--write",
    "writing",
    is_flag=True,
    help="Append every survivor that is not accepted to the study's hazop/dispositions.yaml, with owner, reason and "
    "expiry left empty: the file is refused until somebody has filled them in.",
)
@today_option
@format_option
def dispositions_command(
    study_folder: Path | None, campaign: str, writing: bool, today: date | None, style: str
) -> None:
    """List the survivors of a campaign beside the study's dispositions.

    `scaloft-fi score --ratchet` makes a gate of it.
    """
    from scaloft_fi.study import Study
    from scaloft_fi.views.answers.dispositions import dispositions

    study = Study.open(study_folder)
    if writing:
        check_own(study, study_folder, study.dispositions_path)
    told = dispositions(study, campaign, today)
    answer(told, style)
    if writing:
        _draft(study.dispositions_path, told["survivors"])


def ratchet(study: Study, scored: Score, today: date | None) -> int:
    """Say on standard error what does not pass and what can go; returns the exit code.

    Raises:
        InputError: there is no baseline pool to decide by.
    """
    from scaloft_fi.analysis.survivor import Standing
    from scaloft_fi.views.answers.dispositions import judged_survivors
    from scaloft_fi.views.dispositions import complaint

    judged = judged_survivors(study, scored, today)
    for entry in judged:
        if entry.state is Standing.STALE:
            say(f"warning: {complaint(entry)}")
    failing = [entry for entry in judged if entry.state.fails]
    for entry in failing:
        say(f"ratchet: {complaint(entry)}")
    if not scored.tested.part:
        say("ratchet: no counted mutant was put to the test; there is nothing to hold")
    return ExitCode.BELOW if failing or not scored.tested.part else ExitCode.DONE


def _draft(path: Path, survivors: Columns) -> None:
    """Append an entry for each survivor that nobody has accepted, and say so."""
    from scaloft_fi.analysis.survivor import Standing
    from scaloft_fi.study import append_drafts

    opened = list(survivors["mutant"][survivors["state"] == Standing.OPEN])
    if not opened:
        say("nothing to write: no survivor without a disposition")
        return
    append_drafts(path, opened)
    counted = f"{len(opened)} survivor{'s' * (len(opened) != 1)}"
    say(f"{path}: {counted} to decide on; fill in owner, reason and expires")
