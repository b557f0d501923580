"""Survivors: what is known of one, what was tried of its fault, and the dispositions by which somebody accepts it.

A survivor is a mutant that the ratios count and that is not detected, or undecided: what is not decided is not shown.
A file of decisions instead of a percentage: a score may fall without notice when mutants are added, a survivor that
nobody has accepted may not.
"""

from __future__ import annotations

import math
from collections import Counter, defaultdict
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from datetime import date
from enum import StrEnum
from functools import cached_property
from typing import TYPE_CHECKING, Annotated

import numpy as np

from scaloft_fi.analysis.detection import Detection, Pool, State, Verdict
from scaloft_fi.analysis.roster import Ratio, Roster
from scaloft_fi.analysis.score import MutantScore, Result, Score, condition
from scaloft_fi.defaults import CAMPAIGN
from scaloft_fi.hazop.matrix import Fault, Matrix, Name, Worse, mild_to_strong, parse, split_magnitude, worse
from scaloft_fi.judge.outcome import TRACK_COLUMNS, Outcome, unpack_track
from scaloft_fi.judge.requirement import Compliance, Kind, Reading
from scaloft_fi.judge.space import Space
from scaloft_fi.judge.status import JudgedFlight, Status, apart, flights_of
from scaloft_fi.marks import About, Bounds, ByName
from scaloft_fi.mutants.catalogue import realise, source_of
from scaloft_fi.registry import grouped

if TYPE_CHECKING:
    from scaloft_fi.analysis.kill_matrix import KillMatrix, KillRow


@dataclass(frozen=True)
class Disposition:
    """An accepted survivor.

    Attributes:
        mutant: canonical id.
        owner: who accepted it and answers for it.
        reason: why it may survive.
        expires: the last day on which it holds.
        situations: keys of those where it may survive; empty = in all.
        place: file:line.
    """

    KEYS = ("mutant", "owner", "reason", "expires")
    mutant: str
    owner: str
    reason: str
    expires: date
    situations: tuple[str, ...] = ()
    place: str = field(default="", compare=False)


class Standing(StrEnum):
    """How a survivor, or a disposition, stands."""

    ACCEPTED = "accepted"
    OPEN = "open"
    """It survives and nobody accepted that."""
    UNCOVERED = "uncovered"
    """It survives in a situation that its disposition does not name."""
    EXPIRED = "expired"
    """The day of its disposition has passed."""
    STALE = "stale"
    """It is detected now: the disposition can go."""
    UNTESTED = "untested"
    """Accepted, but not put to the test."""

    @property
    def fails(self) -> bool:
        """Whether the ratchet does not let it pass."""
        return self in (Standing.OPEN, Standing.UNCOVERED, Standing.EXPIRED)


@dataclass(frozen=True)
class Judged:
    """A survivor beside its disposition.

    Attributes:
        mutant: canonical id.
        state: how it stands.
        surviving: keys of the situations that put it to the test, where it survives.
        disposition: None where there is none.
        verdict: on the mutant; None where it was not flown.
    """

    mutant: str
    state: Standing
    surviving: tuple[str, ...] = ()
    disposition: Disposition | None = None
    verdict: Verdict | None = None


def survives(mutant: MutantScore) -> bool:
    """Whether it is not detected though it was put to the test, or undecided."""
    return mutant.verdict in (Verdict.NOT_DETECTED, Verdict.UNDECIDED)


def judge(
    scored: Score, roster: Roster, dispositions: Iterable[Disposition], today: date | None = None
) -> tuple[Judged, ...]:
    """Every counted survivor, or mutant of which no flight counts, then every disposition, in the canonical order.

    Args:
        scored: of a campaign.
        roster: orders the dispositions.
        dispositions: of the study.
        today: by which expiry is judged; None = nothing expires.
    """
    known = {disposition.mutant: disposition for disposition in dispositions}
    flown = {mutant.subject.id: mutant for mutant in scored.mutants}
    counted = [mutant for mutant in scored.counted if survives(mutant) or not mutant.flown]
    names = dict.fromkeys([*(mutant.subject.id for mutant in counted), *sorted(known, key=roster.rank)])
    return tuple(_judged(name, flown.get(name), known.get(name), today) for name in names)


