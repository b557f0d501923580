"""Gates: checks that must pass before a score is valid, a known flight and a sample on another platform among them."""

from __future__ import annotations

import json
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from hashlib import sha256
from pathlib import Path

from scaloft_fi.analysis.detection import Pool, Sample, Spending, State, detect
from scaloft_fi.analysis.roster import Roster
from scaloft_fi.campaign.flights.fly import CAN_FORK, Flyer
from scaloft_fi.campaign.flights.physics import Physics
from scaloft_fi.campaign.plan import alone, canary
from scaloft_fi.campaign.store import platforms
from scaloft_fi.campaign.store.held import (
    MOST_INVALID,
    NOT_REPEATED,
    Now,
    allowed_in,
    counting_flights,
    differed_in,
    flight_named,
    grown_in,
    held_in,
)
from scaloft_fi.campaign.store.store import FlownFlight, Store
from scaloft_fi.campaign.workers import Executor, Workers
from scaloft_fi.errors import GateError
from scaloft_fi.hazop.matrix import cell_of
from scaloft_fi.judge import status
from scaloft_fi.judge.outcome import BASELINE, PLACEBO_ID, TRACK_COLUMNS, Outcome, unpack_track
from scaloft_fi.judge.requirement import Compliance, Kind
from scaloft_fi.registry import grouped
from scaloft_fi.sim.log import Ending
from scaloft_fi.study import PACKAGE, Study


@dataclass(frozen=True)
class RunOptions:
    """Options from the command line.

    Attributes:
        jobs: number of worker processes on this machine.
        executor: executor that replaces these processes.
        share: whether mutants share the beginning of their baseline.
        part: whether this run is one part of a campaign; `merge` checks the gates that need all parts.
        budget_s: wall time after which no flight begins [s]; None = unlimited.
        max_invalid: greatest share 0..1 of invalid flights.
        warnings: whether each violation is shown when its outcome arrives, instead of only counted.
        same_platform: whether only flights with the bits of this platform count.
        command: the command of the user, named in the message on how to resume; empty without a command line.
    """

    jobs: int = 1
    executor: Executor | None = None
    share: bool = CAN_FORK
    part: bool = False
    budget_s: float | None = None
    max_invalid: float = MOST_INVALID
    warnings: bool = False
    same_platform: bool = False
    command: str = ""


ONE_PROCESS = RunOptions()
NAMED = 3
"""Greatest number of flights that a message names; the message counts the others."""
RISE_M = 0.3
"""A drone that never rises by more than this did not leave the ground [m]."""
ONCE = Spending()
"""All of the usual alpha at once."""
_Z = TRACK_COLUMNS.index("z_m")


def failed_gates(
    outcomes: Iterable[Outcome],
    roster: Roster,
    *,
    controls: Collection[str] | None = None,
    part: bool = False,
    differed: Collection[str] = (),
    max_invalid: float = MOST_INVALID,
    deterministic: bool = True,
    spending: Spending = ONCE,
) -> list[str]:
    """What fails of the gates on some flights, each in a clause.

    Args:
        outcomes: with baselines; an outcome needs its track where `asks_for_track` holds, to tell whether the drone
            left the ground.
        roster: names the controls.
        controls: ids of those that must show an effect if they were flown; None: all.
        part: whether this is one part of a run; then a missing effect is no failure, because another part may have it.
        differed: names of the flights whose repetition had other bits, in this run or in an earlier one.
        max_invalid: greatest share 0..1 of invalid flights.
        deterministic: whether flights repeat their bits; if not, PLACEBO must not be detected by the score's own test,
            instead of being the baseline bit for bit, and a repeated flight proves nothing.
        spending: of alpha by that test.
    """
    listed = list(outcomes)
    failed = [
        *_too_many_invalid(listed, max_invalid),
        *(_same_bits(listed, differed) if deterministic else _placebo_detected(listed, spending)),
        *_raising(listed),
        *_grounded(listed),
    ]
    if not part:
        failed += [*_nothing_steady(listed), *_silent_controls(_of_controls(listed, roster), controls)]
    return failed


def _too_many_invalid(outcomes: Sequence[Outcome], most: float) -> Iterator[str]:
    broken = [outcome for outcome in outcomes if outcome.invalid]
    if len(broken) > most * len(outcomes):
        names = _listed([f"{outcome.name} ({outcome.invalid})" for outcome in broken])
        yield f"{len(broken)} of {len(outcomes)} flights are invalid, more than {most:.0%}: {names}"


