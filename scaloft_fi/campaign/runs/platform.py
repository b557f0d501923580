"""After a change of platform, fly a sample of the stored flights again and compare the digests."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from hashlib import sha256

from scaloft_fi.campaign.plan.arrange import alone
from scaloft_fi.campaign.runs.gates import digests
from scaloft_fi.campaign.store.fingerprint import fingerprint
from scaloft_fi.campaign.store.held import counting_flights, flight_named
from scaloft_fi.campaign.store.platforms import agree, outgrow, unproved
from scaloft_fi.campaign.store.selection import Flown
from scaloft_fi.campaign.store.store import Store
from scaloft_fi.campaign.workers.executor import Workers
from scaloft_fi.errors import GateError
from scaloft_fi.judge.outcome import BASELINE
from scaloft_fi.study import Study

BASELINES, MUTANTS = 2, 3
"""Number of stored flights of each kind that are flown again after a change of platform."""


def prove_platform(
    study: Study, store: Store, workers: Workers, *, say: Callable[[str], None], stopped: Callable[[], bool]
) -> None:
    """Record the platform of a new store; on another platform, fly a sample of the stored flights again.

    If the sample has the same digests, the stored flights stay valid, and later runs fly no sample.  If a digest
    differs, or the store has no flight to compare, the stored flights become stale.

    Args:
        study: the current study; the sample is drawn from its current flights.
        store: store of the campaign.
        workers: workers that fly the sample.
        say: prints a line for the user.
        stopped: whether the user asked to stop; then nothing is recorded.

    Raises:
        GateError: no flight of the sample could be flown.
    """
    ours = fingerprint()
    changed = ", ".join(unproved(store, ours))
    if not changed:
        store.set_meta(ours)
        return
    stored = counting_flights(study, store)
    if not stored:
        outgrow(store, ours)
        return
    sample = sample_of(stored, str(sorted(ours.items())))
    say(f"the platform has changed ({changed}); {len(sample)} stored flights are flown again")
    first = {outcome.name: outcome for outcome in store.outcomes(flight.key for flight in sample)}
    flights = [flight_named(study, flight.mutant, flight.situation, flight.seed) for flight in sample]
    again = [outcome for outcome in workers.map(alone(flights)) if outcome.name in first]
    if stopped():
        return
    valid = [outcome for outcome in again if not outcome.invalid]
    if not valid:
        reasons = "; ".join(f"{outcome.name}: {outcome.invalid}" for outcome in again)
        raise GateError(f"gate failed: the platform has changed, and no stored flight could be flown again: {reasons}")
    differing = [outcome.name for outcome in valid if digests(outcome) != digests(first[outcome.name])]
    if not differing:
        agree(store, ours)
        say(f"{len(valid)} stored flights have the same digests on this platform: the stored flights count")
        return
    outgrow(store, ours)
    say(
        f"warning: {', '.join(differing)} came out with another digest: {len(stored)} stored flights of the earlier "
        "platform do not count any more; `run` flies the requested ones again"
    )


def sample_of(stored: Sequence[Flown], name: str) -> list[Flown]:
    """A few baselines and a few mutants, drawn by a hash of their keys and of `name`."""
    drawn = sorted(stored, key=lambda flight: sha256(f"{name}\n{flight.key}".encode()).digest())
    baselines = [flight for flight in drawn if flight.mutant == BASELINE]
    mutants = [flight for flight in drawn if flight.mutant != BASELINE]
    return [*baselines[:BASELINES], *mutants[:MUTANTS]]
