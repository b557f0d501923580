"""`scaloft-fi status`, `merge`, `compare`, `diff`: what a campaign holds, one of several, what one of two shows."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from html import escape
from pathlib import Path
from typing import Annotated, Literal

from scaloft_fi.analysis.comparison import Agreement, Change, ComparedCampaigns, ComparedMutant, Flown, compared
from scaloft_fi.analysis.detection import Verdict
from scaloft_fi.analysis.roster import Roster
from scaloft_fi.analysis.score import score_of
from scaloft_fi.campaign.runs.merge import Merged
from scaloft_fi.campaign.runs.merge import merge as merged_into
from scaloft_fi.campaign.store.archive import MANIFEST, campaign_folder, is_archive, study_of_all
from scaloft_fi.campaign.store.held import nothing_to_show
from scaloft_fi.errors import ExitCode, GateError, InputError, shown
from scaloft_fi.hazop.load import nearest_study
from scaloft_fi.hazop.matrix import Matrix, class_of
from scaloft_fi.judge.outcome import BASELINE, Outcome
from scaloft_fi.judge.space import Space
from scaloft_fi.judge.status import Facts, baseline_status, facts_of, rulings_of
from scaloft_fi.mutants.catalogue import realise
from scaloft_fi.output import line, say, write_named
from scaloft_fi.study import Study
from scaloft_fi.verbs import options
from scaloft_fi.verbs.export.dossier import WAITING, FlightStatus
from scaloft_fi.verbs.names import campaigns
from scaloft_fi.verbs.snapshot import Reason, Snapshot, snapshot
from scaloft_fi.views.output import Answer, Output
from scaloft_fi.views.table import Table, counted, said

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
        invalid: why flights that count say nothing, the commonest reason first.
        not_valid: why no score of the campaign is valid, each reason in a sentence; often none.
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
    invalid: tuple[Reason, ...] = ()
    not_valid: tuple[str, ...] = ()


STATUS = Output("status", "1.3", CampaignStatus, rows="statuses")


def campaign_status(now: Snapshot) -> CampaignStatus:
    """How many flights a campaign holds, by status."""
    held, ruled, rank = now.held, now.ruled, now.study.space.rank
    clean = sorted(ruled.baselines, key=lambda outcome: (rank(outcome.situation), outcome.seed))
    home = {(outcome.situation, outcome.seed) for outcome in clean}
    mutants = Counter(
        one.ruling.status.value if (key, one.seed) in home else WAITING
        for subject in sorted(ruled.mutants, key=lambda subject: now.study.roster.rank(subject.id))
        for key in sorted(ruled.mutants[subject], key=rank)
        for one in ruled.mutants[subject][key]
    )
    return CampaignStatus(
        campaign=str(held.folder),
        archive=now.archive.digest if now.archive else None,
        platform=now.platform,
        stack=now.study.stack.title,
        grid=now.study.grid.name,
        counted=len(clean) + mutants.total(),
        owed=held.owed,
        stale=held.stale,
        flown_again=held.flown_again,
        command=now.stale.command,
        subjects=len(ruled.mutants) + bool(clean),
        situations=len(ruled.situations),
        platforms=now.mixture or None,
        statuses=(
            *(CountedStatus("baseline", *each) for each in Counter(map(baseline_status, clean)).items()),
            *(CountedStatus("mutants", *each) for each in mutants.items()),
        ),
        reasons=tuple(Reason(*each) for each in held.why.items()),
        invalid=tuple(Reason(*each) for each in Counter(now.now.broken.values()).most_common()),
        not_valid=now.stale.invalid,
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
    why = tuple((one.why, one.flights) for one in told.invalid)
    broken = Table(
        "Invalid flights", ("why", "number"), why, () if told.archive else ("The same run flies them again.",)
    )
    return (table, *([stale] if told.stale else ()), *([broken] if why else ()))


def _of_archive(told: CampaignStatus) -> tuple[str, ...]:
    """What is cited of an archive, and what flew it."""
    if told.archive is None:
        return ()
    flown = ", ".join(f"{name} {version}" for name, version in sorted(told.platform.items()))
    return (
        f"An archive, whose flights count as they stand; SHA-256 of its {MANIFEST}: {told.archive}.",
        f"Flown on {flown}.",
    )


def status(study: Study, campaign: options.Campaign) -> Answer:
    """How many flights a campaign holds, by status, and why those are stale that do not count any more.

    Examples:
        Count the flights of the campaign, and say why some are stale: `scaloft-fi status`
        Look at another campaign: `scaloft-fi status --campaign night`
        Let a script read it: `scaloft-fi status --format json`

    Raises:
        InputError: there is no such campaign.
    """
    with snapshot(study, campaign) as now:
        told = campaign_status(now)
        then, of_tests = now.next_step if told.counted else "", bool(now.study.tests_of)
    tables = [said(one, of_tests=of_tests) for one in status_tables(told, then)]
    return Answer(STATUS, lambda: told, lambda: tables, warnings=told.not_valid)


status_command = options.verb("status")(status)


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


MergedCampaigns = Annotated[
    options.Several, options.Option("Names of the campaigns.", "", metavar="CAMPAIGN...", complete=campaigns)
]
MergedPlatform = Annotated[
    bool,
    options.Option(
        "Refuse a campaign of another platform unless flights in both show equal digests.",
        otherwise="refuse it where a flight in both has another status, ending or violation",
    ),
]


@options.verb("merge")
def merge_command(
    *,
    sources: MergedCampaigns,
    study_folder: options.StudyFolder,
    campaign: options.Campaign,
    same_platform: MergedPlatform,
    style: options.LineFormat,
) -> None:
    """Join CAMPAIGNs, such as those flown with `run --shard K/N`, into the one named by --campaign.

    Campaigns of two platforms are compared, flight by flight.  Where both flew the same situation and seed, the flights
    of the first stay: a mutant is judged beside a baseline of its own platform.

    The run's own command, without --shard, then holds the gates over the whole and prints the tables; it flies nothing.

    Examples:
        Join two parts, flown with --shard 1/2 and --shard 2/2: `scaloft-fi merge part1 part2`
        Join them into a campaign of another name: `scaloft-fi merge part1 part2 --campaign whole`
        Join a folder from another machine, bits and all: `scaloft-fi merge /data/night/campaign --same-platform`
    """
    study = study_of_all(study_folder, [*sources, campaign])
    options.answer(merge(study, campaign, sources, same_platform=same_platform), style)


@dataclass(frozen=True)
class Difference:
    """One flight.

    Attributes:
        mutant: `baseline`, `PLACEBO` or the id of a mutant.
        situation: key of the situation.
        seed: seed of the flight.
        first: what the first campaign says of it; null: the first campaign has no such flight.
        second: what the second campaign says of it; null: the second campaign has no such flight.
    """

    mutant: str
    situation: str
    seed: int
    first: Facts | None
    second: Facts | None


@dataclass(frozen=True)
class FlightDifferences:
    """The flights of which two campaigns do not say the same.

    Attributes:
        first: the first campaign, as it was named.
        second: the second campaign, as it was named.
        same: flights that are the same bit for bit.
        other_bits: flights with other bits and the same status, ending and violations.
        differences: the flights that differ or that one campaign alone has, ordered by mutant, situation and seed.
        first_stale: flights of the first campaign that no score counts any more; they are held against as they are.
        second_stale: the same of the second campaign.
    """

    first: str
    second: str
    same: int
    other_bits: int
    differences: tuple[Difference, ...]
    first_stale: int = 0
    second_stale: int = 0


DIFF = Output("diff", "1.0", FlightDifferences, rows="differences")


def differences_of(
    names: tuple[str, str], first: Iterable[Outcome], second: Iterable[Outcome], roster: Roster, space: Space
) -> FlightDifferences:
    """Hold the flights of two campaigns, each flight once, against each other by mutant, situation and seed."""
    here, there = _facts_by_flight(first), _facts_by_flight(second)
    equal: Counter[bool] = Counter()
    differences = []
    for name in sorted(here.keys() | there.keys(), key=lambda n: (roster.rank(n[0]), space.rank(n[1]), n[2])):
        (one, bits), (other, other_bits) = here.get(name, _LACKING), there.get(name, _LACKING)
        if one != other:
            differences.append(Difference(*name, one, other))
        else:
            equal[bits == other_bits] += 1
    return FlightDifferences(*names, equal[True], equal[False], tuple(differences))


def differences_table(told: FlightDifferences) -> Table:
    """The differences."""
    rows = tuple(
        (one.mutant, one.situation, one.seed, str(one.first or ""), str(one.second or "")) for one in told.differences
    )
    alone = sum(one.first is None or one.second is None for one in told.differences)
    note = (
        f"{told.same} flights are the same bit for bit, {told.other_bits} more have the same status, "
        f"ending and violations; {len(rows) - alone} differ, and {alone} are in one campaign alone."
    )
    by_name = (told.first, told.first_stale), (told.second, told.second_stale)
    stale = [f"{flights} flights of {name}" for name, flights in by_name if flights]
    old = (f"{' and '.join(stale)} are stale: no score counts them, and they stand here as they were flown.",)
    title, headers = f"{told.first} and {told.second}", ("mutant", "situation", "seed", told.first, told.second)
    return Table(title, headers, rows, (note, *(old if stale else ())))


_LACKING: tuple[Facts | None, str] = None, ""


def _facts_by_flight(outcomes: Iterable[Outcome]) -> dict[tuple[str, str, int], tuple[Facts | None, str]]:
    listed = list(outcomes)
    facts = facts_of(listed)
    return {(o.mutant, o.situation, o.seed): (facts[o.name], o.digest) for o in listed}


@dataclass(frozen=True)
class CampaignComparison:
    """What only one of two campaigns of a matrix shows, and with `--flights` which of their flights differ.

    Attributes:
        scores: the two scores held against each other.
        redefined: names of the requirements that the two studies define otherwise.
        flights: the flights of which the campaigns do not say the same; null: nobody asked.
        invalid: why no score of a campaign is valid, each reason in a sentence; often none.
    """

    scores: ComparedCampaigns
    redefined: tuple[str, ...] = ()
    flights: FlightDifferences | None = None
    invalid: tuple[str, ...] = ()
    KEYS = ("scores.*", "redefined", "flights", "invalid")


COMPARE = Output("compare", "1.2", CampaignComparison, "mutants", "what only one of two campaigns shows")
_CHANGES = tuple(change for change in Change if change is not Change.SAME)
MEANING = (
    "lost: firm in the first, put to the test and not detected in the second, and the flights differ by the exact test "
    "after Holm over all faults; gained: the other way round; unsure: one detects it, and the flights do not say more."
)


def agreement_text(told: ComparedCampaigns) -> str:
    """In how many faults the campaigns agree, beside the halves of the seeds of each."""
    first, second = _short(told)

    def words(agreement: Agreement) -> str:
        kappa = "" if agreement.kappa is None else f", kappa {agreement.kappa:.2f}"
        return f"{agreement.same}{kappa}"

    halves = [
        f"the halves of the seeds of {name} agree in {words(own)}" if own else f"{name} has one seed and no halves"
        for name, own in ((first, told.first_halves), (second, told.second_halves))
    ]
    return f"{first} and {second} agree in {words(told.agreement)}; {'; '.join(halves)}."


def score_tables(told: ComparedCampaigns) -> tuple[Table, ...]:
    """The faults that one campaign alone shows, and those that one alone flew."""
    names = _short(told)
    headers = ("severity", "mutant", "change", *names, "p", "violates", *(f"of {name}" for name in names))
    rows = tuple(map(_row, (mutant for mutant in told.mutants if mutant.change is not Change.SAME)))
    parts = [f"{len(told.of(change))} {change}" for change in _CHANGES]
    notes = (
        f"{', '.join(parts)} of {counted(len(told.mutants), 'fault')} that both flew.",
        *too_few(told),
        *([f"Flown by both, in no score, and not compared: {', '.join(told.uncounted)}."] if told.uncounted else []),
        agreement_text(told),
        MEANING,
    )
    alone = [*((id_, told.first) for id_ in told.only_first), *((id_, told.second) for id_ in told.only_second)]
    main = Table(f"What only one of {told.first} and {told.second} shows", headers, rows, notes)
    return (main, *([Table("Flown in one campaign alone", ("mutant", "campaign"), tuple(alone))] if alone else []))


def too_few(told: ComparedCampaigns) -> tuple[str, ...]:
    """Of how many firm faults the flights cannot say that they are lost or gained; empty where they can of all."""
    parts = [
        f"{enough.whole - enough.part} of the {enough.whole} firm in {name} could not be called {change.value}"
        for name, change, enough in zip(
            _short(told), (Change.LOST, Change.GAINED), (told.could_be_lost, told.could_be_gained), strict=True
        )
        if enough.part < enough.whole
    ]
    return (f"Too few flights: {', '.join(parts)}, however much they differed.",) if parts else ()


def _short(told: ComparedCampaigns) -> tuple[str, str]:
    """The names of the campaigns without the folders that they are in, where these differ."""
    first, second = Path(told.first).name, Path(told.second).name
    return (first, second) if first != second else (told.first, told.second)


def _row(one: ComparedMutant) -> tuple[str | float | None, ...]:
    p = f"{one.lost_p if one.first is Verdict.DETECTED else one.gained_p:.4f}"
    verdicts = _verdict(one.first, firm=one.first_firm), _verdict(one.second, firm=one.second_firm)
    counts = one.requirement or "", one.first_violated.short, one.second_violated.short
    return class_of(one.severity), one.id, one.change.value, *verdicts, p, *counts


def _verdict(verdict: Verdict, *, firm: bool) -> str:
    return f"{verdict.words}, firm" if firm else verdict.words


def compared_by(
    study: Study, campaign: str, other: str, *, flights: bool
) -> tuple[CampaignComparison, Matrix, list[str]]:
    """The comparison, the matrix of the first campaign, and what a reader must know of the platforms.

    Raises:
        InputError: there is no such campaign, it holds no flight that counts, the two are of different grids, or they
            share no situation.
    """
    with snapshot(_own(study, campaign), campaign) as here, snapshot(_own(study, other), other) as there:
        _same_grid(campaign, here, other, there)
        warnings = list[str]()
        first, second = (_flown(name, now, warnings) for name, now in ((campaign, here), (other, there)))
        matrix = here.study.matrix
        if changed := _redefined(matrix, there.study.matrix, first, second):
            warnings.append(f"of other faults in the second study, and not compared: {', '.join(sorted(changed))}")
            first, second = _without(first, changed), _without(second, changed)
        if not flights and not first.rulings.situations & second.rulings.situations:
            raise InputError(f"campaigns {shown(campaign)} and {shown(other)} share no situation that both flew")
        told = compared(first, second, here.study.roster, here.study.space)
        redefined = _other_requirements(here.study, there.study)
        warnings += [
            f"the two studies define {name} otherwise: {', '.join(words)}" for name, words in redefined.items()
        ]
        differ = _flights((campaign, other), here, there, changed) if flights else None
        invalid = (f"{name}: {text}" for name, now in ((campaign, here), (other, there)) for text in now.stale.invalid)
        return CampaignComparison(told, tuple(redefined), differ, tuple(invalid)), matrix, warnings


def _flown(name: str, now: Snapshot, warnings: list[str]) -> Flown:
    """The flights that count; where none does, as after a change of the stack, all as they were flown."""
    if now.ruled:
        warnings += [f"{name}: {text}" for text in (now.platform_warning, *now.stale.sentences) if text]
        return Flown(name, now.rulings, now.score)
    rulings = rulings_of(now.latest or nothing_to_show(now.study, now.store, now.folder))
    warnings.append(f"{name}: no flight is of the study as it is now, so all are compared as they were flown")
    return Flown(name, rulings, score_of(rulings, now.study.roster, now.study.space, now.spending))


def _own(study: Study, campaign: str) -> Study:
    """The study that a campaign was flown with: that above its folder, where the campaign is named by a path."""
    folder = campaign_folder(study, campaign)
    if folder.parent == study.results_folder / "campaigns" or is_archive(folder):
        return study
    found = nearest_study(folder.absolute().parent)
    return study if found is None or found.resolve() == study.folder.resolve() else Study.open(found)


def _same_grid(campaign: str, here: Snapshot, other: str, there: Snapshot) -> None:
    one, two = here.study.space, there.study.space
    if (one.grid, one.axes, one.values) != (two.grid, two.axes, two.values):
        grids = f"campaign {shown(campaign)} was flown over grid {one.grid!r}, {shown(other)} over grid {two.grid!r}"
        raise InputError(f"{grids} or other axes; only campaigns of one grid have the same situations")


def _redefined(matrix: Matrix, other: Matrix, first: Flown, second: Flown) -> set[str]:
    """Ids of mutants that both campaigns flew and whose faults are not the same in the two studies."""
    ids = {one.id for one in first.score.mutants} & {one.id for one in second.score.mutants}
    return {id_ for id_ in ids if _fault(matrix, id_) != _fault(other, id_)}


def _fault(matrix: Matrix, id_: str) -> Mapping[str, object]:
    """What an id stands for; nothing where the matrix has no such mutant any more."""
    try:
        return realise(matrix, id_).to_json()
    except InputError:
        return {}


def _other_requirements(study: Study, other: Study) -> dict[str, list[str]]:
    """What two studies define otherwise of requirements with one name, by the name; titles and sources do not count."""
    here, there = ({one.name: one for one in each.requirements} for each in (study, other))
    parts = {"kind": "kind", "text": "formula", "trigger": "trigger", "definitions": "definitions", "unit": "unit"}
    both = {name: (here[name], there[name]) for name in here if name in there}
    apart = {
        name: [word for part, word in parts.items() if getattr(one, part) != getattr(two, part)]
        for name, (one, two) in both.items()
    }
    return {name: words for name, words in apart.items() if words}


def _without(flown: Flown, ids: set[str]) -> Flown:
    counted_, mutants = (tuple(m for m in of if m.id not in ids) for of in (flown.score.counted, flown.score.mutants))
    return replace(flown, score=replace(flown.score, counted=counted_, mutants=mutants))


def _flights(named: tuple[str, str], here: Snapshot, there: Snapshot, but: Collection[str] = ()) -> FlightDifferences:
    first, second = ([one for one in now.latest if one.mutant not in but] for now in (here, there))
    told = differences_of(named, first, second, here.study.roster, here.study.space)
    return replace(told, first_stale=here.stale.flights, second_stale=there.stale.flights)


Compared = Annotated[
    str,
    options.Option(
        "Name of a campaign, or the path of its folder or archive.", "", metavar="CAMPAIGN", complete=campaigns
    ),
]
Flights = Annotated[bool, options.Option("List the flights of which the campaigns do not say the same instead.")]


def compare(study: Study, campaign: Compared, other: Compared, *, flights: Flights = False) -> Answer:
    """What only one of two campaigns of a matrix shows: faults that are lost or gained from the first to the second.

    Raises:
        InputError: there is no such campaign, it holds no flight that counts, or the two are of different grids.
    """
    told, _, warnings = compared_by(study, campaign, other, flights=flights)
    return _answer(told, warnings)


def _answer(told: CampaignComparison, warnings: Sequence[str]) -> Answer:
    tables = score_tables(told.scores) if told.flights is None else (differences_table(told.flights),)
    rows = "flights_differences" if told.flights is not None else ""
    return Answer(COMPARE, lambda: told, lambda: tables, rows=rows, warnings=warnings)


@options.verb("compare")
def compare_command(
    *,
    campaign: Compared,
    other: Compared,
    study_folder: options.StudyFolder,
    flights: Flights,
    output: Annotated[
        Path | None, options.Option("Also write both matrices beside each other, one HTML page.", metavar="FILE")
    ],
    failing: Annotated[
        bool, options.Option("Exit with 3 when a fault is lost; an unsure one never fails.", "--fail-on-lost")
    ],
    style: options.TableFormat,
    tables_folder: options.TablesFolder,
) -> int:
    """Say what only the first or only the second campaign of a matrix shows: other stacks, versions or settings.

    --fail-on-lost is refused where the flights are too few to call any of the firm faults lost.

    Examples:
        See what a new version no longer shows: `scaloft-fi compare default night`
        Hold a stack against another, each in a study of its own: `scaloft-fi compare default ../b/results/campaigns/b`
        Fail a pipeline where a fault is lost: `scaloft-fi compare default night --fail-on-lost --output both.html`
        List the flights that differ: `scaloft-fi compare default night --flights`
    """
    options.check_writable(output, *options.PAGE, what="HTML")
    told, matrix, warnings = compared_by(Study.open(study_folder), campaign, other, flights=flights)
    if failing and told.invalid:
        raise GateError(f"--fail-on-lost: {told.invalid[0]}")
    if failing and told.scores.could_be_lost.whole and not told.scores.could_be_lost.part:
        enough = f"the flights are too few to call any of the {told.scores.could_be_lost.whole} firm faults lost"
        raise InputError(f"--fail-on-lost could never fail here: {enough}; fly more seeds or situations in both")
    if output is not None:
        write_named(output, matrices_page(told.scores, matrix).encode())
    options.answer(_answer(told, warnings), style, tables_folder)
    if not (failing and told.scores.lost):
        return ExitCode.DONE
    say(f"lost: {', '.join(told.scores.lost)}")
    return ExitCode.BELOW


def diff(study: Study, campaign: Compared, other: Compared) -> Answer:
    """The flights of which two campaigns do not say the same; from the next release on `compare --flights` alone.

    What was flown with other data or code counts too, unless the campaign has the flight as the study describes it now.

    Examples:
        Compare two campaigns: `scaloft-fi diff default night`
        Compare with a folder from another machine: `scaloft-fi diff default /data/night/campaign`
        Keep the comparison as a table in a document: `scaloft-fi diff default night --format markdown`

    Raises:
        InputError: there is no such campaign, or the two were flown over different grids.
    """
    with snapshot(study, campaign) as here, snapshot(study, other) as there:
        _same_grid(campaign, here, other, there)
        told = _flights((campaign, other), here, there)
    return Answer(DIFF, lambda: told, lambda: (differences_table(told),), warnings=(RENAMED,))


RENAMED = "`diff` is `compare --flights` now; the old name goes with the next release"

diff_command = options.verb("diff")(diff)


SIGNS = {
    Verdict.DETECTED: ("&#9679;", "detected"),
    Verdict.UNDECIDED: ("?", "undecided"),
    Verdict.NOT_DETECTED: ("&#8211;", "survived"),
    Verdict.NOT_TESTED: ("&#183;", "untested"),
}
"""Sign and class of a verdict on the page; a verdict that is not firm has an open sign."""
STYLE = """
body { font: 15px/1.45 system-ui, sans-serif; margin: 1.5rem auto; max-width: 84rem; padding: 0 1rem;
  color: #1b1f24; background: #fff }
main { display: flex; flex-wrap: wrap; gap: 1.5rem; width: fit-content; max-width: 100% } section { overflow-x: auto }
table { border-collapse: collapse } caption { text-align: left; font-weight: 600; padding: .3rem 0 }
th { font-weight: 500; font-size: 12px; padding: .15rem .4rem; text-align: left }
thead th { writing-mode: vertical-rl; transform: rotate(180deg) }
td { border: 1px solid #c9ced4; text-align: center; min-width: 2.1rem; height: 1.7rem }
.detected { background: #cfe8d5 } .survived { background: #f6c28b } .untested { background: #eceff2 }
.undecided { background: repeating-linear-gradient(45deg, #fff, #fff 4px, #e3e6ea 4px, #e3e6ea 6px) }
.lost, .gained, .unsure { outline: 3px solid #b3261e; outline-offset: -2px; font-weight: 700 }
.gained { outline-color: #1d6b3a } .unsure { outline: 2px dashed #6b7280 }
@media (prefers-color-scheme: dark) { body { color: #e6e9ed; background: #15181c } td { border-color: #444b54 }
  .detected { background: #1f4d2e } .survived { background: #7a4a16 } .untested { background: #262b31 }
  .undecided { background: repeating-linear-gradient(45deg, #15181c, #15181c 4px, #2b3138 4px, #2b3138 6px) } }
"""


def matrices_page(told: ComparedCampaigns, matrix: Matrix) -> str:
    """One HTML file with the matrix of each campaign; sign, colour and frame say the same, nothing is fetched."""
    by_cell = {mutant.id.partition("@")[0]: mutant for mutant in told.mutants}
    sections = []
    for name, second in zip(_short(told), (False, True), strict=True):
        head = "".join(f"<th scope=col>{escape(word.id)}</th>" for word in matrix.guidewords)
        rows = "".join(
            f"<tr><th scope=row>{escape(parameter.id)}</th>"
            + "".join(_cell(by_cell.get(f"{word.id}-{parameter.id}"), second=second) for word in matrix.guidewords)
            + "</tr>"
            for parameter in matrix.parameters
        )
        sections.append(
            f"<section><table><caption>{escape(name)}</caption><thead><tr><th></th>{head}</tr></thead>{rows}</table></section>"
        )
    lines = [f"<p>{escape(note)}</p>" for note in score_tables(told)[0].notes]
    listed = "".join(
        f"<li><b>{change}</b>: {escape(', '.join(ids))}</li>" for change in _CHANGES if (ids := told.of(change))
    )
    signs = "; ".join(f"{sign} {verdict.words}" for verdict, (sign, _) in SIGNS.items())
    legend = (
        f"<p>{signs}; &#9675; detected, not firm.  A frame marks what only one campaign shows, dashed where unsure.</p>"
    )
    title = escape(" and ".join(_short(told)))
    return (
        f"<!doctype html><html lang=en><meta charset=utf-8><title>{title}</title>"
        '<meta name=viewport content="width=device-width">'
        f"<style>{STYLE}</style><h1>What only one of {title} shows</h1>{lines[0]}<ul>{listed}</ul>"
        f"<main>{''.join(sections)}</main>{legend}{''.join(lines[1:])}</html>\n"
    )


def _cell(mutant: ComparedMutant | None, *, second: bool) -> str:
    if mutant is None:
        return "<td></td>"
    verdict, firm = (mutant.second, mutant.second_firm) if second else (mutant.first, mutant.first_firm)
    sign, kind = SIGNS[verdict]
    sign = "&#9675;" if verdict is Verdict.DETECTED and not firm else sign
    frame = f" {mutant.change}" if mutant.change is not Change.SAME else ""
    words = f"{mutant.id}: {_verdict(verdict, firm=firm)}" + f"; {mutant.change}" * bool(frame)
    return f'<td class="{kind}{frame}" title="{escape(words)}" aria-label="{escape(words)}">{sign}</td>'
