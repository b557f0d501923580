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
        limits = self._limits
        new = [
            violation
            for violation in violations
            if (limit := limits.get(violation.requirement))
            and violation.t_s <= limit.last_s
            and violation.struck != limit.struck
        ]
        if len(new) > 1:
            new.sort(key=_time)
        return new


class _Limit(NamedTuple):
    """Condition for a new violation of a requirement.

    last_s: its time is at most this [s]; struck: it is not on this body; None = it may be on any body.
    """

    last_s: float
    struck: str | None


def _limit(reading: Reading, baseline: Outcome) -> _Limit:
    """The condition that follows from the baseline's reading of a requirement."""
    if reading.violated_at_s is not None:
        struck = next((v.struck for v in baseline.violations if v.requirement == reading.requirement), "")
        return _Limit(math.nextafter(reading.violated_at_s, -math.inf), struck)
    return _Limit(baseline.duration_s if reading.open else math.inf, None)


_time = attrgetter("t_s")


def _requirements(violations: Sequence[Violation], kind: Kind) -> tuple[str, ...]:
    """The violated requirements of one kind."""
    return tuple([violation.requirement for violation in violations if violation.kind is kind]) if violations else ()


def counting(baseline: Outcome | None) -> Baseline | None:
    """The prepared baseline; None without a valid one."""
    return None if baseline is None or baseline.invalid else Baseline(baseline)


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
