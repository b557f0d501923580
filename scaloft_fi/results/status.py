"""What a flight's status says: the rung of reach, infect, propagate, reveal where the fault stopped."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from enum import StrEnum
from functools import cache
from operator import attrgetter

from scaloft_fi.bulk import bulk
from scaloft_fi.results.outcome import BASELINE, Outcome, Violation
from scaloft_fi.results.requirement import Kind


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


@dataclass(frozen=True, slots=True, eq=False)
class Ruling:
    """What a flight beside its baseline comes to.  Few differ, and equal ones are one object, so they can be counted.

    Attributes:
        status: where the fault stopped.
        kills: safety requirements by which it is killed, earliest first.
        operability_kills: the same for operability requirements.
        eligible: infected, and the baseline held a safety requirement to its end.
        operability_eligible: infected, and the baseline held an operability requirement to its end.
        tested: requirements that the fault was put to the test of: of a kind that kills, held by the baseline to its
            end.
        violated: requirements that the flight violates, whatever the baseline does; of a flight that counts.
    """

    status: Status
    kills: tuple[str, ...] = ()
    operability_kills: tuple[str, ...] = ()
    eligible: bool = False
    operability_eligible: bool = False
    tested: tuple[str, ...] = ()
    violated: tuple[str, ...] = ()


_ruling = cache(Ruling)
_INVALID, _NOT_REACHED, _NOT_INFECTED = map(_ruling, (Status.INVALID, Status.NOT_REACHED, Status.NOT_INFECTED))


@dataclass(frozen=True, slots=True)
class Flight:
    """A flight beside its baseline.

    Attributes:
        outcome: the flight.
        baseline: of the same situation and seed; None when there is none that counts.
        ruling: what it comes to.
    """

    outcome: Outcome
    baseline: Outcome | None
    ruling: Ruling

    @property
    def status(self) -> Status:
        """Where the fault stopped."""
        return self.ruling.status

    @property
    def kills(self) -> tuple[str, ...]:
        """Safety requirements by which it is killed, earliest first."""
        return self.ruling.kills

    @property
    def operability_kills(self) -> tuple[str, ...]:
        """The same for operability requirements."""
        return self.ruling.operability_kills

    @property
    def eligible(self) -> bool:
        """Whether it is infected, and the baseline held a safety requirement to its end."""
        return self.ruling.eligible

    @property
    def operability_eligible(self) -> bool:
        """Whether it is infected, and the baseline held an operability requirement to its end."""
        return self.ruling.operability_eligible

    @property
    def killed_at_s(self) -> float | None:
        """Time of the earliest kill [s from take-off]."""
        return min((v.t_s for v in self.outcome.violations if v.requirement in self.kills), default=None)


def flight_of(outcome: Outcome, baseline: Outcome | None) -> Flight:
    """Judge a mutant's flight by the baseline of the same situation and seed; without one that counts it is invalid."""
    clean = _clean(baseline)
    ruling = _ruled(outcome, clean)
    return Flight(outcome, None if ruling.status is Status.INVALID else baseline, ruling)


class _Clean:
    """What there is to know of a baseline, found once for all the flights beside it."""

    def __init__(self, baseline: Outcome) -> None:
        self.outcome = baseline
        self.eligible = held_to_end(baseline, Kind.SAFETY)
        self.operability_eligible = held_to_end(baseline, Kind.OPERABILITY)
        self.tested = tuple(
            reading.requirement
            for reading in baseline.readings
            if reading.kind is not Kind.REPORTED and not (reading.violated or reading.open)
        )
        self.readings = {reading.requirement: reading for reading in baseline.readings}
        infected = self.eligible, self.operability_eligible, self.tested
        self._masked = _ruling(Status.MASKED, (), (), *infected, ())
        self._survived = _ruling(Status.SURVIVED, (), (), *infected, ())

    def beside(self, outcome: Outcome) -> Ruling:
        """The ruling of a flight that violates nothing."""
        if outcome.altered == 0:
            return _NOT_INFECTED if outcome.carried else _NOT_REACHED
        return self._masked if outcome.digest == self.outcome.digest else self._survived


def _clean(baseline: Outcome | None) -> _Clean | None:
    """The same of a baseline that counts."""
    return None if baseline is None or baseline.invalid else _Clean(baseline)


