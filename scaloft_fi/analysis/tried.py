"""What was tried of a fault: every magnitude that was flown, situation by situation, and how its flights reacted."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from enum import StrEnum

from scaloft_fi.analysis.scoring.detection import Detection
from scaloft_fi.analysis.scoring.mutant_score import MutantScore, Result
from scaloft_fi.analysis.scoring.score import Score
from scaloft_fi.hazop.matrix import Fault, Matrix
from scaloft_fi.hazop.name import Name, parse, split_magnitude
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.judge.requirement import Kind, measured_rho
from scaloft_fi.judge.status import apart


class Reaction(StrEnum):
    """What the flights of one magnitude in one situation show."""

    KILLED = "killed"
    """The mutant is detected, over all its situations, and most flights here violate a steady requirement."""
    SEEN = "seen"
    """Most flights here violate a steady requirement, but all its flights are too few to call the mutant detected."""
    SURVIVED = "survived"
    """Neither, and a requirement that the cell puts at risk is steady here."""
    HARMLESS = "harmless"
    """Samples came, and none was changed: a survival, where another magnitude changes some."""
    UNTESTED = "untested"
    """No sample came, or no requirement that the cell puts at risk is steady here."""


FAILING = (Reaction.KILLED, Reaction.SEEN)
"""What a search takes for the strong side of the threshold."""


@dataclass(frozen=True)
class Tried:
    """One magnitude in one situation.

    Attributes:
        magnitude: in the scale's unit.
        reaction: what its flights show together.
        flown: flights that count.
        requirements: what kills the mutant here, or is seen to be violated.
        violated: per requirement, the flights that violate it, where any does.
        rho: the least robustness of each requirement over the flights that put it to the test, in its own unit.
        seeds: flown.
        needed: of `seen`, the number of seeds that would decide if it goes on; None where none would.
        anew: whether that takes a campaign of its own.
    """

    magnitude: float
    reaction: Reaction
    flown: int = 0
    requirements: tuple[str, ...] = ()
    violated: tuple[tuple[str, int], ...] = ()
    rho: tuple[tuple[str, float], ...] = ()
    seeds: frozenset[int] = frozenset()
    needed: int | None = None
    anew: bool = False


@dataclass(frozen=True)
class PhasedFault:
    """A fault of a cell with its shift in time [s], or its event: what has one margin in each situation."""

    cell: str
    unit: str
    phase_s: float = 0.0
    event: str = ""

    def __str__(self) -> str:
        """As in an id, without the magnitude."""
        return self.at("")

    def at(self, magnitude: str) -> str:
        """The canonical id of the mutant at a magnitude as an id writes it."""
        guideword, parameter = self.cell.split("-")
        return str(Name(guideword, parameter, magnitude, self.phase_s, self.event))


def phased_fault(cell: str, fault: Fault, phase_s: float = 0.0, event: str = "") -> PhasedFault:
    """A fault of a cell, shifted by `phase_s`, or at an event."""
    return PhasedFault(cell, fault.magnitude.unit if fault.magnitude else "", phase_s, event)


def tried_in(
    outcomes: Iterable[Outcome], scored: Score, matrix: Matrix, kind: Kind = Kind.SAFETY
) -> Mapping[tuple[PhasedFault, str], tuple[Tried, ...]]:
    """Every number of a magnitude that was flown, by fault and situation, in no particular order.

    Args:
        outcomes: of a campaign, which the robustness is read from.
        scored: their score.
        matrix: of the study.
        kind: of the requirements whose violation kills.
    """
    clean, flown = apart(outcomes)
    draws = {(baseline.situation, baseline.seed) for baseline in clean if not baseline.invalid}
    counted = defaultdict[tuple[str, str], list[Outcome]](list)
    for outcome in flown:
        if not outcome.invalid and (outcome.situation, outcome.seed) in draws:
            counted[outcome.mutant, outcome.situation].append(outcome)
    tried = defaultdict[tuple[PhasedFault, str], list[Tried]](list)
    for mutant in (*scored.mutants, *scored.controls):
        name = parse(mutant.subject.id)
        magnitude, unit = split_magnitude(name.magnitude)
        if not name.magnitude or isinstance(magnitude, str) or name.cell not in matrix:
            continue
        names = scored.pool.requirements(kind)
        at_stake = set(names).intersection(matrix.cell(name.cell).requirements) or set(names)
        fault, detection = PhasedFault(name.cell, unit, name.phase_s, name.event), detection_of(mutant, kind)
        for result in mutant.results:
            flights = counted[mutant.subject.id, result.situation]
            entry = _tried(magnitude, result, detection, at_stake, kind, flights)
            tried[fault, result.situation].append(entry)
    return {key: tuple(entries) for key, entries in tried.items()}


def detection_of(mutant: MutantScore, kind: Kind) -> Detection:
    """The verdict on a mutant by requirements of a kind."""
    return mutant.safety if kind is Kind.SAFETY else mutant.operability


def steady_of(result: Result, kind: Kind) -> tuple[str, ...]:
    """The requirements of a kind that put the mutant to the test in a situation."""
    return result.steady if kind is Kind.SAFETY else result.steady_operability


def _tried(
    magnitude: float,
    result: Result,
    detection: Detection,
    at_stake: Collection[str],
    kind: Kind,
    flights: Iterable[Outcome],
) -> Tried:
    steady, violated = steady_of(result, kind), dict(result.violated)
    requirements = tuple(name for name in steady if 2 * violated.get(name, 0) > result.flown)
    if requirements:
        reaction = Reaction.KILLED if detection.detected else Reaction.SEEN
    elif not result.infected:
        reaction = Reaction.HARMLESS if result.reached else Reaction.UNTESTED
    else:
        reaction = Reaction.SURVIVED if set(steady) & set(at_stake) else Reaction.UNTESTED
    rho: dict[str, float] = {}
    for outcome in flights:
        for reading in outcome.readings:
            measured = measured_rho(reading)
            if measured is not None:
                rho[reading.requirement] = min(measured, rho.get(reading.requirement, math.inf))
    return Tried(
        magnitude,
        reaction,
        result.flown,
        requirements,
        result.violated,
        tuple(rho.items()),
        frozenset(outcome.seed for outcome in flights),
        *((detection.needed, detection.anew) if reaction is Reaction.SEEN else ()),
    )
