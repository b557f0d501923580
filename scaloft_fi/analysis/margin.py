"""Margins: the smallest magnitude of a fault that is killed, as an interval, from whatever was flown.

What a ladder, or a search between its rungs, says of one fault in one situation.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from enum import StrEnum

from scaloft_fi.analysis.scoring.detection import Detection
from scaloft_fi.analysis.scoring.mutant_score import MutantScore, Result
from scaloft_fi.analysis.scoring.score import Score
from scaloft_fi.hazop.cell import CellStatus, Fault, Magnitude
from scaloft_fi.hazop.matrix import Matrix
from scaloft_fi.hazop.severity import Worse, neutral, worse
from scaloft_fi.judge.flights import apart
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.judge.requirement import Kind
from scaloft_fi.judge.robustness import told_rho
from scaloft_fi.mutants.mutant import parse, split_magnitude

RELATIVE = 0.1
"""An interval no wider than a tenth of its severe end is told as one number, and is what a search ends at."""


class Answer(StrEnum):
    """What the flights of one magnitude in one situation say."""

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


FAILING = (Answer.KILLED, Answer.SEEN)
"""What a search takes for the severe side of the threshold."""


@dataclass(frozen=True)
class Scale:
    """The magnitudes of a fault in the order of their severity.

    Attributes:
        unit: of the magnitudes.
        sign: +1 where larger is worse, -1 where smaller is.
        neutral: the magnitude at which nothing is wrong: it survives without being flown; None where none is known.
    """

    unit: str
    sign: int = 1
    neutral: float | None = None

    @classmethod
    def of(cls, magnitude: Magnitude) -> Scale | None:
        """The scale of a ladder; None where it has no order."""
        direction = worse(magnitude)
        if direction is Worse.UNORDERED:
            return None
        return cls(magnitude.unit, 1 if direction is Worse.LARGER else -1, neutral(magnitude))

    def severity(self, magnitude: float) -> float:
        """Sort key: mild before severe."""
        return self.sign * magnitude

    def said(self, magnitude: float) -> str:
        """A magnitude with its unit.

        >>> Scale("s").said(0.5)
        '0.5 s'
        """
        return f"{magnitude:g} {self.unit}".rstrip()

    def close(self, survives: float, kills: float) -> bool:
        """Whether the interval is narrow beside the severe end's distance from no fault at all."""
        size = abs(kills - self.neutral) if self.neutral is not None else abs(kills)
        return math.isfinite(kills) and abs(kills - survives) <= RELATIVE * size * (1 + 1e-9)


@dataclass(frozen=True)
class Tried:
    """One magnitude in one situation.

    Attributes:
        magnitude: in the scale's unit.
        answer: what its flights say together.
        flown: flights that count.
        requirements: what kills the mutant here, or is seen to be violated.
        violated: per requirement, the flights that violate it, where any does.
        rho: the least robustness of each requirement over the flights that put it to the test, in its own unit.
        seeds: flown.
        needed: of `seen`, the number of seeds that would decide if it goes on; None where none would.
        anew: whether that takes a campaign of its own.
    """

    magnitude: float
    answer: Answer
    flown: int = 0
    requirements: tuple[str, ...] = ()
    violated: tuple[tuple[str, int], ...] = ()
    rho: tuple[tuple[str, float], ...] = ()
    seeds: frozenset[int] = frozenset()
    needed: int | None = None
    anew: bool = False


