"""What a flight's status says: the rung of reach, infect, propagate, reveal where the fault stopped."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from enum import StrEnum

from scaloft_fi.results.outcome import BASELINE, Outcome
from scaloft_fi.results.requirement import Kind, Reading


class Status(StrEnum):
    """Status of a flight or a mutant; `rung` orders them."""

    INVALID = "invalid"
    """The harness failed: never a kill, never a survivor."""
    NOT_REACHED = "not_reached"
    """The seam carried no sample."""
    NOT_INFECTED = "not_infected"
    """Every mutated sample equalled the original."""
    MASKED = "masked"
    """Samples differed, the ground truth is the baseline's to the bit."""
    BASELINE_RED = "baseline_red"
    """It violates only what the baseline violates too (the same requirement, on the same body), or only later than a
    cut-short baseline's end."""
    SURVIVED = "survived"
    """The rest."""
    KILLED = "killed"
    """A safety requirement is violated that the baseline held up to that moment."""

    __hash__ = str.__hash__
    """As that of its text; statuses are counted by the hundred thousand."""

    @property
    def rung(self) -> int:
        """Height on the ladder."""
        return _RUNGS[self]

    @property
    def infected(self) -> bool:
        """Whether the fault changed at least one sample."""
        return self in _INFECTED


_RUNGS = {status: rung for rung, status in enumerate(Status)}
_INFECTED = frozenset(status for status, rung in _RUNGS.items() if rung >= _RUNGS[Status.MASKED])


@dataclass(frozen=True)
class Flight:
    """A flight beside its baseline.

    Attributes:
        outcome: the flight.
        baseline: of the same situation and seed; None when there is none that counts.
        status: where the fault stopped.
        kills: safety requirements by which it is killed, earliest first.
        operability_kills: the same for operability requirements.
        eligible: infected, and the baseline held a safety requirement to its end.
        operability_eligible: infected, and the baseline held an operability requirement to its end.
        tested: requirements that the fault was put to the test of: of a kind that kills, held by the baseline to its
            end.
    """

    outcome: Outcome
    baseline: Outcome | None
    status: Status
    kills: tuple[str, ...] = ()
    operability_kills: tuple[str, ...] = ()
    eligible: bool = False
    operability_eligible: bool = False
    tested: tuple[str, ...] = ()

    @property
    def killed_at_s(self) -> float | None:
        """Time of the earliest kill [s from take-off]."""
        times = [reading.violated_at_s for reading in self.outcome.readings if reading.requirement in self.kills]
        return min((time for time in times if time is not None), default=None)


def flight_of(outcome: Outcome, baseline: Outcome | None) -> Flight:
    """Judge a mutant's flight by the baseline of the same situation and seed; without one that counts it is invalid."""
    return _beside(outcome, _Clean.of(baseline))


@dataclass(frozen=True)
class _Clean:
    """What there is to know of a baseline, found once for all the flights beside it."""

    outcome: Outcome
    eligible: bool
    operability_eligible: bool
    tested: tuple[str, ...]

    @classmethod
    def of(cls, baseline: Outcome | None) -> _Clean | None:
        """The same of a baseline that counts."""
        if baseline is None or baseline.invalid:
            return None
        tested = tuple(
            reading.requirement
            for reading in baseline.readings
            if reading.kind is not Kind.REPORTED and not (reading.violated or reading.open)
        )
        return cls(baseline, held_to_end(baseline, Kind.SAFETY), held_to_end(baseline, Kind.OPERABILITY), tested)


def _beside(outcome: Outcome, clean: _Clean | None) -> Flight:
    if outcome.invalid or clean is None:
        return Flight(outcome, None, Status.INVALID)
    baseline = clean.outcome
    if outcome.altered == 0:
        return Flight(outcome, baseline, Status.NOT_INFECTED if outcome.carried else Status.NOT_REACHED)
    infected = clean.eligible, clean.operability_eligible, clean.tested
    if outcome.digest == baseline.digest:
        return Flight(outcome, baseline, Status.MASKED, (), (), *infected)
    broken = [reading for reading in outcome.readings if reading.violated_at_s is not None]
    if not broken:
        return Flight(outcome, baseline, Status.SURVIVED, (), (), *infected)
    unsafe = [reading for reading in broken if reading.kind is Kind.SAFETY]
    kills = _killed_by(outcome, baseline, unsafe)
    inoperable = [reading for reading in broken if reading.kind is Kind.OPERABILITY]
    status = Status.KILLED if kills else Status.BASELINE_RED if unsafe else Status.SURVIVED
    return Flight(outcome, baseline, status, kills, _killed_by(outcome, baseline, inoperable), *infected)