def differing(outcomes: Iterable[Outcome], repeats: Iterable[Outcome]) -> list[Outcome]:
    """The repeated flights with other bits than the first ones, which are among `outcomes`."""
    first = {outcome.name: outcome for outcome in outcomes}
    return [one for one in repeats if one.name in first and _differ(one, first[one.name])]


def _differ(one: Outcome, other: Outcome) -> bool:
    return not (one.invalid or other.invalid) and status.digests(one) != status.digests(other)


def _same_bits(outcomes: Sequence[Outcome], differed: Collection[str]) -> Iterator[str]:
    baselines = status.baselines_of(outcomes)
    pairs = [(one, baselines.get((one.situation, one.seed))) for one in outcomes if one.mutant == PLACEBO_ID]
    if placebos := [one.name for one, baseline in pairs if baseline and _differ(one, baseline)]:
        yield f"PLACEBO differs from the baseline: {_listed(placebos)}"
    if differed:
        yield f"{NOT_REPEATED}: {_listed(sorted(differed))}"


def _placebo_detected(outcomes: Sequence[Outcome], spending: Spending) -> Iterator[str]:
    """Fails if the score's test takes PLACEBO, judged as if it altered samples, for a fault."""
    counting = (outcome for outcome in outcomes if outcome.mutant == PLACEBO_ID and not outcome.invalid)
    flown = grouped(counting, lambda outcome: outcome.situation)
    samples = [replace(Sample.of(own), infected=True) for own in flown.values()]
    detection = detect(PLACEBO_ID, samples, Pool.of(outcomes), spending, Kind.SAFETY)
    if detection.detected:
        p = ", ".join(f"{name} p = {detection.p[name]:.2g}" for name in detection.by)
        yield f"PLACEBO, which does nothing, is detected by the score's test ({p}): the flights are no fair comparison"


def _nothing_steady(outcomes: Sequence[Outcome]) -> Iterator[str]:
    """Fails if no pair is steady; without a pool, if no baseline holds a safety requirement that it triggers."""
    baselines = [outcome for outcome in outcomes if outcome.mutant == BASELINE]
    states = [pair.state for pair in Pool.of(baselines).pairs.values() if pair.kind is Kind.SAFETY]
    if State.STEADY in states:
        return
    names = _listed(sorted({outcome.situation for outcome in baselines}))
    if any(state is not State.UNKNOWN for state in states):
        yield f"no situation flown has a steady pair, where the unmutated drone holds a safety requirement: {names}"
    elif not any(r.kind is Kind.SAFETY and r.compliance is Compliance.HELD for o in baselines for r in o.readings):
        yield f"no situation flown has a baseline that holds a safety requirement: {names}"


def _raising(outcomes: Sequence[Outcome]) -> Iterator[str]:
    names = [f"{o.name} ({o.stack_error})" for o in outcomes if o.mutant == BASELINE and o.stack_error]
    if names:
        yield f"the stack raises without any fault: {_listed(names)}"


def asks_for_track(outcome: Outcome) -> bool:
    """Whether the track is needed to tell that the drone left the ground: for a baseline that did not land.

    A flight ends as landed only after take-off, so a landed flight needs no track.
    """
    return outcome.mutant == BASELINE and not outcome.invalid and outcome.ending != Ending.LANDED


def _grounded(outcomes: Sequence[Outcome]) -> Iterator[str]:
    """Fails if a baseline never leaves the ground: a standing drone would hold every safety requirement.

    The check uses the trajectory, because no requirement of the study need cover take-off.
    """
    names = []
    for outcome in outcomes:
        if asks_for_track(outcome) and outcome.track:
            heights = [row[_Z] for row in unpack_track(outcome.track)]
            if max(heights) - heights[0] < RISE_M:
                names.append(outcome.name)
    if names:
        yield f"the drone never leaves the ground without any fault: {_listed(names)}"


def _of_controls(outcomes: Iterable[Outcome], roster: Roster) -> Mapping[str, Sequence[status.JudgedFlight]]:
    """The valid flights of each control."""
    valid = (one for one in status.flights_of(outcomes) if one.status is not status.Status.INVALID)
    return grouped(
        (one for one in valid if cell_of(one.outcome.mutant) in roster.controls), lambda one: one.outcome.mutant
    )


def _silent_controls(
    flown: Mapping[str, Sequence[status.JudgedFlight]], controls: Collection[str] | None
) -> Iterator[str]:
    judged = {name: own for name, own in flown.items() if controls is None or name in controls}
    names = [name for name, own in judged.items() if not any(one.revealed or one.operability_revealed for one in own)]
    if names:
        yield f"a control shows nothing, so faults may not reach the drone: {_listed(names)}"