@dataclass(frozen=True)
class Margin:
    """The threshold of a fault in a situation, or the lowest of several.

    Attributes:
        scale: of its magnitudes.
        survives: the severest magnitude below `end` that survives; None where none is known.
        kills: the mildest magnitude that is killed; None where none is.
        seen: the mildest magnitude, below `kills`, of which most flights violate without a verdict; None without one.
        again: magnitudes that survive although a milder one is killed or seen: the response is not monotone.
        tried: every magnitude flown, mild to severe.
        situations: keys of those it speaks of.
        shown: whether any magnitude was killed, seen or put to the test; else nothing is told of the threshold.
    """

    scale: Scale
    survives: float | None
    kills: float | None
    seen: float | None = None
    again: tuple[float, ...] = ()
    tried: tuple[Tried, ...] = ()
    situations: tuple[str, ...] = ()
    shown: bool = True

    @property
    def end(self) -> float | None:
        """The mildest magnitude that is killed or seen: what a search takes for the severe end of the interval."""
        return self.kills if self.seen is None else self.seen

    @property
    def told(self) -> bool:
        """Whether the flights say anything of the threshold."""
        return self.shown and (self.survives is not None or self.end is not None)

    def __str__(self) -> str:
        """The threshold in a cell of a table; `!` where the response is not monotone.

        >>> s = Scale("s", 1, 0.0)
        >>> [str(Margin(s, *ends)) for ends in ((1.3, 1.4), (1.0, 3.0), (5.0, None), (None, 0.5), (None, None))]
        ['1.4 s', '1-3 s', '> 5 s', '<= 0.5 s', '?']
        >>> str(Margin(Scale("m", -1), 0.1, None)), str(Margin(s, 1.0, 3.0, again=(5.0,)))
        ('< 0.1 m', '1-3 s !')
        >>> str(Margin(s, 1.0, None, 3.0)), str(Margin(s, 0.5, 3.0, 1.0))
        ('seen 1-3 s', '0.5-3 s')
        """
        if not self.told:
            return "?"
        beyond, within = (">", "<=") if self.scale.sign > 0 else ("<", ">=")
        severe = self.kills if self.kills is not None else self.seen
        if severe is None:
            text = f"{beyond} {self.scale.said(self.survives or 0.0)}"
        elif self.survives is None:
            text = f"{within} {self.scale.said(severe)}"
        elif self.scale.close(self.survives, severe):
            text = self.scale.said(severe)
        else:
            text = f"{self.survives:g}-{self.scale.said(severe)}"
        return "seen " * (self.kills is None and self.seen is not None) + text + " !" * bool(self.again)


@dataclass(frozen=True)
class Subject:
    """A fault of a cell as it is shifted in time: what has one margin in each situation."""

    cell: str
    unit: str
    phase_s: float = 0.0

    def __str__(self) -> str:
        """As in an id, without the magnitude."""
        return self.cell + f"#{self.phase_s:g}s" * bool(self.phase_s)

    def at(self, magnitude: str) -> str:
        """The canonical id of the mutant at a magnitude as an id writes it."""
        return f"{self.cell}@{magnitude}" + f"#{self.phase_s:g}s" * bool(self.phase_s)


def margin_of(scale: Scale, tried: Iterable[Tried], situation: str = "") -> Margin:
    """What the flights of one situation say of the threshold there."""
    told = sorted(tried, key=lambda entry: scale.severity(entry.magnitude))
    failing = [entry for entry in told if entry.answer in FAILING]
    kills = next((entry.magnitude for entry in failing if entry.answer is Answer.KILLED), None)
    end = failing[0].magnitude if failing else None
    survived = [entry.magnitude for entry in told if entry.answer in (Answer.SURVIVED, Answer.HARMLESS)]
    milder = [m for m in survived if end is None or scale.severity(m) < scale.severity(end)]
    return Margin(
        scale,
        survives=milder[-1] if milder else None,
        kills=kills,
        seen=None if end == kills else end,
        again=() if end is None else tuple(m for m in survived if scale.severity(m) > scale.severity(end)),
        tried=tuple(told),
        situations=(situation,) if situation else (),
        shown=bool(failing) or any(entry.answer is Answer.SURVIVED for entry in told),
    )


