"""`scaloft-fi status`: what a campaign holds."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

from scaloft_fi.cli.options import campaign_option, format_option, study_option
from scaloft_fi.cli.verb import verb
from scaloft_fi.console import tell

AGAIN = "The same `run` flies them again; no flight log is kept from which they could be judged anew."
WAITING = "waiting for their baseline"
"""Flights that cannot be judged yet: a run was interrupted before the baseline of their situation and seed was home."""


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
def status_command(study_folder: Path | None, campaign: str, style: str) -> None:
    """Print how many flights a campaign holds, by status, and why those are stale that do not count any more."""
    from scaloft_fi.judge.flights import flights_of
    from scaloft_fi.judge.outcome import BASELINE
    from scaloft_fi.judge.status import baseline_status
    from scaloft_fi.study import Study
    from scaloft_fi.views.flights.export import ordered
    from scaloft_fi.views.snapshot import snapshot
    from scaloft_fi.views.tables.table import Format, Table, render

    study = Study.open(study_folder)
    with snapshot(study, campaign) as now:
        study, content, mixture = now.study, now.held, now.mixture
    flown = ordered(content.current, study.roster, study.space)
    clean = [outcome for outcome in flown if outcome.mutant == BASELINE]
    baselines = Counter(f"{BASELINE} {baseline_status(outcome)}" for outcome in clean)
    home = {(outcome.situation, outcome.seed) for outcome in clean}
    mutants = Counter(
        flight.status.value if (flight.outcome.situation, flight.outcome.seed) in home else WAITING
        for flight in flights_of(flown)
    )
    table = Table(
        f"Campaign {content.folder}",
        ("flights", "number"),
        (
            *baselines.items(),
            *mutants.items(),
            ("all", len(flown)),
            ("planned, not flown", content.owed),
            ("stale, not counted", content.stale),
        ),
        (
            f"{len({o.mutant for o in flown})} subjects in {len({o.situation for o in flown})} situations.",
            *([f"{mixture[:1].upper()}{mixture[1:]}."] if mixture else []),
        ),
    )
    stale = Table("Stale flights", ("why", "number"), tuple(content.why.items()), (AGAIN,))
    tell(render((table, stale) if content.stale else (table,), Format(style)))
