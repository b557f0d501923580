"""What a flight's status says: the stage of reach, infect, propagate, reveal where the fault stopped; rulings."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from functools import cache
from operator import attrgetter, itemgetter
from typing import NamedTuple

from scaloft_fi.judge.outcome import BASELINE, TRACK_COLUMNS, Outcome, Subject, Violation, unpack_track
from scaloft_fi.judge.requirement import Kind, Reading


class Status(StrEnum):
    """Status of a flight: the stage where the fault stopped; `stage` orders them."""

    INVALID = "invalid"
    """The harness failed; the flight is never a kill and never a survivor."""
    NOT_REACHED = "not_reached"
    """The seam carried no sample."""
    NOT_INFECTED = "not_infected"
    """Every mutated sample equalled the original."""
    MASKED = "masked"
    """Samples differed; the ground truth equals the baseline's to the bit."""
    BASELINE_RED = "baseline_red"
    """The flight violates only requirements that the baseline violates too (on the same body), or violates only after
    the end of a baseline that was cut short."""
    SURVIVED = "survived"
    """Samples and ground truth differed, without a violation of a safety requirement."""
    REVEALED = "revealed"
    """The flight violates a safety requirement that the baseline of its situation and seed held until then: an
    observation, which another seed may not repeat."""

    __hash__ = str.__hash__
    """The hash of the text, because it is faster than that of an enumeration."""

    @property
    def stage(self) -> int:
        """Place on the way of a fault: reach, infect, propagate, reveal."""
        return _STAGES[self]

    @property
    def infected(self) -> bool:
        """Whether the fault changed at least one sample."""
        return self in _INFECTED


_STAGES = {status: stage for stage, status in enumerate(Status)}
_INFECTED = frozenset(status for status, stage in _STAGES.items() if stage >= _STAGES[Status.MASKED])


@dataclass(frozen=True, slots=True, eq=False)
class Ruling:
    """Result of the comparison of a flight with its baseline.  Equal rulings are one object, so counting is fast.

    Attributes:
        status: highest rung that the fault reached.
        revealed: safety requirements that the flight violates and the baseline held until then, earliest first.
        operability_revealed: operability requirements of the same kind, earliest first.
        violated: all requirements that a valid flight violates.
    """

    status: Status
    revealed: tuple[str, ...] = ()
    operability_revealed: tuple[str, ...] = ()
    violated: tuple[str, ...] = ()


_ruling = cache(Ruling)
INVALID = _ruling(Status.INVALID)
"""Ruling of an invalid flight."""
_PLAIN = {status: _ruling(status) for status in Status}
"""Rulings of flights without a violation, by status."""


_NEVER = -math.inf, None


class Baseline:
    """A valid baseline, prepared for the comparison with many flights.

    Args:
        outcome: outcome of the baseline.
    """

    def __init__(self, outcome: Outcome) -> None:
        self.outcome = outcome
        self._limits = {reading.requirement: _limit(reading, outcome) for reading in outcome.readings}

    def rule(self, carried: int, altered: int, digest: str, violations: Sequence[Violation]) -> Ruling:
        """The ruling of a valid flight; the arguments are attributes of its outcome."""
        if altered == 0:
            status = Status.NOT_INFECTED if carried else Status.NOT_REACHED
        else:
            status = Status.MASKED if digest == self.outcome.digest else Status.SURVIVED
        if not violations:
            return _PLAIN[status]
        violated = tuple([violation.requirement for violation in violations])
        if status is not Status.SURVIVED:
            return _ruling(status, (), (), violated)
        new = self._new_violations(violations)
        revealed, operability = _requirements(new, Kind.SAFETY), _requirements(new, Kind.OPERABILITY)
        if revealed:
            status = Status.REVEALED
        elif any(violation.kind is Kind.SAFETY for violation in violations):
            status = Status.BASELINE_RED
        return _ruling(status, revealed, operability, violated)

    def _new_violations(self, violations: Iterable[Violation]) -> list[Violation]:
        """The violations that the baseline does not have, earliest first.

        An earlier violation of a requirement that the baseline violates too, on the same body, is not new: any change
        of the flight moves its time.  After the end of a baseline that was cut short no violation is new.
        """
        new = []
        for violation in violations:
            last_s, struck = self._limits.get(violation.requirement, _NEVER)
            if violation.t_s <= last_s and violation.struck != struck:
                new.append(violation)
        return sorted(new, key=attrgetter("t_s"))


