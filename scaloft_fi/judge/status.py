"""What a flight's status says: the stage of reach, infect, propagate, reveal where the fault stopped."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from enum import StrEnum
from functools import cache
from operator import attrgetter
from typing import NamedTuple

from scaloft_fi.judge.outcome import Outcome, Violation
from scaloft_fi.judge.requirement import Kind, Reading


class Status(StrEnum):
    """Status of a flight: the stage where the fault stopped; `stage` orders them."""

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
    REVEALED = "revealed"
    """A safety requirement is violated that the baseline of the same situation and seed held up to that moment: an
    observation, which another seed may not repeat."""

    __hash__ = str.__hash__
    """As that of its text; statuses are counted by the hundred thousand."""

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
    """What a flight beside its baseline comes to.  Few differ, and equal ones are one object, so they can be counted.

    Attributes:
        status: where the fault stopped.
        revealed: safety requirements that it violates and the baseline held up to that moment, earliest first.
        operability_revealed: the same of operability requirements.
        violated: requirements that the flight violates, whatever the baseline does; of a flight that counts.
    """

    status: Status
    revealed: tuple[str, ...] = ()
    operability_revealed: tuple[str, ...] = ()
    violated: tuple[str, ...] = ()


_ruling = cache(Ruling)
INVALID = _ruling(Status.INVALID)
"""Of a flight that does not count."""
_PLAIN = {status: _ruling(status) for status in Status}
"""Of flights that violate nothing."""


class Baseline:
    """What there is to know of a baseline that counts, found once for all the flights beside it.

    Args:
        outcome: of the baseline.
    """

    def __init__(self, outcome: Outcome) -> None:
        self.outcome = outcome
        self._limits = {reading.requirement: _limit(reading, outcome) for reading in outcome.readings}

    def rule(self, carried: int, altered: int, digest: str, violations: Sequence[Violation]) -> Ruling:
        """What a flight that counts comes to, by what an outcome has of these names."""
        if altered == 0:
            status = Status.NOT_INFECTED if carried else Status.NOT_REACHED
        else:
            status = Status.MASKED if digest == self.outcome.digest else Status.SURVIVED
        if not violations:
            return _PLAIN[status]
        violated = tuple([violation.requirement for violation in violations])
        if status is not Status.SURVIVED:
            return _ruling(status, (), (), violated)
        told = self.told(violations)
        revealed, operability = named(told, Kind.SAFETY), named(told, Kind.OPERABILITY)
        if revealed:
            status = Status.REVEALED
        elif any(violation.kind is Kind.SAFETY for violation in violations):
            status = Status.BASELINE_RED
        return _ruling(status, revealed, operability, violated)

    def told(self, violations: Iterable[Violation]) -> list[Violation]:
        """The violations by which a flight is told from the baseline, earliest first.

        To violate sooner what the baseline violates too, on the same body, proves nothing: any change of the flight
        moves that moment.  Of a baseline that was cut short only what it flew counts.
        """
        limits = self._limits
        found = [
            violation
            for violation in violations
            if (limit := limits.get(violation.requirement))
            and violation.t_s <= limit.last_s
            and violation.struck != limit.struck
        ]
        if len(found) > 1:
            found.sort(key=_time)
        return found


class _Limit(NamedTuple):
    """By which violations of a requirement a flight is told from its baseline.

    last_s: those until then [s]; struck: but not those on this body, None for on whichever.
    """

    last_s: float
    struck: str | None


def _limit(reading: Reading, baseline: Outcome) -> _Limit:
    """What the baseline's reading of a requirement leaves to tell by."""
    if reading.violated_at_s is not None:
        struck = next((v.struck for v in baseline.violations if v.requirement == reading.requirement), "")
        return _Limit(math.nextafter(reading.violated_at_s, -math.inf), struck)
    return _Limit(baseline.duration_s if reading.open else math.inf, None)


_time = attrgetter("t_s")


def named(told: Sequence[Violation], kind: Kind) -> tuple[str, ...]:
    """The requirements of violations, of one kind."""
    return tuple([violation.requirement for violation in told if violation.kind is kind]) if told else ()


def counting(baseline: Outcome | None) -> Baseline | None:
    """A baseline to rule by, None when there is none that counts."""
    return None if baseline is None or baseline.invalid else Baseline(baseline)


def rule(outcome: Outcome, baseline: Baseline | None) -> Ruling:
    """What a mutant's flight comes to beside the baseline of its situation and seed; without one it is invalid."""
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