def accepted_survivors(
    scored: Score, roster: Roster, dispositions: Iterable[Disposition], today: date | None = None
) -> tuple[Disposition, ...]:
    """The survivors that the score counts and somebody accepted, in the canonical order; the arguments of `judge`.

    Without a pool nobody knows what survives, so there are none.
    """
    if not scored.pooled:
        return ()
    counted = {mutant.subject.id for mutant in scored.counted}
    return tuple(
        one.disposition
        for one in judge(scored, roster, dispositions, today)
        if one.disposition is not None and one.state is Standing.ACCEPTED and one.mutant in counted
    )


def score_without(scored: Score, accepted: Collection[Disposition]) -> Ratio:
    """Mutants detected, of those that `mutation_score` counts and nobody accepted as survivors."""
    return Ratio(scored.mutation_score.part, scored.mutation_score.whole - len(accepted))


def _judged(name: str, mutant: MutantScore | None, known: Disposition | None, today: date | None) -> Judged:
    surviving = tuple(r.situation for r in mutant.results if r.tested and not r.kills) if mutant else ()
    if known is None:
        state = Standing.OPEN
    elif mutant is not None and mutant.detected:
        state = Standing.STALE
    elif today is not None and today > known.expires:
        state = Standing.EXPIRED
    elif mutant is None or not survives(mutant):
        state = Standing.UNTESTED
    elif known.situations and set(surviving) - set(known.situations):
        state = Standing.UNCOVERED
    else:
        state = Standing.ACCEPTED
    return Judged(name, state, surviving, known, mutant.verdict if mutant else None)


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
        magnitude: in the fault's unit.
        reaction: what its flights show together.
        flown: flights that count.
        requirements: what kills the mutant here, or is seen to be violated.
        violated: by requirement.
        rho: the least robustness of each requirement over the flights that put it to the test, in its own unit.
        seeds: flown.
        needed: of `seen`, seeds that would decide; null: nothing to decide, or none would.
        anew: whether that takes a campaign of its own.
    """

    magnitude: Annotated[float, Bounds(infinite=True)]
    reaction: Reaction
    flown: int = 0
    requirements: tuple[str, ...] = ()
    violated: Annotated[tuple[tuple[str, Annotated[int, About("flights that violate it")]], ...], ByName()] = ()
    rho: tuple[tuple[str, float], ...] = ()
    seeds: frozenset[int] = frozenset()
    needed: int | None = None
    anew: bool = False


@dataclass(frozen=True)
class PhasedFault:
    """A fault of a cell: what has one margin in each situation.

    Attributes:
        cell: name of its cell.
        unit: unit of its magnitudes.
        phase_s: its shift in time [s].
        event: the event at which it strikes; empty for none.
    """

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
    counting = (one for one in flown if not one.invalid and (one.situation, one.seed) in draws)
    counted = grouped(counting, lambda one: (one.mutant, one.situation))
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
            tried[fault, result.situation].append(_tried(magnitude, result, detection, at_stake, kind, flights))
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
            measured = reading.robustness
            if measured is not None:
                rho[reading.requirement] = min(measured, rho.get(reading.requirement, math.inf))
    seeds = frozenset(outcome.seed for outcome in flights)
    tried = Tried(magnitude, reaction, result.flown, requirements, result.violated, tuple(rho.items()), seeds)
    return replace(tried, needed=detection.needed, anew=detection.anew) if reaction is Reaction.SEEN else tried


@dataclass(frozen=True)
class Background:
    """What is known of a mutant beforehand.

    Attributes:
        seam: where the fault is patched in.
        at_risk: requirements that the cell names.
        expected: why it is known to alter nothing in this grid; empty when that is not known.
        stronger: the canonical ids of the stronger rungs of its ladder, mildest first.
        laddered: whether the fault has a ladder with an order.
    """

    seam: str
    at_risk: tuple[str, ...] = ()
    expected: str = ""
    stronger: tuple[str, ...] = ()
    laddered: bool = False


def backgrounds(matrix: Matrix, ids: Iterable[str]) -> dict[str, Background]:
    """The background of each mutant.

    Raises:
        InputError: an id is none of the matrix's.
    """
    return {id_: _background(matrix, id_) for id_ in ids}


def _background(matrix: Matrix, id_: str) -> Background:
    mutant = realise(matrix, id_)
    cell = matrix.cell(mutant.cell)
    fault, rung = source_of(matrix, mutant)
    expected = fault.expects(rung)
    stronger = _stronger(fault, rung)
    return Background(
        seam=mutant.seam,
        at_risk=cell.requirements,
        expected=expected.reason if expected else "",
        stronger=tuple(cell.mutant_ids(fault, worse_rung)[0] for worse_rung in stronger),
        laddered=fault.magnitude is not None and worse(fault.magnitude) is not Worse.UNORDERED,
    )


def _stronger(fault: Fault, rung: float | str | None) -> list[float]:
    """The rungs of the ladder that are stronger than this one, mildest first; none where the ladder has no order."""
    if fault.magnitude is None or rung is None or isinstance(rung, str):
        return []
    sign = 1 if worse(fault.magnitude) is Worse.LARGER else -1
    return [other for other in mild_to_strong(fault.magnitude) if sign * other > sign * rung]


@dataclass(frozen=True)
class CampaignFacts:
    """The flights and scores, by mutant, and what the baselines and the other faults of a seam show."""

    space: Space
    pool: Pool
    scores: Mapping[str, MutantScore]
    flights: Mapping[str, Sequence[JudgedFlight]]
    carrying: Mapping[str, frozenset[str]]
    """Per seam the situations where it carried a sample in some flight."""
    units: Mapping[str, str]
    name: str = CAMPAIGN

    @classmethod
    def of(
        cls,
        outcomes: Iterable[Outcome],
        scored: Score,
        matrix: KillMatrix,
        backgrounds: Mapping[str, Background],
        units: Mapping[str, str],
        name: str,
    ) -> CampaignFacts:
        """From outcomes, with or without trajectories, and their score; invalid flights say nothing."""
        counting = (flight for flight in flights_of(outcomes) if flight.status is not Status.INVALID)
        scores = {mutant.subject.id: mutant for mutant in scored.mutants}
        by_seam = grouped((id_ for id_ in backgrounds if id_ in scores), lambda id_: backgrounds[id_].seam)
        results = {seam: [result for id_ in ids for result in scores[id_].results] for seam, ids in by_seam.items()}
        return cls(
            space=matrix.space,
            pool=scored.pool,
            scores=scores,
            flights=grouped(counting, lambda flight: flight.outcome.mutant),
            carrying={seam: frozenset(one.situation for one in own if one.reached) for seam, own in results.items()},
            units=units,
            name=name,
        )

    @property
    def safety(self) -> tuple[str, ...]:
        """The safety requirements."""
        return self.pool.requirements(Kind.SAFETY)

    def states(self, requirement: str, situations: Iterable[str]) -> Counter[State]:
        """In how many of some situations a requirement has each state."""
        return Counter(self.pool.states.get((key, requirement), State.UNKNOWN) for key in situations)

    def where(self, true: Callable[[str], bool], known: Iterable[str]) -> str:
        """In words, the situations of `known` of which something is true."""
        among = {key for key in known if key in self.space.point}
        holds = {key for key in among if true(key)}
        return condition(self.space, holds, among - holds) or "nowhere"


_T, _X, _Y, _Z = (TRACK_COLUMNS.index(name) for name in ("elapsed_s", "x_m", "y_m", "z_m"))


@dataclass(frozen=True)
class Loss:
    """Robustness of a requirement in a flight beside its baseline's, in the requirement's unit.

    Attributes:
        requirement: name of the requirement.
        situation: key of the situation.
        seed: seed of the flight.
        baseline: robustness of the baseline, above 0, in the requirement's unit.
        flown: robustness of the flight, in the requirement's unit.
    """

    KEYS = ("*", "share")
    requirement: str
    situation: str
    seed: int
    baseline: float
    flown: float

    @property
    def share(self) -> float:
        """Share of the baseline's margin that the fault took; below 0 where it gained some."""
        return (self.baseline - self.flown) / self.baseline