def failed_in(now: Now, folder: Path) -> str:
    """What fails of the gates on all flights of a campaign that count, in a sentence; empty where all hold.

    A control must show an effect where it was flown in every situation of the grid, and the canary wherever the
    baseline beside it holds the safety requirements.  A campaign that owes flights need not show an effect yet.

    Raises:
        InputError: the campaign cannot be read.
    """
    study, store, roster, proof = now.study, now.store, now.study.roster, canary(now.study)
    controls = {flight.mutant for flight in now.one_each if cell_of(flight.mutant) in roster.controls}
    found = store.standing(now.stands, {BASELINE, PLACEBO_ID, *controls})
    listed = [now.whole(one) if asks_for_track(one) else one for one in found]
    must = {
        name
        for name, own in _of_controls(listed, roster).items()
        if study.space.point.keys() <= {one.outcome.situation for one in own}
        or (proof and name == proof.id and any(one.baseline and not one.baseline.first_violation for one in own))
    }
    checked = partial(
        failed_gates,
        listed,
        roster,
        controls=must,
        differed=differed_in(now),
        max_invalid=1.0,
        deterministic=study.stack.deterministic,
        spending=Spending(study.alpha, grown_in(store)),
    )
    failed = checked()
    if failed and held_in(now, folder).owed:
        failed = checked(part=True)
    broken, allowed = len(now.broken), allowed_in(store)
    if broken and broken > allowed * (flights := sum(map(now.stands, now.flights))):
        (_, mutant, situation, seed, _), why = next(iter(now.broken.items()))
        told = f"{broken} of {flights} flights are invalid, more than {allowed:.0%}"
        failed.append(f"{told}: {mutant}/{situation}/{seed} ({why})")
    return f"gate failed: {'; '.join(failed)}" if failed else ""


def _listed(names: Sequence[str]) -> str:
    rest = f" and {len(names) - NAMED} more" if len(names) > NAMED else ""
    return ", ".join(names[:NAMED]) + rest


_PUBLISHED = Path(__file__).with_name("known_flight.json")


@dataclass(frozen=True)
class KnownFlight:
    """A flight as it was published.

    Attributes:
        name: `MUTANT/SITUATION/SEED`.
        digest: published digest.
        facts: published facts.
        platform: fingerprint of the platform that flew it.
    """

    name: str
    digest: str
    facts: status.Facts
    platform: dict[str, str]


def published() -> KnownFlight:
    """The known flight, from the data file of the package."""
    entry = json.loads(_PUBLISHED.read_text(encoding="utf-8"))
    facts = status.Facts(entry["status"], entry["ending"], tuple(entry["violated"]))
    return KnownFlight(entry["flight"], entry["digest"], facts, entry["platform"])


def packaged_study() -> Study:
    """The study that the package ships; in a checkout, the checkout's."""
    shipped = PACKAGE / "_study"
    return Study(shipped if shipped.is_dir() else PACKAGE.parent)


def fly_again(say: Callable[[str], None], flyer: Flyer | None = None) -> str:
    """Fly the known flight and compare it with the published one; returns a sentence.

    Args:
        say: prints a line for the user.
        flyer: flies; PyBullet when None.

    Raises:
        GateError: status, ending or violations differ from the published ones.
        InputError: the study of the package cannot be flown.
    """
    known, study, flyer = published(), packaged_study(), flyer or Physics()
    mutant, situation, seed = known.name.split("/")
    flyer.prepare(study, say)
    outcome = flyer(study, flight_named(study, mutant, situation, int(seed)))
    if outcome.digest == known.digest:
        return f"{known.name} has its published digest on this platform"
    facts = status.facts_of([outcome])[known.name]
    changed = ", ".join(platforms.differences(platforms.fingerprint(), known.platform))
    where = f"it was published on another platform ({changed})" if changed else "it was published on this platform"
    told = f"{known.name} of the study in {study.folder} has the digest {outcome.digest[:12]}, not {known.digest[:12]}"
    if facts != known.facts:
        raise GateError(f"{told}, and other facts: {facts} here, {known.facts} published; {where}")
    return f"{told}, and the published status, ending and violations ({facts}); {where}"


BASELINES, MUTANTS = 2, 3
"""Greatest number of stored flights of each kind that are flown again after a change of platform."""


