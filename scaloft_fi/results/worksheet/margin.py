"""Safety margins: the smallest magnitude of a fault that kills, as an interval, from whatever was flown.

`mutation.md`'s "severity threshold": what a ladder, or a search between its rungs, says of one fault in one situation.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum

from scaloft_fi.hazop.cell import CellStatus, Fault, Magnitude
from scaloft_fi.hazop.matrix import Matrix
from scaloft_fi.hazop.severity import Worse, neutral, worse
from scaloft_fi.mutants.mutant import PLACEBO, parse, split_magnitude
from scaloft_fi.results.flights import Flight, flights_of
from scaloft_fi.results.outcome import BASELINE, Outcome
from scaloft_fi.results.requirement import Kind
from scaloft_fi.results.status import Status

RELATIVE = 0.1
"""An interval no wider than a tenth of its killing end is told as one number, and is what a search ends at."""


class Answer(StrEnum):
    """What the flights of one magnitude in one situation say."""

    KILLED = "killed"
    """A flight of some seed is killed: kills are counted as they are observed."""
    SURVIVED = "survived"
    """None is, and the fault was put to the test."""
    HARMLESS = "harmless"
    """Samples came, and none was changed: a survival, where another magnitude changes some."""
    UNTESTED = "untested"
    """None is, but no sample came, or no baseline held to its end a requirement that the cell puts at risk."""


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
        """Whether the interval is narrow beside the killing end's distance from no fault at all."""
        size = abs(kills - self.neutral) if self.neutral is not None else abs(kills)
        return math.isfinite(kills) and abs(kills - survives) <= RELATIVE * size * (1 + 1e-9)


@dataclass(frozen=True)
class Tried:
    """One magnitude in one situation.

    Attributes:
        magnitude: in the scale's unit.
        answer: what its flights say together.
        kills, flown: flights killed, flights that count.
        requirements: what killed, earliest first.
        rho: the least robustness over the flights of each requirement that counts, in the requirement's unit.
        seeds: flown.
    """

    magnitude: float
    answer: Answer
    kills: int = 0
    flown: int = 0
    requirements: tuple[str, ...] = ()
    rho: tuple[tuple[str, float], ...] = ()
    seeds: frozenset[int] = frozenset()


@dataclass(frozen=True)
class Margin:
    """The threshold of a fault in a situation, or the lowest of several.

    Attributes:
        scale: of its magnitudes.
        survives: the severest magnitude below `kills` that survives; None where none is known.
        kills: the mildest magnitude that kills; None where none does.
        again: magnitudes that survive although a milder one kills: the response is not monotone.
        tried: every magnitude flown, mild to severe.
        situations: keys of those it speaks of.
        shown: whether any magnitude killed or was put to the test; else nothing is told of the threshold.
    """

    scale: Scale
    survives: float | None
    kills: float | None
    again: tuple[float, ...] = ()
    tried: tuple[Tried, ...] = ()
    situations: tuple[str, ...] = ()
    shown: bool = True

    @property
    def told(self) -> bool:
        """Whether the flights say anything of the threshold."""
        return self.shown and (self.survives is not None or self.kills is not None)

    def __str__(self) -> str:
        """The threshold in a cell of a table; `!` where the response is not monotone.

        >>> s = Scale("s", 1, 0.0)
        >>> [str(Margin(s, *ends)) for ends in ((1.3, 1.4), (1.0, 3.0), (5.0, None), (None, 0.5), (None, None))]
        ['1.4 s', '1-3 s', '> 5 s', '<= 0.5 s', '?']
        >>> str(Margin(Scale("m", -1), 0.1, None)), str(Margin(s, 1.0, 3.0, (5.0,)))
        ('< 0.1 m', '1-3 s !')
        """
        if not self.told:
            return "?"
        beyond, within = (">", "<=") if self.scale.sign > 0 else ("<", ">=")
        if self.kills is None:
            text = f"{beyond} {self.scale.said(self.survives or 0.0)}"
        elif self.survives is None:
            text = f"{within} {self.scale.said(self.kills)}"
        elif self.scale.close(self.survives, self.kills):
            text = self.scale.said(self.kills)
        else:
            text = f"{self.survives:g}-{self.scale.said(self.kills)}"
        return text + (" !" if self.again else "")


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
    killed = [entry.magnitude for entry in told if entry.answer is Answer.KILLED]
    survived = [entry.magnitude for entry in told if entry.answer in (Answer.SURVIVED, Answer.HARMLESS)]
    shown = any(entry.answer in (Answer.KILLED, Answer.SURVIVED) for entry in told)
    kills = killed[0] if killed else None
    milder = [m for m in survived if kills is None or scale.severity(m) < scale.severity(kills)]
    again = () if kills is None else tuple(m for m in survived if scale.severity(m) > scale.severity(kills))
    survives = milder[-1] if milder else None
    return Margin(scale, survives, kills, again, tuple(told), (situation,) if situation else (), shown)