def _limit(reading: Reading, baseline: Outcome) -> tuple[float, str | None]:
    """Latest time of a new violation of a requirement [s], and the body it is not on (None = it may be on any)."""
    if reading.violated_at_s is not None:
        struck = next((v.struck for v in baseline.violations if v.requirement == reading.requirement), "")
        return math.nextafter(reading.violated_at_s, -math.inf), struck
    return baseline.duration_s if reading.open else math.inf, None


def _requirements(violations: Sequence[Violation], kind: Kind) -> tuple[str, ...]:
    """The violated requirements of one kind."""
    return tuple([violation.requirement for violation in violations if violation.kind is kind]) if violations else ()


def counting(baseline: Outcome | None) -> Baseline | None:
    """The prepared baseline; None without a valid one."""
    return None if baseline is None or baseline.invalid else Baseline(baseline)


def _counting(baselines: Iterable[Outcome]) -> Mapping[tuple[str, int], Baseline | None]:
    return {(baseline.situation, baseline.seed): counting(baseline) for baseline in baselines}


def rule(outcome: Outcome, baseline: Baseline | None) -> Ruling:
    """The ruling of a mutant's flight beside the baseline of its situation and seed; invalid without a baseline."""
    if outcome.invalid or baseline is None:
        return INVALID
    return baseline.rule(outcome.carried, outcome.altered, outcome.digest, outcome.violations)


def baseline_status(baseline: Outcome) -> str:
    """`held` or `violated` (a safety requirement), or `invalid`."""
    if baseline.invalid:
        return Status.INVALID.value
    return "violated" if baseline.first_violation else "held"


def furthest(statuses: Iterable[Status]) -> Status:
    """The furthest stage that flights reached; invalid when there is none."""
    return max(statuses, key=_STAGES.__getitem__, default=Status.INVALID)


class Ruled(NamedTuple):
    """A mutant's flight with its ruling.

    Attributes:
        seed: seed of the noise.
        ruling: result of the comparison with the baseline.
        violations: first violation of each violated requirement.
    """

    seed: int
    ruling: Ruling
    violations: Sequence[Violation]


Situations = Mapping[str, Sequence[Ruled]]
"""Flights of a mutant by situation, in the order of their seeds."""


class Brief(NamedTuple):
    """All of an outcome that decides its ruling beside its baseline; the attributes are those of `Outcome`."""

    subject: Subject
    situation: str
    seed: int
    invalid: str
    carried: int
    altered: int
    digest: str
    violations: Sequence[Violation]


_BRIEF = attrgetter(*Brief._fields)


def brief(outcome: Outcome) -> Brief:
    """Of an outcome."""
    return Brief(*_BRIEF(outcome))


@dataclass(frozen=True)
class Rulings:
    """The flights of a campaign.

    Attributes:
        baselines: outcomes of the drone without a fault.
        mutants: flights by mutant (PLACEBO included).
        draws: situations and seeds with a valid flight of a mutant.
        behaviours: by id of the mutant a number, in this process, for all its valid flights; equal ones flew the same.
    """

    baselines: tuple[Outcome, ...]
    mutants: Mapping[Subject, Situations]
    draws: frozenset[tuple[str, int]]
    behaviours: Mapping[str, int]

    @property
    def situations(self) -> set[str]:
        """Keys of the flown situations."""
        return {outcome.situation for outcome in self.baselines}.union(*self.mutants.values())

    def __bool__(self) -> bool:
        """Whether there is any flight."""
        return bool(self.baselines or self.mutants)