def losses(flight: JudgedFlight, steady: Collection[str]) -> tuple[Loss, ...]:
    """What a flight lost of each requirement, steady there, that it and its baseline held to their ends, triggered."""
    if flight.baseline is None:
        return ()
    lost = []
    for reading in flight.outcome.readings:
        clean = flight.baseline.reading(reading.requirement)
        if clean is not None and reading.requirement in steady and _held(reading) and _held(clean) and clean.rho > 0:
            place = flight.outcome.situation, flight.outcome.seed
            lost.append(Loss(reading.requirement, *place, clean.rho, reading.rho))
    return tuple(lost)


def _held(reading: Reading) -> bool:
    return reading.compliance is Compliance.HELD


def off_path_m(flight: JudgedFlight) -> float | None:
    """How far the flight was off its baseline's path at the most [m]: second by second, to the nearest point of it.

    Time does not enter: a flight that goes the same way later is not off it.  None without both trajectories.
    """
    flown = unpack_track(flight.outcome.track)
    path = unpack_track(flight.baseline.track) if flight.baseline else []
    if not flown or not path:
        return None
    # a published track may be thinner than a stored one
    apart_s = flown[1][_T] - flown[0][_T] if len(flown) > 1 else 0.0
    each = max(1, round(1 / apart_s)) if apart_s > 0 else 1
    points, others = (np.array([[row[_X], row[_Y], row[_Z]] for row in rows]) for rows in (flown[::each], path))
    apart = np.linalg.norm(points[:, None, :] - others[None, :, :], axis=2)
    return float(apart.min(axis=1).max())


