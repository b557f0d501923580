"""After a change of platform, fly a sample of the stored flights again and compare digests, then facts."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from hashlib import sha256

from scaloft_fi.campaign.plan.arrange import alone
from scaloft_fi.campaign.store.fingerprint import differences, fingerprint
from scaloft_fi.campaign.store.held import counting_flights, flight_named
from scaloft_fi.campaign.store.platforms import BITS, FACTS, Platform, Platforms, claim, remember
from scaloft_fi.campaign.store.selection import Flown
from scaloft_fi.campaign.store.store import Store
from scaloft_fi.campaign.workers.executor import Workers
from scaloft_fi.errors import GateError
from scaloft_fi.judge.outcome import BASELINE
from scaloft_fi.judge.status import Agreement, agreement
from scaloft_fi.study import Study

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
    ours = fingerprint()
    known = Platforms(store)
    if not known.own:
        store.set_meta(ours)
        return
    if known.only(ours):
        return
    for theirs, stored in known.by_platform(counting_flights(study, store)):
        if known.equal(theirs, ours):
            continue
        changed = ", ".join(differences(ours, theirs))
        if not study.stack.deterministic:
            remember(store, BITS, theirs, ours)
            say(
                f"the platform has changed ({changed}); the stack is not deterministic, so no flight is flown again to "
                f"compare: the {len(stored)} stored flights count"
            )
            continue
        if known.shown(FACTS, theirs, ours):
            if same_platform:
                _outgrow(store, stored, ours)
                say(f"{len(stored)} flights of another platform ({changed}) have other digests: they do not count")
            continue
        sample = sample_of(stored, str(sorted(ours.items())))
        say(f"the platform has changed ({changed}); {len(sample)} stored flights are flown again")
        compared = _again(study, store, workers, sample, stopped)
        if stopped():
            return
        if not (compared.bits or compared.facts):
            remember(store, BITS, theirs, ours)
            say(
                f"{len(compared.equal)} stored flights have the same digests on this platform: the stored flights count"
            )
        elif compared.facts or same_platform:
            _outgrow(store, stored, ours)
            say(_stale(compared, len(stored)))
        else:
            remember(store, FACTS, theirs, ours)
            say(
                f"{len(compared.bits)} of {len(sample)} stored flights have other digests on this platform, and all "
                "have the same status, ending and violations: the stored flights count, and where a situation and seed "
                "needs more flights, all its flights are flown on this platform"
            )


def sample_of(stored: Sequence[Flown], name: str) -> list[Flown]:
    """A few baselines and mutants that were flown beside them, drawn by a hash of their keys and of `name`.

    The status of a mutant can be compared only where its baseline is flown again too.
    """
    drawn = sorted(stored, key=lambda flight: sha256(f"{name}\n{flight.key}".encode()).digest())
    mutants = [flight for flight in drawn if flight.mutant != BASELINE]
    tested = {_pair(flight) for flight in mutants}
    baselines = [flight for flight in drawn if flight.mutant == BASELINE]
    baselines.sort(key=lambda flight: _pair(flight) not in tested)
    pairs = {_pair(flight) for flight in baselines[:BASELINES]}
    beside = [flight for flight in mutants if _pair(flight) in pairs or not pairs]
    return [*baselines[:BASELINES], *beside[:MUTANTS]]


def _again(
    study: Study, store: Store, workers: Workers, sample: Sequence[Flown], stopped: Callable[[], bool]
) -> Agreement:
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
    return agreement(first, again)


def _outgrow(store: Store, stored: Sequence[Flown], ours: Platform) -> None:
    """Make stored flights stale, and every other flight of their situations and seeds."""
    claim(store, map(_pair, stored), ours)


def _stale(compared: Agreement, stored: int) -> str:
    """The sentence about stored flights that became stale."""
    differing = compared.bits + tuple(compared.facts)
    facts = f", and in more than bits: {compared.named()}" if compared.facts else ""
    return (
        f"warning: {', '.join(differing)} came out with another digest{facts}: {stored} stored flights of the earlier "
        "platform do not count any more; `run` flies the requested ones again"
    )


def _pair(flight: Flown) -> tuple[str, int]:
    return flight.situation, flight.seed