def rulings_of(outcomes: Iterable[Outcome]) -> Rulings:
    """The rulings of outcomes, which may be in any order."""
    baselines, flown = apart(outcomes)
    return rulings_beside(baselines, map(brief, flown))


def rulings_beside(baselines: Sequence[Outcome], flown: Iterable[Brief]) -> Rulings:
    """The rulings of flights of mutants beside their baselines.

    Args:
        baselines: outcomes of the drone without a fault.
        flown: of mutants and PLACEBO, in any order, read once.
    """
    counted = _counting(baselines)
    subjects, draws = dict[str, Subject](), set[tuple[str, int]]()
    flights = defaultdict[tuple[str, str], list[Ruled]](list)
    behaviours = defaultdict[str, int](int)
    for subject, situation, seed, invalid, carried, altered, digest, violations in flown:
        mutant, draw = subject.id, (situation, seed)
        baseline = None if invalid else counted.get(draw)
        if baseline is None:
            ruled = Ruled(seed, INVALID, ())
        else:
            ruled = Ruled(seed, baseline.rule(carried, altered, digest, violations), violations)
        flights[mutant, situation].append(ruled)
        subjects[mutant] = subject
        if not invalid:
            draws.add(draw)
            behaviours[mutant] += hash((draw, digest))  # a sum, because their order does not count
    mutants = defaultdict[Subject, dict[str, Sequence[Ruled]]](dict)
    for (mutant, situation), listed in flights.items():
        mutants[subjects[mutant]][situation] = sorted(listed, key=_seed)
    return Rulings(tuple(baselines), dict(mutants), frozenset(draws), behaviours)


_seed = itemgetter(0)


@dataclass(frozen=True, slots=True)
class JudgedFlight:
    """A mutant's flight, compared with its baseline.

    Attributes:
        outcome: outcome of the flight.
        baseline: baseline of the same situation and seed; None without a valid one.
        ruling: result of the comparison.
    """

    outcome: Outcome
    baseline: Outcome | None
    ruling: Ruling

    @property
    def status(self) -> Status:
        """Highest rung that the fault reached."""
        return self.ruling.status

    @property
    def revealed(self) -> tuple[str, ...]:
        """Safety requirements that the flight violates and the baseline held until then, earliest first."""
        return self.ruling.revealed

    @property
    def operability_revealed(self) -> tuple[str, ...]:
        """Operability requirements that the flight violates and the baseline held until then, earliest first."""
        return self.ruling.operability_revealed


def flight_of(outcome: Outcome, baseline: Outcome | None) -> JudgedFlight:
    """Compare a mutant's flight with the baseline of its situation and seed; invalid without a valid baseline."""
    return _beside(outcome, counting(baseline))


def flights_of(outcomes: Iterable[Outcome]) -> list[JudgedFlight]:
    """Compare every flight of a mutant (PLACEBO included) with its baseline, in the given order."""
    return list(each_flight(*apart(outcomes)))


def each_flight(baselines: Iterable[Outcome], flown: Iterable[Outcome]) -> Iterator[JudgedFlight]:
    """The same one by one, of flights of mutants beside their baselines."""
    known = _counting(baselines)
    return (_beside(outcome, known.get((outcome.situation, outcome.seed))) for outcome in flown)


def _beside(outcome: Outcome, baseline: Baseline | None) -> JudgedFlight:
    ruling = rule(outcome, baseline)
    return JudgedFlight(outcome, None if baseline is None or ruling is INVALID else baseline.outcome, ruling)


def baselines_of(outcomes: Iterable[Outcome]) -> dict[tuple[str, int], Outcome]:
    """The baselines by situation and seed."""
    return {(outcome.situation, outcome.seed): outcome for outcome in outcomes if outcome.subject.id == BASELINE}


def apart(outcomes: Iterable[Outcome]) -> tuple[list[Outcome], list[Outcome]]:
    """Split outcomes into baselines and flights of mutants (PLACEBO included), each in the given order."""
    listed = list(outcomes)
    clean = [outcome for outcome in listed if outcome.subject.id == BASELINE]
    return clean, [outcome for outcome in listed if outcome.subject.id != BASELINE]