def lowest(margins: Iterable[Margin]) -> Margin | None:
    """The margin over several situations: the least magnitude that kills in any of them; None when nothing is told.

    A situation whose threshold lies between `survives` and `kills` bounds the least one from above by `kills`; from
    below it is bounded by the mildest of the survivors.
    """
    told = [margin for margin in margins if margin.told]
    if not told:
        return None
    scale = told[0].scale
    kills = min((m.kills for m in told if m.kills is not None), key=scale.severity, default=None)
    floors = [m.survives for m in told]
    survives = None
    if None not in floors:
        survives = min((floor for floor in floors if floor is not None), key=scale.severity)
    return Margin(
        scale,
        survives,
        kills,
        tuple(sorted({m for margin in told for m in margin.again}, key=scale.severity)),
        situations=tuple(key for margin in told for key in margin.situations),
    )


def tried_in(
    outcomes: Iterable[Outcome], matrix: Matrix, kind: Kind = Kind.SAFETY
) -> Mapping[tuple[Subject, str], tuple[Tried, ...]]:
    """Every number of a magnitude that was flown, by fault and situation, in no particular order.

    Args:
        outcomes: of a campaign.
        matrix: of the study.
        kind: of the requirements whose violation kills.
    """
    listed: dict[tuple[Subject, str, float], list[Flight]] = {}
    for flight in flights_of(outcomes):
        id_ = flight.outcome.mutant
        if id_ in (BASELINE, PLACEBO.id) or flight.status is Status.INVALID:
            continue
        name = parse(id_)
        magnitude, unit = split_magnitude(name.magnitude)
        if name.magnitude and not isinstance(magnitude, str) and name.cell in matrix:
            key = Subject(name.cell, unit, name.phase_s), flight.outcome.situation, magnitude
            listed.setdefault(key, []).append(flight)
    found: dict[tuple[Subject, str], list[Tried]] = {}
    for (subject, situation, magnitude), flights in listed.items():
        at_risk = matrix.cell(subject.cell).requirements
        found.setdefault((subject, situation), []).append(_tried(magnitude, flights, at_risk, kind))
    return {key: tuple(entries) for key, entries in found.items()}


def kills_of(flight: Flight, kind: Kind) -> tuple[str, ...]:
    """The requirements of a kind that kill a flight, earliest first."""
    return flight.kills if kind is Kind.SAFETY else flight.operability_kills


def _tried(magnitude: float, flights: Sequence[Flight], at_risk: Collection[str], kind: Kind) -> Tried:
    killed = [flight for flight in flights if kills_of(flight, kind)]
    infecting = [flight for flight in flights if flight.status.infected]
    if killed:
        answer = Answer.KILLED
    elif not infecting:
        reached = any(flight.status is Status.NOT_INFECTED for flight in flights)
        answer = Answer.HARMLESS if reached else Answer.UNTESTED
    else:
        tested = any(_held(flight.baseline, at_risk, kind) for flight in infecting if flight.baseline)
        answer = Answer.SURVIVED if tested else Answer.UNTESTED
    rho: dict[str, float] = {}
    for flight in flights:
        for reading in flight.outcome.readings:
            rho[reading.requirement] = min(reading.rho, rho.get(reading.requirement, math.inf))
    return Tried(
        magnitude,
        answer,
        len(killed),
        len(flights),
        tuple(dict.fromkeys(name for flight in killed for name in kills_of(flight, kind))),
        tuple(rho.items()),
        frozenset(flight.outcome.seed for flight in flights),
    )


def _held(baseline: Outcome, at_risk: Collection[str], kind: Kind) -> bool:
    """Whether a requirement of the kind that the cell puts at risk (any, where it names none) was held to its end."""
    judged = [reading for reading in baseline.readings if reading.kind is kind]
    named = [reading for reading in judged if reading.requirement in at_risk]
    return any(not (reading.violated or reading.open) for reading in named or judged)


def subject_of(cell: str, fault: Fault, phase_s: float = 0.0) -> Subject:
    """The subject of a fault's margins."""
    return Subject(cell, fault.magnitude.unit if fault.magnitude else "", phase_s)


def margins(
    outcomes: Iterable[Outcome], matrix: Matrix, kind: Kind = Kind.SAFETY
) -> Mapping[Subject, tuple[Margin, ...]]:
    """The margins of every fault that has an order, by situation, from stored outcomes alone; as `tried_in`."""
    tried = tried_in(outcomes, matrix, kind)
    scales = {
        (cell.name, fault.magnitude.unit): Scale.of(fault.magnitude)
        for cell in matrix
        if cell.status is not CellStatus.NOT_MEANINGFUL
        for fault in cell.faults
        if fault.magnitude
    }
    found: dict[Subject, list[Margin]] = {}
    for (subject, situation), entries in tried.items():
        scale = scales.get((subject.cell, subject.unit))
        if scale is not None:
            found.setdefault(subject, []).append(margin_of(scale, entries, situation))
    return {subject: tuple(listed) for subject, listed in found.items()}
