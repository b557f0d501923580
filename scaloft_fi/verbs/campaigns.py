"""`scaloft-fi status` and `merge`: what a campaign holds, and one made of several."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Literal

from scaloft_fi.campaign.runs.merge import Merged
from scaloft_fi.campaign.runs.merge import merge as merged_into
from scaloft_fi.campaign.store.archive import MANIFEST, campaign_folder, study_of_all
from scaloft_fi.console import line
from scaloft_fi.judge.outcome import BASELINE
from scaloft_fi.judge.status import baseline_status, flights_of
from scaloft_fi.study import Study
from scaloft_fi.verbs.export.dossier import WAITING, FlightStatus, ordered
from scaloft_fi.verbs.names import campaigns
from scaloft_fi.verbs.options import Campaign, LineFormat, Option, Several, StudyFolder, answer, verb
from scaloft_fi.verbs.snapshot import Reason, Snapshot, snapshot
from scaloft_fi.views.output import Answer, Output
from scaloft_fi.views.table import Table, said

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
class CampaignStatus:
    """How many flights a campaign holds, by status.

    Attributes:
        campaign: folder of the campaign.
        archive: SHA-256 of its `campaign.json`, which lists every other file's; null: it is no archive.
        platform: on which most flights were flown, part by part.
        stack: name of the stack that the study names, and the version of its programs in words.
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
    stack: str
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
    reasons: tuple[Reason, ...]


STATUS = Output("status", "1.2", CampaignStatus, rows="statuses")


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
        stack=now.study.stack.title,
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
        reasons=tuple(Reason(*each) for each in held.why.items()),
    )


def status_tables(told: CampaignStatus, then: str) -> tuple[Table, ...]:
    """The same for people; `then`: what to do next, nothing where no flight counts."""
    flights = [
        (f"{BASELINE} {one.status}" if one.subject == "baseline" else _WORDS.get(one.status, one.status), one.flights)
        for one in told.statuses
    ]
    mixture = told.platforms or ""
    flights += [("all", told.counted), ("planned, not flown", told.owed), ("stale, not counted", told.stale)]
    flights += [("flown again since", told.flown_again)] if told.flown_again else []
    notes = (
        f"{told.subjects} subjects in {told.situations} situations.",
        *([f"{mixture[:1].upper()}{mixture[1:]}."] if mixture else []),
        *_of_archive(told),
        *([f"What next: {then}"] if then else []),
    )
    table = Table(f"Campaign {told.campaign}", ("flights", "number"), tuple(flights), notes)
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
        then, of_tests = now.next_step if told.counted else "", bool(now.study.tests_of)
    return Answer(STATUS, lambda: told, lambda: [said(one, of_tests=of_tests) for one in status_tables(told, then)])


status_command = verb(
    "status",
    examples=(
        ("Count the flights of the campaign, and say why some are stale", "scaloft-fi status"),
        ("Look at another campaign", "scaloft-fi status --campaign night"),
        ("Let a script read it", "scaloft-fi status --format json"),
    ),
)(status)


MERGE = Output("merge", "1.0", Merged, rows="summary")


def merge(study: Study, campaign: str, sources: Sequence[str], *, same_platform: bool = False) -> Answer:
    """Join campaigns into `campaign`, which need not exist.

    Args:
        study: the study, with the grid of all of them.
        campaign: name of the campaign that gets the flights.
        sources: names of the others.
        same_platform: whether flights of another platform must have equal digests.

    Raises:
        GateError: a flight has other digests on one platform, or other facts on two; nothing is written.
        InputError: there is no such campaign, or it cannot be written.
    """
    folder = campaign_folder(study, campaign)
    merged = merged_into(study, folder, [campaign_folder(study, name) for name in sources], same_platform=same_platform)
    told = line(f"{merged.added} flights added to {folder}, {merged.known} known already")
    tables = (Table(told, (), ()),)
    return Answer(MERGE, lambda: merged, lambda: tables, told=lambda _: f"{told}\n", warnings=merged.warnings)


MergedCampaigns = Annotated[Several, Option("Names of the campaigns.", "", metavar="CAMPAIGN...", complete=campaigns)]
MergedPlatform = Annotated[
    bool,
    Option(
        "Refuse a campaign of another platform unless flights in both show equal digests.",
        otherwise="refuse it where a flight in both has another status, ending or violation",
    ),
]


@verb(
    "merge",
    examples=(
        ("Join two parts, flown with --shard 1/2 and --shard 2/2", "scaloft-fi merge part1 part2"),
        ("Join them into a campaign of another name", "scaloft-fi merge part1 part2 --campaign whole"),
        ("Join a folder from another machine, bits and all", "scaloft-fi merge /data/night/campaign --same-platform"),
    ),
)
def merge_command(
    *,
    sources: MergedCampaigns,
    study_folder: StudyFolder,
    campaign: Campaign,
    same_platform: MergedPlatform,
    style: LineFormat,
) -> None:
    """Join CAMPAIGNs, such as those flown with `run --shard K/N`, into the one named by --campaign.

    Campaigns of two platforms are compared, flight by flight; where both flew the same situation and seed, the flights
    of the first stay, because a mutant is judged beside a baseline of its own platform.

    The run's own command, without --shard, then holds the gates over the whole and prints the tables; it flies nothing.
    """
    study = study_of_all(study_folder, [*sources, campaign])
    answer(merge(study, campaign, sources, same_platform=same_platform), style)
