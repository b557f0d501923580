"""`scaloft-fi status`: what a campaign holds."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from scaloft_fi.campaign.store.archive import MANIFEST
from scaloft_fi.judge.outcome import BASELINE
from scaloft_fi.judge.status import baseline_status, flights_of
from scaloft_fi.study import Study
from scaloft_fi.verbs.export.rows import WAITING, FlightStatus, ordered
from scaloft_fi.verbs.options import Campaign
from scaloft_fi.verbs.snapshot import Snapshot, snapshot
from scaloft_fi.verbs.verb import verb
from scaloft_fi.views.output import Answer, Output
from scaloft_fi.views.table import Table

_WORDS = {WAITING: "waiting for their baseline"}


@dataclass(frozen=True)
class CountedStatus:
    """Flights of one status.

    Attributes:
        subject: whose flights: of the unmutated drone, or of mutants and PLACEBO.
        status: of each flight: what it shows, or `waiting` for its baseline.
        flights: how many.
    """

    subject: Literal["baseline", "mutants"]
    status: FlightStatus
    flights: int


@dataclass(frozen=True)
class CountedReason:
    """One reason.

    Attributes:
        why: the reason, in a sentence.
        flights: how many.
    """

    why: str
    flights: int


@dataclass(frozen=True)
class CampaignStatus:
    """How many flights a campaign holds, by status.

    Attributes:
        campaign: folder of the campaign.
        archive: SHA-256 of its `campaign.json`, which lists every other file's; null: it is no archive.
        platform: on which most flights were flown, part by part.
        grid: name of the grid that was flown.
        counted: flights that count.
        owed: flights that are planned and not flown.
        stale: stored outcomes that do not count any more.
        flown_again: of these, those whose flight was flown again since.
        command: what flies the others again; null: there are none that the study still has.
        subjects: subjects flown: the baseline, PLACEBO, mutants.
        situations: situations flown.
        platforms: how the flights divide over platforms; null: all of one platform.
        statuses: the flights that count, by status.
        reasons: why flights are stale.
    """

    campaign: str
    archive: str | None
    platform: Mapping[str, str]
    grid: str
    counted: int
    owed: int
    stale: int
    flown_again: int
    command: str | None
    subjects: int
    situations: int
    platforms: str | None
    statuses: tuple[CountedStatus, ...]
    reasons: tuple[CountedReason, ...]


STATUS = Output("status", "1.1", CampaignStatus, rows="statuses")


def campaign_status(now: Snapshot) -> CampaignStatus:
    """How many flights a campaign holds, by status."""
    held = now.held
    flown = ordered(held.current, now.study.roster, now.study.space)
    clean = [outcome for outcome in flown if outcome.mutant == BASELINE]
    home = {(outcome.situation, outcome.seed) for outcome in clean}
    mutants = Counter(
        flight.status.value if (flight.outcome.situation, flight.outcome.seed) in home else WAITING
        for flight in flights_of(flown)
    )
    return CampaignStatus(
        campaign=str(held.folder),
        archive=now.archive.digest if now.archive else None,
        platform=now.platform,
        grid=now.study.grid.name,
        counted=len(flown),
        owed=held.owed,
        stale=held.stale,
        flown_again=held.flown_again,
        command=now.stale.command,
        subjects=len({outcome.mutant for outcome in flown}),
        situations=len({outcome.situation for outcome in flown}),
        platforms=now.mixture or None,
        statuses=(
            *(CountedStatus("baseline", *each) for each in Counter(map(baseline_status, clean)).items()),
            *(CountedStatus("mutants", *each) for each in mutants.items()),
        ),
        reasons=tuple(CountedReason(*each) for each in held.why.items()),
    )


def status_tables(told: CampaignStatus) -> tuple[Table, ...]:
    """The same for people."""
    flights = [
        (f"{BASELINE} {one.status}" if one.subject == "baseline" else _WORDS.get(one.status, one.status), one.flights)
        for one in told.statuses
    ]
    mixture = told.platforms or ""
    table = Table(
        f"Campaign {told.campaign}",
        ("flights", "number"),
        (
            *flights,
            ("all", told.counted),
            ("planned, not flown", told.owed),
            ("stale, not counted", told.stale),
            *([("flown again since", told.flown_again)] if told.flown_again else []),
        ),
        (
            f"{told.subjects} subjects in {told.situations} situations.",
            *([f"{mixture[:1].upper()}{mixture[1:]}."] if mixture else []),
            *_of_archive(told),
        ),
    )
    reasons = tuple((one.why, one.flights) for one in told.reasons)
    again = f"`{told.command}` flies them again; no flight log is kept from which they could be judged anew."
    stale = Table("Stale flights", ("why", "number"), reasons, (again,) if told.command else ())
    return (table, stale) if told.stale else (table,)


def _of_archive(told: CampaignStatus) -> tuple[str, ...]:
    """What is cited of an archive, and what flew it."""
    if told.archive is None:
        return ()
    flown = ", ".join(f"{name} {version}" for name, version in sorted(told.platform.items()))
    return (
        f"An archive, whose flights count as they stand; SHA-256 of its {MANIFEST}: {told.archive}.",
        f"Flown on {flown}.",
    )


def status(study: Study, campaign: Campaign) -> Answer:
    """How many flights a campaign holds, by status, and why those are stale that do not count any more.

    Raises:
        InputError: there is no such campaign.
    """
    with snapshot(study, campaign) as now:
        told = campaign_status(now)
    return Answer(STATUS, lambda: told, lambda: status_tables(told))


status_command = verb(
    "status",
    examples=(
        ("Count the flights of the campaign, and say why some are stale", "scaloft-fi status"),
        ("Look at another campaign", "scaloft-fi status --campaign night"),
        ("Let a script read it", "scaloft-fi status --format json"),
    ),
)(status)