def prove_platform(
    study: Study,
    store: Store,
    workers: Workers,
    *,
    say: Callable[[str], None],
    stopped: Callable[[], bool],
    same_platform: bool = False,
) -> None:
    """Record the platform of a new store; fly a sample of the flights of every other platform again on this one.

    If the sample has the same digests, or else the same facts, the stored flights stay valid, and later runs fly no
    sample.  If the facts of a flight differ, the flights of that platform become stale.

    Args:
        study: the current study; the sample is drawn from its current flights.
        store: store of the campaign.
        workers: workers that fly the sample.
        say: prints a line for the user.
        stopped: whether the user asked to stop; then nothing is recorded.
        same_platform: whether flights with other digests become stale although they have the same facts.

    Raises:
        GateError: no flight of a sample could be flown.
    """
    ours, known = platforms.fingerprint(), platforms.Platforms(store)
    if not known.own:
        store.set_meta(ours)
        return
    if known.only(ours):
        return
    for theirs, stored in known.by_platform(counting_flights(study, store)):
        if known.equal(theirs, ours):
            continue
        changed = ", ".join(platforms.differences(ours, theirs))
        if not study.stack.deterministic:
            platforms.remember(store, platforms.BITS, theirs, ours)
            say(
                f"the platform has changed ({changed}); the stack is not deterministic, so no flight is flown again to "
                f"compare: the {len(stored)} stored flights count"
            )
            continue
        pairs = [platforms.pair_of(flight) for flight in stored]
        if known.shown(platforms.FACTS, theirs, ours):
            if same_platform:
                platforms.claim(store, pairs, ours)
                say(f"{len(stored)} flights of another platform ({changed}) have other digests: they do not count")
            continue
        sample = sample_of(stored, str(sorted(ours.items())))
        say(f"the platform has changed ({changed}); {len(sample)} stored flights are flown again")
        compared = _again(study, store, workers, sample, stopped)
        if stopped():
            return
        if not (compared.bits or compared.facts):
            platforms.remember(store, platforms.BITS, theirs, ours)
            say(
                f"{len(compared.equal)} stored flights have the same digests on this platform: the stored flights count"
            )
        elif compared.facts or same_platform:
            platforms.claim(store, pairs, ours)
            differing = ", ".join((*compared.bits, *compared.facts))
            facts = f", and in more than bits: {compared.named()}" if compared.facts else ""
            say(
                f"warning: {differing} came out with another digest{facts}: {len(stored)} stored flights of the "
                "earlier platform do not count any more; `run` flies the requested ones again"
            )
        else:
            platforms.remember(store, platforms.FACTS, theirs, ours)
            say(
                f"{len(compared.bits)} of {len(sample)} stored flights have other digests on this platform, and all "
                "have the same status, ending and violations: the stored flights count, and where a situation and seed "
                "needs more flights, all its flights are flown on this platform"
            )


def sample_of(stored: Sequence[FlownFlight], name: str) -> list[FlownFlight]:
    """A few baselines and mutants that were flown beside them, drawn by a hash of their keys and of `name`.

    The status of a mutant can be compared only where its baseline is flown again too.
    """
    drawn = sorted(stored, key=lambda flight: sha256(f"{name}\n{flight.key}".encode()).digest())
    mutants = [flight for flight in drawn if flight.mutant != BASELINE]
    tested = {platforms.pair_of(flight) for flight in mutants}
    baselines = [flight for flight in drawn if flight.mutant == BASELINE]
    baselines.sort(key=lambda flight: platforms.pair_of(flight) not in tested)
    pairs = {platforms.pair_of(flight) for flight in baselines[:BASELINES]}
    beside = [flight for flight in mutants if platforms.pair_of(flight) in pairs or not pairs]
    return [*baselines[:BASELINES], *beside[:MUTANTS]]


def _again(
    study: Study, store: Store, workers: Workers, sample: Sequence[FlownFlight], stopped: Callable[[], bool]
) -> status.Agreement:
    """Fly the sample again and compare it with the store.

    Raises:
        GateError: no flight could be flown.
    """
    first = tuple(store.outcomes(flight.key for flight in sample))
    names = {outcome.name for outcome in first}
    flights = [flight_named(study, flight.mutant, flight.situation, flight.seed) for flight in sample]
    again = [outcome for outcome in workers.map(alone(flights)) if outcome.name in names]
    if all(outcome.invalid for outcome in again) and not stopped():
        reasons = "; ".join(f"{outcome.name}: {outcome.invalid}" for outcome in again)
        raise GateError(f"gate failed: the platform has changed, and no stored flight could be flown again: {reasons}")
    return status.agreement(first, again)
