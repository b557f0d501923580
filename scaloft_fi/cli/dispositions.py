"""`scaloft-fi dispositions`: the survivors of a campaign beside those that were accepted."""

from __future__ import annotations

from datetime import date
from pathlib import Path
from typing import TYPE_CHECKING

import click

from scaloft_fi.cli.answer import answer
from scaloft_fi.cli.finds import told
from scaloft_fi.cli.options import campaign_option, format_option, study_option, today_option
from scaloft_fi.cli.own_study import check_own
from scaloft_fi.cli.verb import verb
from scaloft_fi.console import say
from scaloft_fi.errors import InputError
from scaloft_fi.exit_codes import ExitCode

if TYPE_CHECKING:
    from collections.abc import Sequence

    from scaloft_fi.analysis.disposition import Judged
    from scaloft_fi.analysis.scoring.score import Score
    from scaloft_fi.study import Study


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
    from scaloft_fi.views.dispositions import DISPOSITIONS, disposition_table, disposition_values
    from scaloft_fi.views.score.finds import next_find
    from scaloft_fi.views.snapshot import snapshot
    from scaloft_fi.views.tables.table import render

    study = Study.open(study_folder)
    if writing:
        check_own(study, study_folder, study.dispositions_path)
    with snapshot(study, campaign) as now:
        study = now.study
        judged = _judged(study, now.score, today)
        finds = told(study.finds)
        found = [mutant.subject.id for mutant in now.score.mutants if next_find(mutant, finds)]
    answer(
        DISPOSITIONS,
        lambda: disposition_values(judged, found),
        style,
        lambda how: render((disposition_table(judged, found, campaign),), how),
    )
    if writing:
        _append(study, judged)


def ratchet(study: Study, scored: Score, today: date | None) -> int:
    """Say on standard error what does not pass and what can go; returns the exit code.

    Raises:
        InputError: there is no baseline pool to decide by.
    """
    from scaloft_fi.analysis.disposition import Standing
    from scaloft_fi.views.dispositions import complaint

    judged = _judged(study, scored, today)
    for entry in judged:
        if entry.state is Standing.STALE:
            say(f"warning: {complaint(entry)}")
    failing = [entry for entry in judged if entry.state.fails]
    for entry in failing:
        say(f"ratchet: {complaint(entry)}")
    if not scored.tested.part:
        say("ratchet: no counted mutant was put to the test; there is nothing to hold")
    return ExitCode.BELOW if failing or not scored.tested.part else ExitCode.DONE


def _judged(study: Study, scored: Score, today: date | None) -> tuple[Judged, ...]:
    """The survivors and the dispositions; without a pool nobody knows what survives."""
    from scaloft_fi.analysis.disposition import judge
    from scaloft_fi.views.score.verdict import NO_POOL

    if not scored.pooled:
        raise InputError(f"no mutant is known to survive: {NO_POOL}")
    return judge(scored, study.roster, study.dispositions, today or date.today())  # noqa: DTZ011 - the user's own day


def _append(study: Study, judged: Sequence[Judged]) -> None:
    from scaloft_fi.analysis.disposition import Standing
    from scaloft_fi.dispositions import HEADER, draft
    from scaloft_fi.output import write_whole
    from scaloft_fi.reading import is_there, read_text

    opened = [entry.mutant for entry in judged if entry.state is Standing.OPEN]
    if not opened:
        say("nothing to write: no survivor without a disposition")
        return
    path = study.dispositions_path
    before = read_text(path) if is_there(path) else HEADER
    try:
        write_whole(path, (before.rstrip("\n") + "\n" + draft(opened)).encode())
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {error.strerror}") from error
    say(f"{path}: {_counted(len(opened))} to decide on; fill in owner, reason and expires")


def _counted(survivors: int) -> str:
    return f"{survivors} survivor{'s' * (survivors != 1)}"
