"""What the kill matrix shows of a mutant in a situation, and which of its flights a click on that opens."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from enum import StrEnum

from scaloft_fi.analysis.kill_matrix import Entry
from scaloft_fi.analysis.pool import Pool, State
from scaloft_fi.analysis.score import MutantScore
from scaloft_fi.judge.requirement import Kind
from scaloft_fi.judge.status import INVALID, Ruled, Situations, Status


class Sign(StrEnum):
    """What a cell of the kill matrix shows; the first that fits."""

    NOT_FLOWN = "not_flown"
    """No flight that counts."""
    KILL = "kill"
    """A steady pair in which most flights of a detected mutant violate."""
    NOT_REACHED = "not_reached"
    """The seam carried no sample."""
    NOT_INFECTED = "not_infected"
    """No sample was changed."""
    MASKED = "masked"
    """Samples were changed, the drone flew the same to the bit."""
    SEEN = "seen"
    """A requirement that tests the fault, or may do so, is violated, and that makes no kill."""
    TESTED = "tested"
    """Put to the test, and nothing was seen."""
    NO_TEST = "no_test"
    """No safety requirement is steady here, so nothing is tested."""


_STOPPED = {status: Sign(status) for status in (Status.NOT_REACHED, Status.NOT_INFECTED, Status.MASKED)}


def seen_in(entry: Entry, pool: Pool) -> tuple[str, ...]:
    """Safety requirements that are violated and test the fault; where no pool says what tests, those of any flight."""
    if entry.tested or entry.state != Status.REVEALED:
        return entry.seen
    pairs = [pool.pairs.get((entry.situation, name)) for name, _ in entry.violated]
    return tuple(p.requirement for p in pairs if p and p.kind is Kind.SAFETY and p.state is State.UNKNOWN)


def sign_of(entry: Entry, seen: Collection[str]) -> Sign:
    """The sign of a mutant in a situation where these requirements are `seen_in` it."""
    if not entry.flown:
        return Sign.NOT_FLOWN
    if entry.kills:
        return Sign.KILL
    stopped = _STOPPED.get(Status(entry.state))
    if stopped is not None:
        return stopped
    if seen:
        return Sign.SEEN
    return Sign.TESTED if entry.tested else Sign.NO_TEST


def opening(flights: Sequence[Ruled], wanted: Iterable[str]) -> int:
    """The seed of the flight to show: the lowest one that violates what is `wanted` beside a baseline that holds it.

    Args:
        flights: of a mutant in a situation, at least one, in the order of their seeds.
        wanted: requirements, the most telling first; a flight that violates one whatever its baseline does is next
            best, then the first that counts.
    """
    counting = [one for one in flights if one.ruling is not INVALID] or list(flights)
    for name in wanted:
        violating = [one for one in counting if name in one.ruling.violated]
        revealing = [one for one in violating if name in (*one.ruling.revealed, *one.ruling.operability_revealed)]
        if violating:
            return (revealing or violating)[0].seed
    return counting[0].seed


def shown_by(mutant: MutantScore, flights: Situations) -> tuple[str, ...]:
    """The requirements that show a control: those that detect it, else those that one flight beside its baseline does.

    Args:
        mutant: the control's score.
        flights: of it.
    """
    detecting = (*mutant.safety.by, *mutant.operability.by)
    rulings = (one.ruling for listed in flights.values() for one in listed)
    return detecting or tuple(
        dict.fromkeys(name for ruling in rulings for name in (*ruling.revealed, *ruling.operability_revealed))
    )