def held_to_end(baseline: Outcome, kind: Kind) -> bool:
    """Whether the baseline violated one requirement of the kind at no time and was not cut short."""
    return any(not (reading.violated or reading.open) for reading in baseline.readings if reading.kind is kind)


def killed_by(outcome: Outcome, baseline: Outcome, kind: Kind) -> tuple[str, ...]:
    """The requirements of a kind by whose violation the flight is told from its baseline, earliest first."""
    return _killed_by(outcome, baseline, [reading for reading in outcome.readings if reading.kind is kind])


def _killed_by(outcome: Outcome, baseline: Outcome, readings: Iterable[Reading]) -> tuple[str, ...]:
    """The same of some of its readings."""
    found: list[tuple[float, str]] = []
    for reading in readings:
        name, at_s = reading.requirement, reading.violated_at_s
        clean = None if at_s is None else baseline.reading(name)
        if at_s is not None and clean is not None:
            same = _struck(outcome, name) == _struck(baseline, name)
            if _held_until(clean, at_s, baseline.duration_s, same=same):
                found.append((at_s, name))
    return tuple(name for _, name in sorted(found, key=lambda pair: pair[0]))


def _struck(flight: Outcome, requirement: str) -> str:
    """The body struck when the flight violated the requirement; "" when none was."""
    for violation in flight.violations:
        if violation.requirement == requirement:
            return violation.struck
    return ""


def _held_until(clean: Reading, t_s: float, end_s: float, *, same: bool) -> bool:
    """Whether the baseline held up to `t_s` what a flight violates then.

    To violate sooner what the baseline violates too, on the `same` body, proves nothing: any change of the flight
    moves that moment.  Of a baseline that was cut short only what it flew counts.
    """
    if clean.violated_at_s is not None:
        return not same and t_s < clean.violated_at_s
    return not clean.open or t_s <= end_s


def baseline_status(baseline: Outcome) -> str:
    """`held` or `violated` (a safety requirement), or `invalid`."""
    if baseline.invalid:
        return Status.INVALID.value
    return "violated" if baseline.first_violation else "held"


def baselines_of(outcomes: Iterable[Outcome]) -> dict[tuple[str, int], Outcome]:
    """The baseline of each situation and seed."""
    return {(outcome.situation, outcome.seed): outcome for outcome in outcomes if outcome.mutant == BASELINE}


def baseline_pool(outcomes: Iterable[Outcome]) -> dict[str, list[Outcome]]:
    """The baselines of each situation, over all seeds."""
    found: dict[str, list[Outcome]] = {}
    for outcome in outcomes:
        if outcome.mutant == BASELINE:
            found.setdefault(outcome.situation, []).append(outcome)
    return found


def whole(outcomes: Iterable[Outcome]) -> list[Outcome]:
    """Without flights cut at their first kill: what else they would have done nobody knows."""
    return [outcome for outcome in outcomes if not outcome.truncated]


def flights_of(outcomes: Iterable[Outcome]) -> list[Flight]:
    """Every flight of a mutant (PLACEBO among them) beside its baseline, in the order given."""
    listed = list(outcomes)
    clean = {draw: _Clean.of(baseline) for draw, baseline in baselines_of(listed).items()}
    return [
        _beside(outcome, clean.get((outcome.situation, outcome.seed)))
        for outcome in listed
        if outcome.mutant != BASELINE
    ]


def mutant_status(flights: Iterable[Flight]) -> Status:
    """The highest rung over a mutant's eligible flights.

    A mutant without one shows how far its fault came: a flight that infects where the baseline holds no safety
    requirement to its end proves nothing about it and stands as `baseline_red`.
    """
    listed = list(flights)
    statuses = {flight.status for flight in listed if flight.eligible}
    if not statuses:
        statuses = {
            Status.BASELINE_RED if status.rung > Status.BASELINE_RED.rung else status
            for status in {flight.status for flight in listed}
        }
    return max(statuses, key=lambda status: status.rung, default=Status.INVALID)