def lowest(margins: Iterable[Margin]) -> Margin | None:
    """The margin over several situations: the least magnitude killed in any of them; None when nothing is told.

    A situation whose threshold lies between `survives` and `kills` bounds the least one from above by `kills`; from
    below it is bounded by the mildest of the survivors.
    """
    told = [margin for margin in margins if margin.told]
    if not told:
        return None
    scale = told[0].scale
    kills = min((m.kills for m in told if m.kills is not None), key=scale.severity, default=None)
    seen = min((m.seen for m in told if m.seen is not None), key=scale.severity, default=None)
    if seen is not None and kills is not None and scale.severity(seen) >= scale.severity(kills):
        seen = None
    floors = [m.survives for m in told]
    survives = None
    if None not in floors:
        survives = min((floor for floor in floors if floor is not None), key=scale.severity)
    return Margin(
        scale,
        survives,
        kills,
        seen,
        tuple(sorted({m for margin in told for m in margin.again}, key=scale.severity)),
        situations=tuple(key for margin in told for key in margin.situations),
    )


def tried_in(
    outcomes: Iterable[Outcome], scored: Score, matrix: Matrix, kind: Kind = Kind.SAFETY
) -> Mapping[tuple[Subject, str], tuple[Tried, ...]]:
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
    found = defaultdict[tuple[Subject, str], list[Tried]](list)
    for mutant in (*scored.mutants, *scored.controls):
        name = parse(mutant.subject.id)
        magnitude, unit = split_magnitude(name.magnitude)
        if not name.magnitude or isinstance(magnitude, str) or name.cell not in matrix:
            continue
        names = scored.pool.requirements(kind)
        at_stake = set(names).intersection(matrix.cell(name.cell).requirements) or set(names)
        subject, detection = Subject(name.cell, unit, name.phase_s), detection_of(mutant, kind)
        for result in mutant.results:
            flights = counted[mutant.subject.id, result.situation]
            entry = _tried(magnitude, result, detection, at_stake, kind, flights)
            found[subject, result.situation].append(entry)
    return {key: tuple(entries) for key, entries in found.items()}


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
        answer = Answer.KILLED if detection.detected else Answer.SEEN
    elif not result.infected:
        answer = Answer.HARMLESS if result.reached else Answer.UNTESTED
    else:
        answer = Answer.SURVIVED if set(steady) & set(at_stake) else Answer.UNTESTED
    rho: dict[str, float] = {}
    for outcome in flights:
        for reading in outcome.readings:
            told = told_rho(reading)
            if told is not None:
                rho[reading.requirement] = min(told, rho.get(reading.requirement, math.inf))
    return Tried(
        magnitude,
        answer,
        result.flown,
        requirements,
        result.violated,
        tuple(rho.items()),
        frozenset(outcome.seed for outcome in flights),
        *((detection.needed, detection.anew) if answer is Answer.SEEN else ()),
    )


def subject_of(cell: str, fault: Fault, phase_s: float = 0.0) -> Subject:
    """The subject of a fault's margins."""
    return Subject(cell, fault.magnitude.unit if fault.magnitude else "", phase_s)


def margins(
    outcomes: Iterable[Outcome], scored: Score, matrix: Matrix, kind: Kind = Kind.SAFETY
) -> Mapping[Subject, tuple[Margin, ...]]:
    """The margins of every fault that has an order, by situation, from stored outcomes alone; as `tried_in`."""
    scales = {
        (cell.name, fault.magnitude.unit): Scale.of(fault.magnitude)
        for cell in matrix
        if cell.status is not CellStatus.NOT_MEANINGFUL
        for fault in cell.faults
        if fault.magnitude
    }
    found = defaultdict[Subject, list[Margin]](list)
    for (subject, situation), entries in tried_in(outcomes, scored, matrix, kind).items():
        scale = scales.get((subject.cell, subject.unit))
        if scale is not None:
            found[subject].append(margin_of(scale, entries, situation))
    return {subject: tuple(listed) for subject, listed in found.items()}