def _ruled(outcome: Outcome, clean: _Clean | None) -> Ruling:
    if outcome.invalid or clean is None:
        return _INVALID
    broken = outcome.violations
    if not broken:
        return clean.beside(outcome)
    violated = tuple([violation.requirement for violation in broken])
    if outcome.altered == 0:
        status = Status.NOT_INFECTED if outcome.carried else Status.NOT_REACHED
        return _ruling(status, (), (), False, False, (), violated)
    infected = clean.eligible, clean.operability_eligible, clean.tested, violated
    if outcome.digest == clean.outcome.digest:
        return _ruling(Status.MASKED, (), (), *infected)
    told = _told(outcome, clean)
    kills, operability_kills = _named(told, Kind.SAFETY), _named(told, Kind.OPERABILITY)
    unsafe = kills or any(violation.kind is Kind.SAFETY for violation in broken)
    status = Status.KILLED if kills else Status.BASELINE_RED if unsafe else Status.SURVIVED
    return _ruling(status, kills, operability_kills, *infected)


def held_to_end(baseline: Outcome, kind: Kind) -> bool:
    """Whether the baseline violated one requirement of the kind at no time and was not cut short."""
    return any(not (reading.violated or reading.open) for reading in baseline.readings if reading.kind is kind)


def killed_by(outcome: Outcome, baseline: Outcome, kind: Kind) -> tuple[str, ...]:
    """The requirements of a kind by whose violation the flight is told from its baseline, earliest first."""
    return _named(_told(outcome, _Clean(baseline)), kind)


def _told(outcome: Outcome, clean: _Clean) -> list[Violation]:
    """The violations by which the flight is told from its baseline, earliest first.

    To violate sooner what the baseline violates too, on the same body, proves nothing: any change of the flight
    moves that moment.  Of a baseline that was cut short only what it flew counts.
    """
    found = []
    for violation in outcome.violations:
        name, at_s = violation.requirement, violation.t_s
        held = clean.readings.get(name)
        if held is None:
            continue
        if held.violated_at_s is None:
            told = not held.open or at_s <= clean.outcome.duration_s
        else:
            told = at_s < held.violated_at_s and violation.struck != _struck(clean.outcome, name)
        if told:
            found.append(violation)
    if len(found) > 1:
        found.sort(key=_time)
    return found


def _named(told: Sequence[Violation], kind: Kind) -> tuple[str, ...]:
    """Their requirements, of one kind."""
    return tuple([violation.requirement for violation in told if violation.kind is kind]) if told else ()


_time = attrgetter("t_s")


def _struck(flight: Outcome, requirement: str) -> str:
    """The body struck when the flight violated the requirement; "" when none was."""
    for violation in flight.violations:
        if violation.requirement == requirement:
            return violation.struck
    return ""


def baseline_status(baseline: Outcome) -> str:
    """`held` or `violated` (a safety requirement), or `invalid`."""
    if baseline.invalid:
        return Status.INVALID.value
    return "violated" if baseline.first_violation else "held"


def baselines_of(outcomes: Iterable[Outcome]) -> dict[tuple[str, int], Outcome]:
    """The baseline of each situation and seed."""
    return {(outcome.situation, outcome.seed): outcome for outcome in outcomes if outcome.subject.id == BASELINE}


def baseline_pool(outcomes: Iterable[Outcome]) -> dict[str, list[Outcome]]:
    """The baselines of each situation, over all seeds."""
    found: dict[str, list[Outcome]] = {}
    for outcome in outcomes:
        if outcome.subject.id == BASELINE:
            found.setdefault(outcome.situation, []).append(outcome)
    return found


def apart(outcomes: Iterable[Outcome]) -> tuple[list[Outcome], list[Outcome]]:
    """The baselines and the flights of mutants (PLACEBO among them), each in the order given."""
    clean: list[Outcome] = []
    flown: list[Outcome] = []
    for outcome in outcomes:
        (clean if outcome.subject.id == BASELINE else flown).append(outcome)
    return clean, flown


def whole(outcomes: Iterable[Outcome]) -> list[Outcome]:
    """Without flights cut at their first kill: what else they would have done nobody knows."""
    return [outcome for outcome in outcomes if not outcome.truncated]


def flights_of(outcomes: Iterable[Outcome]) -> list[Flight]:
    """Every flight of a mutant (PLACEBO among them) beside its baseline, in the order given."""
    baselines, flown = apart(outcomes)
    clean = {(baseline.situation, baseline.seed): _clean(baseline) for baseline in baselines}
    beside = [clean.get((outcome.situation, outcome.seed)) for outcome in flown]
    rulings = list(map(_ruled, flown, beside))
    counting = [
        None if known is None or ruling is _INVALID else known.outcome
        for known, ruling in zip(beside, rulings, strict=True)
    ]
    return bulk(Flight, (flown, counting, rulings))


def by_situation(flights: Iterable[Flight]) -> dict[str, list[Flight]]:
    """The flights in each situation, in the order given."""
    found: dict[str, list[Flight]] = {}
    for flight in flights:
        found.setdefault(flight.outcome.situation, []).append(flight)
    return found


def mutant_status(flights: Iterable[Flight | Ruling]) -> Status:
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