@dataclass(frozen=True)
class Case:
    """One survivor and its flights."""

    campaign: CampaignFacts
    row: KillRow
    background: Background

    @property
    def score(self) -> MutantScore:
        """What its flights say together."""
        return self.campaign.scores[self.row.id]

    @property
    def flights(self) -> Sequence[JudgedFlight]:
        """Those that count."""
        return self.campaign.flights.get(self.row.id, ())

    @cached_property
    def flown(self) -> frozenset[str]:
        """Situations with a flight of it that counts."""
        return frozenset(result.situation for result in self.score.results)

    @cached_property
    def infected(self) -> frozenset[str]:
        """Those where it changes a sample."""
        return frozenset(result.situation for result in self.score.results if result.infected)

    @cached_property
    def steady(self) -> Mapping[str, tuple[str, ...]]:
        """Per situation that puts it to the test the safety requirements that do."""
        return {result.situation: result.steady for result in self.score.results if result.tested}

    @property
    def lacking(self) -> frozenset[str]:
        """Situations where it infects and the pool has too few flights."""
        return self.infected - self.campaign.pool.flown

    @cached_property
    def tested(self) -> tuple[JudgedFlight, ...]:
        """Flights in situations that put it to the test."""
        return tuple(flight for flight in self.flights if flight.outcome.situation in self.steady)

    @cached_property
    def loss(self) -> Loss | None:
        """The greatest share of a margin that a flight lost in a steady pair; the first of equals."""
        lost = (loss for f in self.tested for loss in losses(f, self.steady[f.outcome.situation]))
        return max(lost, key=lambda loss: loss.share, default=None)

    @cached_property
    def off_path_m(self) -> float | None:
        """How far a flight that put it to the test was off its baseline's path at the most [m]; None if not known."""
        ways = (off_path_m(flight) for flight in self.tested if flight.status is Status.SURVIVED)
        return max((way_m for way_m in ways if way_m is not None), default=None)

    @property
    def infected_where(self) -> str:
        """The situations where it changes a sample, in words."""
        return self.campaign.where(self.infected.__contains__, self.flown)