APART_M = 0.001
"""Distance of two positions at which two tracks part [m]; a track of single floats resolves 1e-5 m in a mine."""
_TIME, _PLACE = TRACK_COLUMNS.index("elapsed_s"), slice(TRACK_COLUMNS.index("x_m"), TRACK_COLUMNS.index("z_m") + 1)


@dataclass(frozen=True)
class Facts:
    """What a campaign says of a flight.

    Attributes:
        status: beside its baseline of the same platform; of a baseline `held`, `violated` or `invalid`.
        ending: how the flight ended; empty when invalid.
        violated: the violated requirements, in the study's order.
    """

    status: str
    ending: str
    violated: tuple[str, ...]

    def __str__(self) -> str:
        return ", ".join(filter(None, (f"{self.status} {' '.join(self.violated)}".strip(), self.ending)))


@dataclass(frozen=True)
class Agreement:
    """What two sets of outcomes say of the flights that both have.

    Attributes:
        equal: flights with equal digests.
        bits: flights with other digests and the same facts.
        facts: flights with other facts, with the facts of the first set and of the second set.
    """

    equal: tuple[str, ...]
    bits: tuple[str, ...]
    facts: Mapping[str, tuple[Facts, Facts]]

    def named(self, most: int = 3) -> str:
        """The first `most` flights with other facts, each with its facts, and the number of the others."""
        told = [f"{name} ({second} here, {first} there)" for name, (first, second) in self.facts.items()]
        return ", ".join(told[:most]) + (f" and {len(told) - most} more" if len(told) > most else "")


def digests(outcome: Outcome) -> tuple[str, str]:
    """The digests that decide whether two flights are equal, bit for bit."""
    return outcome.digest, outcome.perceived_digest


def facts_of(outcomes: Iterable[Outcome]) -> dict[str, Facts]:
    """The facts of each flight by name; a mutant is judged beside its baseline among the same `outcomes`."""
    listed = list(outcomes)
    statuses = {flight.outcome.name: flight.status.value for flight in flights_of(listed)}
    return {
        outcome.name: Facts(
            baseline_status(outcome) if outcome.mutant == BASELINE else statuses[outcome.name],
            outcome.ending,
            tuple(reading.requirement for reading in outcome.readings if reading.violated),
        )
        for outcome in listed
    }


def parting_s(first: bytes, second: bytes) -> float | None:
    """The first time at which two tracks are more than `APART_M` apart; None if they never are [s from take-off]."""
    for one, other in zip(unpack_track(first), unpack_track(second), strict=False):
        if math.dist(one[_PLACE], other[_PLACE]) > APART_M:
            return one[_TIME]
    return None


def in_step(first: bytes, second: bytes) -> bool:
    """Whether two tracks have samples at the same times as long as both last."""
    pairs = zip(unpack_track(first), unpack_track(second), strict=False)
    return all(one[_TIME] == other[_TIME] for one, other in pairs)


def agreement(first: Iterable[Outcome], second: Iterable[Outcome]) -> Agreement:
    """Compare the valid flights that both sets have, in the order of `second`; each set has its own baselines.

    The status of a mutant is compared only where both sets have a valid baseline of its situation and seed.
    """
    ours, theirs = list(first), list(second)
    known = {outcome.name: outcome for outcome in ours if not outcome.invalid}
    mine, other = facts_of(ours), facts_of(theirs)
    equal, bits, facts = [], [], {}
    for outcome in theirs:
        if outcome.invalid or outcome.name not in known:
            continue
        one, two = mine[outcome.name], other[outcome.name]
        judged = Status.INVALID.value not in (one.status, two.status)
        if digests(known[outcome.name]) == digests(outcome):
            equal.append(outcome.name)
        elif (one.ending, one.violated) == (two.ending, two.violated) and (one.status == two.status or not judged):
            bits.append(outcome.name)
        else:
            facts[outcome.name] = one, two
    return Agreement(tuple(equal), tuple(bits), facts)
