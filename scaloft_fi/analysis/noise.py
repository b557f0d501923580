"""The noise of a stack that is not deterministic: how far flights of one situation and seed lie apart.

The simulator repeats its bits for a situation and seed, so two such flights of the same drone differ by what their
stack did.  PLACEBO alters nothing: its flight beside the baseline of the same situation and seed is such a pair.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from scaloft_fi.judge.outcome import BASELINE, PLACEBO, Outcome
from scaloft_fi.judge.requirement import Kind, measured_rho
from scaloft_fi.judge.status import baselines_of


@dataclass(frozen=True)
class Noise:
    """The noise of the robustness of one requirement, in its unit.

    Attributes:
        requirement: its id.
        pairs: pairs of flights of one situation and seed that both measure it.
        stack: standard deviation of one flight by what the stack did alone: the root mean square of the differences,
            divided by the root of two; None without a pair.
        seeds: standard deviation between the seeds of a situation, by sensors and stack together, pooled over the
            situations; None where no situation has two baselines.
        apart: pairs of which one flight violates it and the other one holds it.
    """

    requirement: str
    pairs: int
    stack: float | None
    seeds: float | None
    apart: int


def noise_of(outcomes: Iterable[Outcome]) -> tuple[Noise, ...]:
    """The noise of each safety and operability requirement, in the study's order; empty without a valid baseline."""
    listed = [outcome for outcome in outcomes if not outcome.invalid]
    known = baselines_of(listed)
    pairs = [
        (known[outcome.situation, outcome.seed], outcome)
        for outcome in listed
        if outcome.mutant == PLACEBO and (outcome.situation, outcome.seed) in known
    ]
    baselines = [outcome for outcome in listed if outcome.mutant == BASELINE]
    names = {r.requirement: None for o in baselines for r in o.readings if r.kind is not Kind.REPORTED}
    return tuple(_noise(name, pairs, baselines) for name in names)


def _noise(name: str, pairs: Sequence[tuple[Outcome, Outcome]], baselines: Sequence[Outcome]) -> Noise:
    both = [(_rho(name, first), _rho(name, second)) for first, second in pairs]
    squares = [(one - other) ** 2 for one, other in both if one is not None and other is not None]
    by_situation: dict[str, list[float]] = {}
    for outcome in baselines:
        rho = _rho(name, outcome)
        if rho is not None:
            by_situation.setdefault(outcome.situation, []).append(rho)
    return Noise(
        requirement=name,
        pairs=len(squares),
        stack=math.sqrt(sum(squares) / len(squares) / 2.0) if squares else None,
        seeds=_pooled(by_situation.values()),
        apart=sum(_violates(name, first) != _violates(name, second) for first, second in pairs),
    )


def _pooled(groups: Iterable[Sequence[float]]) -> float | None:
    """The standard deviation within groups; None where none has two numbers."""
    squares, freedom = 0.0, 0
    for group in groups:
        mean = sum(group) / len(group)
        squares += sum((one - mean) ** 2 for one in group)
        freedom += len(group) - 1
    return math.sqrt(squares / freedom) if freedom else None


def _rho(name: str, outcome: Outcome) -> float | None:
    measured = next(_measured(name, outcome), None)
    return measured if measured is not None and math.isfinite(measured) else None


def _measured(name: str, outcome: Outcome) -> Iterator[float | None]:
    return (measured_rho(reading) for reading in outcome.readings if reading.requirement == name)


def _violates(name: str, outcome: Outcome) -> bool:
    return any(violation.requirement == name for violation in outcome.violations)
