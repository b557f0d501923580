"""The mutation score: what the campaign's flights say about each mutant, about all of them, and part by part.

A fault that did nothing but redraw the noise would turn one baseline into another.  So seeds of the unmutated drone are
judged as a mutant beside ten others: as many as the mutants flew, the same in every situation, chosen at random again
and again.  PLACEBO cannot show this, because it draws the same noise as its baseline.  The redraws overlap, so their
share has no interval.

In which situations a mutant dies is a short condition, `human & light`, by Quine and McCluskey's method for axes of any
number of values: a term is a box (a set of values per axis), the prime terms are the largest boxes without a surviving
situation, and the fewest of them that cover every kill are printed.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import lru_cache, reduce
from itertools import combinations, product
from math import prod
from operator import and_, getitem
from typing import Annotated, NamedTuple

import numpy as np
from numpy.typing import NDArray

from scaloft_fi.analysis.detection import (
    LEAST,
    Detection,
    Firmness,
    Pair,
    Pool,
    Sample,
    Spending,
    Verdict,
    adjusted,
    detect,
    firmness,
)
from scaloft_fi.analysis.roster import OfSubject, Ratio, Roster
from scaloft_fi.hazop.matrix import UNCLASSED, SeverityClass, class_of, worst_first
from scaloft_fi.judge.outcome import BASELINE, PLACEBO_ID, Outcome, Subject
from scaloft_fi.judge.requirement import Kind
from scaloft_fi.judge.space import Point, Space
from scaloft_fi.judge.status import INVALID, Ruled, Rulings, Situations, Status, furthest, rulings_of
from scaloft_fi.marks import About, ByName
from scaloft_fi.registry import grouped

Term = tuple[frozenset[str], ...]
"""Per axis the values a term admits."""

MOST_BOXES = 60_000
"""Beyond this many boxes only boxes with one or all values on each axis are looked at."""
MOST_EXACT = 16
"""Up to this many prime terms the smallest cover is searched for exactly; beyond, greedily."""


def condition(space: Space, killing: Collection[str], surviving: Collection[str]) -> str:
    """The shortest condition that is true in every killing situation and in no surviving one.

    Situations in neither (nothing is known there) may fall on either side, but it names no value without a kill.
    Numbers drawn from a range count as their bin, and a bin with a kill counts as killing.

    Args:
        space: the grid.
        killing: keys of the situations where the mutant is killed.
        surviving: keys of those where it was put to the test and is not.

    Raises:
        ValueError: a situation is in both.
    """
    terms = cover(space, killing, surviving)
    if not terms:
        return ""
    texts = [term_text(space, term) for term in terms]
    if texts == [""]:
        return "everywhere" if len({space.point[key] for key in killing}) == len(space.points) else "wherever tested"
    return " or ".join(f"({text})" if len(texts) > 1 and " & " in text else text for text in texts)


def cover(space: Space, killing: Collection[str], surviving: Collection[str]) -> tuple[Term, ...]:
    """The terms of the condition: every killing point is in one of them, no surviving point in any.

    Raises:
        ValueError: a situation is in both.
    """
    both = set(killing) & set(surviving)
    if both:
        raise ValueError(f"both killing and surviving: {sorted(both)}")
    on, off = sides(space, killing, surviving)
    terms = (_named(space, term, on) for term in _fewest(space, _primes(space, on, off), on))
    return tuple(sorted(terms, key=lambda term: _order(space, term)))


def _named(space: Space, term: Term, on: Sequence[Point]) -> Term:
    """The box with, on each axis that it restricts, the values of its kills alone: of others nothing was seen."""
    seen = map(frozenset, zip(*(point for point in on if admits(term, point)), strict=True))
    return tuple(own if len(own) == len(all_) else one for own, one, all_ in zip(term, seen, space.values, strict=True))


def sides(space: Space, killing: Collection[str], surviving: Collection[str]) -> tuple[list[Point], list[Point]]:
    """The points with a kill and those with survival only, each once, in the grid's order."""
    on = dict.fromkeys(space.point[key] for key in sorted(killing, key=space.rank))
    off = dict.fromkeys(space.point[key] for key in sorted(surviving, key=space.rank))
    return list(on), [point for point in off if point not in on]


def admits(term: Term, point: Point) -> bool:
    """Whether a point is in the box."""
    return all(value in allowed for value, allowed in zip(point, term, strict=True))


def _primes(space: Space, on: Sequence[Point], off: Sequence[Point]) -> list[Term]:
    """The boxes with a killing point and no surviving one that no other such box contains, largest first."""
    if not on:
        return []
    if not off:
        return [tuple(frozenset(values) for values in space.values)]
    if prod(2 ** len(values) - 1 for values in space.values) > MOST_BOXES:
        return _primes_around(space, on, off)
    bits = {point: 1 << place for place, (_, point) in enumerate(space.points)}
    killing, surviving = (sum(bits[point] for point in points) for points in (on, off))
    primes: list[Term] = []
    for term, inside in _boxes(space):
        contained = (all(map(frozenset.issubset, term, larger)) for larger in primes)
        if inside & killing and not inside & surviving and not any(contained):
            primes.append(term)
    return primes


@lru_cache(maxsize=8)
def _boxes(space: Space) -> tuple[tuple[Term, int], ...]:
    """Every box, largest first, with the points of the grid in it, one bit each: a campaign has hundreds of mutants."""
    sides = [
        {
            frozenset(chosen): sum(1 << i for i, (_, point) in enumerate(space.points) if point[axis] in chosen)
            for size in range(1, len(values) + 1)
            for chosen in combinations(values, size)
        }
        for axis, values in enumerate(space.values)
    ]
    every = (1 << len(space.points)) - 1
    boxes = sorted(product(*sides), key=lambda term: _order(space, term))
    return tuple((term, reduce(and_, map(getitem, sides, term), every)) for term in boxes)


def _primes_around(space: Space, on: Sequence[Point], off: Sequence[Point]) -> list[Term]:
    """The same among boxes with one or all values on each axis.

    Such a box around a killing point fixes some axes to its values, and leaves a surviving point out when they differ
    on one of them: so the largest boxes are the smallest sets of axes that meet every set of differing axes.
    """
    every, axes_ = [frozenset(values) for values in space.values], range(len(space.axes))
    terms: set[Term] = set()
    for point in on:
        differing = {frozenset(axis for axis in axes_ if point[axis] != other[axis]) for other in off}
        for axes in _smallest_meeting(differing):
            terms.add(tuple(frozenset([v]) if i in axes else every[i] for i, v in enumerate(point)))
    return sorted(terms, key=lambda term: _order(space, term))


def _smallest_meeting(sets: Iterable[frozenset[int]]) -> set[frozenset[int]]:
    """The smallest sets that meet each of `sets` (its minimal transversals), set by set after Berge (1989).

    >>> sorted(map(sorted, _smallest_meeting([frozenset({0, 1}), frozenset({1, 2})])))
    [[0, 2], [1]]
    """
    transversals: set[frozenset[int]] = {frozenset()}
    for met in sorted(sets, key=lambda members: (len(members), sorted(members))):
        enough = {chosen for chosen in transversals if chosen & met}
        grown = {chosen | {axis} for chosen in transversals - enough for axis in met}
        transversals = enough | {chosen for chosen in grown if not any(smaller <= chosen for smaller in enough)}
    return transversals


def _order(space: Space, term: Term) -> tuple[int, int, list[list[int]]]:
    """Fewest literals first, then fewest values left out, then the grid's order: ties always break the same way."""
    left_out = [len(values) - len(allowed) for values, allowed in zip(space.values, term, strict=True)]
    places = [sorted(map(values.index, allowed)) for values, allowed in zip(space.values, term, strict=True)]
    return sum(count > 0 for count in left_out), sum(left_out), places


def _fewest(space: Space, primes: Sequence[Term], on: Sequence[Point]) -> list[Term]:
    covered = {term: frozenset(i for i, point in enumerate(on) if admits(term, point)) for term in primes}
    everything = frozenset(range(len(on)))
    essential = {holders[0] for i in everything if len(holders := [term for term in primes if i in covered[term]]) == 1}
    chosen = [term for term in primes if term in essential]
    missing = everything.difference(*(covered[term] for term in chosen))
    others = [term for term in primes if term not in essential and covered[term] & missing]
    if len(others) <= MOST_EXACT:
        for size in range(len(others) + 1):
            fits = [
                pick for pick in combinations(others, size) if missing <= frozenset().union(*(covered[t] for t in pick))
            ]
            if fits:
                return [*chosen, *min(fits, key=lambda pick: sum(_order(space, term)[0] for term in pick))]
    while missing:
        best = max(others, key=lambda term: len(covered[term] & missing))
        chosen.append(best)
        missing -= covered[best]
    # a greedy choice may be made superfluous by later ones
    for term in list(chosen):
        rest = [covered[other] for other in chosen if other != term]
        if everything <= frozenset().union(*rest):
            chosen.remove(term)
    return chosen


def term_text(space: Space, term: Term) -> str:
    """`human & light`: the axes in reverse order of the grid read best, the person before the light."""
    factors = []
    for axis in reversed(range(len(space.axes))):
        allowed = [value for value in space.values[axis] if value in term[axis]]
        if len(allowed) < len(space.values[axis]):
            factors.append([space.word(axis, value) for value in allowed])
    alone = len(factors) == 1
    return " & ".join(
        " or ".join(names) if alone or len(names) == 1 else f"({' or '.join(names)})" for names in factors
    )


MOST_KILLED = 0.9
"""A detected mutant that is killed in this share of the situations that put it to the test is trivial."""
EARLY_S = 5.0
"""So is one that a kill shows within this time of take-off [s]."""
SEVERAL = 3
"""Runs of a fault by which a test that was red without a fault too can kill it, as one red run may be chance."""


class FirstViolation(NamedTuple):
    """The earliest violation of a requirement.

    Attributes:
        requirement: name of the requirement.
        t_s: time [s from take-off].
        situation: key of the situation.
        seed: seed of the flight.
        position: x, y, z of the vehicle [m, world].
        struck: name of the body that was struck; empty for none.
    """

    requirement: str
    t_s: float
    situation: str
    seed: int
    position: tuple[float, float, float]
    struck: str


@dataclass(frozen=True)
class Kill:
    """A steady pair in which most flights of a detected mutant violate; 3 or more of a test red without a fault too.

    Attributes:
        situation: key of the situation.
        requirement: name of the requirement.
        violated: flights that violate the requirement.
        flights: flights that count.
        first: the earliest violation.
    """

    KEYS = ("situation", "requirement", "violated", "flights")
    situation: str
    requirement: str
    violated: int
    flights: int
    first: FirstViolation


@dataclass(frozen=True)
class Result:
    """A mutant in a situation: its flights over the seeds.

    Attributes:
        situation: key.
        status: the furthest stage that a flight reached.
        flown: flights that count.
        reached: whether the seam carried a sample in any.
        infected: whether the fault changed a sample in any.
        violated: per requirement, the flights that violate it, where any does.
        steady: the safety requirements that put the fault to the test here: steady in the pool, and it infects.
        steady_operability: the same of operability requirements.
        kills: those of `steady` that kill the mutant here.
        operability_kills: those of `steady_operability` that do.
    """

    situation: str
    status: Status
    flown: int
    reached: bool
    infected: bool
    violated: tuple[tuple[str, int], ...]
    steady: tuple[str, ...]
    steady_operability: tuple[str, ...]
    kills: tuple[str, ...]
    operability_kills: tuple[str, ...]

    @property
    def tested(self) -> bool:
        """Whether the situation puts the fault to the test by a safety requirement."""
        return bool(self.steady)

    @property
    def seen(self) -> tuple[str, ...]:
        """The safety requirements among `steady` that a flight violates."""
        return tuple(name for name, _ in self.violated if name in self.steady)


class Effectless(NamedTuple):
    """A mutant whose flights all equal the baseline's to the bit.

    Attributes:
        id: canonical id.
        acted: flights in which it changed a sample, of those that count.
    """

    id: str
    acted: Ratio


@dataclass(frozen=True)
class ByOperability:
    """The same by operability requirements.

    Attributes:
        detection: what the verdict rests on.
        kills: in the grid's order.
    """

    detection: Detection
    kills: tuple[Kill, ...]
    KEYS = ("detection.verdict", "detection.p", "kills", "decided_at=detection")


_Kills = Annotated[Ratio, About("situations with such a kill, of those that test it by it")]


@dataclass(frozen=True)
class MutantScore(OfSubject):
    """A mutant over all its situations.

    Attributes:
        subject: the mutant.
        status: the furthest stage that a flight reached.
        safety: what the verdict rests on, by safety requirements.
        operability: the same by operability requirements.
        results: one per situation with a flight that counts, in the grid's order.
        kills: steady pairs of a safety requirement in which most of its flights violate, in the grid's order.
        operability_kills: the same of operability requirements.
        first: its earliest violation in a kill; of a mutant without one the earliest in a pair that tests it; null:
            there is none.
        statuses: flights of each status.
        firmness: whether it stays detected when any one seed is left out; null: it is not detected.
        severity: class of its cell; None where the cell has none.  It enters no ratio.
        revealed: requirements that a flight of it violates and the baseline beside that flight holds.
        struck: names of the bodies that flights strike in such a violation of a safety requirement.
    """

    subject: Subject
    status: Status
    safety: Detection
    operability: Detection
    results: tuple[Result, ...]
    kills: tuple[Kill, ...]
    operability_kills: tuple[Kill, ...]
    first: FirstViolation | None
    statuses: tuple[tuple[Status, int], ...]
    firmness: Firmness | None = None
    severity: SeverityClass | None = None
    revealed: tuple[str, ...] = ()
    struck: tuple[str, ...] = ()
    KEYS = (
        *("subject.*", "severity=severity_id", "status", "verdict", "firm=firmness"),
        *("p=safety.p", "kill_rate", "kill_rate_flown", "kills", "requirements", "first", "decided_at=safety"),
        "operability=by_operability",
    )

    @property
    def severity_id(self) -> str | None:
        """Class of severity, one of the study's own; in no ratio; null: it has none."""
        return self.severity.id if self.severity else None

    @property
    def by_operability(self) -> ByOperability:
        """The same by operability requirements."""
        return ByOperability(self.operability, self.operability_kills)

    @property
    def verdict(self) -> Verdict:
        """Of all its flights, by safety requirements."""
        return self.safety.verdict

    @property
    def detected(self) -> bool:
        """Whether the tests would have shown the fault by a safety requirement."""
        return self.safety.detected

    @property
    def shown_by(self) -> tuple[str, ...]:
        """The requirements that show a control: those that detect it, else those that `revealed` names."""
        return (*self.safety.by, *self.operability.by) or self.revealed

    @property
    def firm(self) -> bool:
        """Whether it is detected, and stays so without any one seed."""
        return self.firmness is not None and self.firmness.firm

    @property
    def killed_broadly(self) -> bool:
        """Whether nearly all situations that put it to the test kill it."""
        rate = self.kill_rate
        return self.detected and rate.part >= MOST_KILLED * rate.whole > 0

    @property
    def killed_early(self) -> bool:
        """Whether a kill shows it right after take-off."""
        return any(kill.first.t_s <= EARLY_S for kill in self.kills)

    @property
    def trivial(self) -> bool:
        """Whether it is detected where any test would do: in nearly all situations, or right after take-off."""
        return self.killed_broadly or self.killed_early

    @property
    def without_effect(self) -> bool:
        """Whether each of its flights equals the baseline's to the bit."""
        return self.flown and self.status.stage <= Status.MASKED.stage

    @property
    def acted(self) -> Ratio:
        """Flights in which it changed a sample, of those that count."""
        counts = [(status.infected, count) for status, count in self.statuses if status is not Status.INVALID]
        return Ratio(sum(count for infected, count in counts if infected), sum(count for _, count in counts))

    @property
    def flown(self) -> bool:
        """Whether any of its flights counts."""
        return bool(self.results)

    @property
    def infected(self) -> bool:
        """Whether any flight is infected."""
        return any(result.infected for result in self.results)

    @property
    def tested(self) -> bool:
        """Whether it is put to the test in some situation."""
        return any(result.tested for result in self.results)

    @property
    def kill_rate(self) -> Ratio:
        """Situations with a kill, of those that put it to the test."""
        return Ratio(len(self.killing), sum(result.tested for result in self.results))

    @property
    def kill_rate_flown(self) -> Ratio:
        """Situations with a kill, of those flown."""
        return Ratio(len(self.killing), len(self.results))

    @property
    def killing(self) -> tuple[str, ...]:
        """Keys of the situations with a kill."""
        return tuple(result.situation for result in self.results if result.kills)

    @property
    def seen_in(self) -> tuple[str, ...]:
        """Keys of the situations where a flight violates a requirement that tests the fault."""
        return tuple(result.situation for result in self.results if result.seen)

    @property
    def requirements(self) -> Annotated[tuple[tuple[str, _Kills], ...], ByName()]:
        """By requirement that kills it, operability too."""
        kills = Counter(name for r in self.results for name in (*r.kills, *r.operability_kills))
        tests = Counter(name for r in self.results for name in (*r.steady, *r.steady_operability))
        return tuple((name, Ratio(kills[name], tests[name])) for name in tests if kills[name])

    @property
    def tests(self) -> tuple[str, ...]:
        """Requirements that put it to the test somewhere."""
        return tuple(dict.fromkeys(n for r in self.results for n in (*r.steady, *r.steady_operability)))

    def condition(self, space: Space) -> str:
        """The situations with a kill in words; of a mutant without one those where a violation was seen."""
        where = self.killing or self.seen_in
        if space.of_tests:
            return ", ".join(where)
        spared = tuple(r.situation for r in self.results if r.situation not in where and (r.tested or not r.infected))
        return _condition(space, where, spared)


_condition = lru_cache(maxsize=4096)(condition)
"""The condition, derived once: several tables show it."""


def mutant_score(
    subject: Subject, situations: Situations, space: Space, pool: Pool, spending: Spending, *, firm: bool = True
) -> MutantScore:
    """Score one mutant beside the pool; `firm`: whether a detected one is judged again without each seed."""
    valid = {key: [one for one in situations[key] if one.ruling is not INVALID] for key in situations}
    flown = {key: valid[key] for key in sorted(valid, key=space.rank) if valid[key]}
    samples = [sample(key, flights) for key, flights in flown.items()]
    safety = detect(subject.id, samples, pool, spending, Kind.SAFETY)
    operability = detect(subject.id, samples, pool, spending, Kind.OPERABILITY)
    results = tuple(
        _result(sample, flown[sample.situation], pool, safety.detected, operability.detected, space.of_tests)
        for sample in samples
    )
    kills = tuple(_kill(r, name, flown[r.situation]) for r in results for name in r.kills)
    seen = [kill.first for kill in kills] or [_first(r, n, flown[r.situation]) for r in results for n in r.seen]
    statuses = Counter[Status]()
    # few rulings differ, so they are counted first
    rulings = Counter([one.ruling for flights in situations.values() for one in flights])
    for ruling, number in rulings.items():
        statuses[ruling.status] += number
    revealed = dict.fromkeys(name for ruling in rulings for name in (*ruling.revealed, *ruling.operability_revealed))
    shown = ((v, one.ruling) for flights in flown.values() for one in flights for v in one.violations)
    struck = dict.fromkeys(v.struck for v, ruling in shown if v.struck and v.requirement in ruling.revealed)
    return MutantScore(
        subject=subject,
        status=furthest(statuses),
        safety=safety,
        operability=operability,
        results=results,
        kills=kills,
        operability_kills=tuple(_kill(r, name, flown[r.situation]) for r in results for name in r.operability_kills),
        first=min(seen, key=lambda moment: (moment.t_s, space.rank(moment.situation), moment.seed), default=None),
        statuses=tuple((status, statuses[status]) for status in Status if statuses[status]),
        firmness=firmness(subject.id, samples, pool, spending, Kind.SAFETY) if firm and safety.detected else None,
        revealed=tuple(revealed),
        struck=tuple(struck),
    )


def sample(situation: str, flights: Sequence[Ruled]) -> Sample:
    """The flights of a mutant in a situation, all of which count."""
    infected = any(ruling.status.infected for ruling in {one.ruling for one in flights})
    violated, seeds = tuple([one.ruling.violated for one in flights]), tuple([one.seed for one in flights])
    return Sample(situation, violated, infected, seeds)


def _result(
    sample: Sample, flights: Sequence[Ruled], pool: Pool, detected: bool, operability_detected: bool, of_tests: bool
) -> Result:
    steady, operable = (
        pool.steady(sample.situation, kind) if sample.infected else () for kind in (Kind.SAFETY, Kind.OPERABILITY)
    )
    status = furthest({ruling.status for ruling in {one.ruling for one in flights}})
    several = not of_tests or len(flights) >= SEVERAL
    most = {
        name
        for name in (*steady, *operable)
        if 2 * sample.count(name) > len(flights) and (several or not pool.pairs[sample.situation, name].violated)
    }
    return Result(
        situation=sample.situation,
        status=status,
        flown=len(flights),
        reached=status is not Status.NOT_REACHED,
        infected=sample.infected,
        violated=tuple(sorted(sample.counts.items())),
        steady=steady,
        steady_operability=operable,
        kills=tuple(name for name in steady if detected and name in most),
        operability_kills=tuple(name for name in operable if operability_detected and name in most),
    )


def _kill(result: Result, requirement: str, flights: Sequence[Ruled]) -> Kill:
    violated = dict(result.violated)[requirement]
    return Kill(result.situation, requirement, violated, result.flown, _first(result, requirement, flights))


def _first(result: Result, requirement: str, flights: Sequence[Ruled]) -> FirstViolation:
    """The earliest violation of a requirement by flights that are known to violate it."""
    own = ((v.t_s, one.seed, v) for one in flights for v in one.violations if v.requirement == requirement)
    t_s, seed, v = min(own, key=lambda moment: moment[:2])
    return FirstViolation(requirement, t_s, result.situation, seed, (v.x, v.y, v.z), v.struck)


@dataclass(frozen=True)
class Score:
    """The campaign's score.

    Ratios count the default mutants of credible cells and nothing else; without a pool nothing is detected, of none.

    Attributes:
        alpha: accepted chance that a fault which does nothing is called detected (0..1).
        exercised: credible cells whose default mutant was flown, of all credible cells.
        infected: default mutants that changed a sample, of those flown.
        tested: default mutants put to the test: they infect where a safety requirement is steady; of those flown.
        mutation_score: default mutants detected by safety requirements, of those flown.
        operability: default mutants detected by operability requirements, of those flown; of none, where
            there is no such requirement.
        mutants: every mutant flown, ladders too, in the canonical order.
        counted: those of them that the ratios count; one of which no flight counts is not tested.
        controls: every control flown; no ratio counts them.
        placebo: PLACEBO, when flown.
        pool: the pairs of the unmutated drone.
        redraw: how often redraws of the unmutated drone are called detected.
        lacking: keys of situations where a mutant, controls left out, infects and the pool has too few flights.
        pooled: whether there is a baseline pool to decide by where mutants infect; without one there are only
            observations.
        selected: keys of situations flown that a search found because of verdicts; a score that uses them is selected.
        behaviours: the counted mutants that are detected; those whose flights all equal each other's to the bit
            together.
        of_tests: whether one's own tests were run instead of flights.
    """

    KEYS = ("exercised", "infected", "tested", "mutation_score", "firm", "operability")
    alpha: float
    exercised: Ratio
    infected: Ratio
    tested: Ratio
    mutation_score: Ratio
    operability: Ratio
    mutants: tuple[MutantScore, ...]
    counted: tuple[MutantScore, ...]
    controls: tuple[MutantScore, ...]
    placebo: MutantScore | None
    pool: Pool
    redraw: Redraw
    lacking: tuple[str, ...]
    pooled: bool
    selected: tuple[str, ...] = ()
    behaviours: tuple[tuple[str, ...], ...] = ()
    of_tests: bool = False

    @property
    def faults(self) -> Sequence[MutantScore]:
        """The mutants that count; where none was flown, all that were."""
        return self.counted or self.mutants

    @property
    def firm(self) -> Ratio:
        """Default mutants detected whichever one seed is left out, of those flown."""
        return Ratio(sum(mutant.firm for mutant in self.counted) if self.pooled else 0, self.mutation_score.whole)

    @property
    def without_kill(self) -> tuple[str, ...]:
        """Ids of counted mutants that are detected, of which most flights violate in no situation."""
        return tuple(mutant.subject.id for mutant in self.counted if mutant.detected and not mutant.kills)

    @property
    def trivial(self) -> tuple[str, ...]:
        """Ids of counted mutants killed in nine tenths of the situations that test them, or within 5 s of take-off."""
        found = (one for one in self.counted if (one.killed_broadly if self.of_tests else one.trivial))  # no take-off
        return tuple(one.subject.id for one in found)

    @property
    def without_effect(self) -> tuple[Effectless, ...]:
        """The counted mutants whose flights all equal the baseline's to the bit."""
        idle = (mutant for mutant in self.counted if mutant.without_effect and not self.of_tests)  # runs have no bits
        return tuple(Effectless(mutant.subject.id, mutant.acted) for mutant in idle)

    @property
    def expected_false(self) -> float:
        """Mutants that would be called detected if none had any effect, expected at most."""
        return self.alpha * self.tested.part


def score(
    outcomes: Iterable[Outcome],
    roster: Roster,
    space: Space,
    spending: Spending | None = None,
    others: Iterable[Outcome] = (),
) -> Score:
    """Score a campaign's outcomes, in whatever order they come.

    Args:
        outcomes: of the campaign.
        roster: which mutants count.
        space: the grid.
        spending: how alpha is spent; by default all of it once.
        others: baselines of another campaign that the pool has too.
    """
    return score_of(rulings_of(outcomes), roster, space, spending, others)


def score_of(
    rulings: Rulings, roster: Roster, space: Space, spending: Spending | None = None, others: Iterable[Outcome] = ()
) -> Score:
    """The same of flights that are ruled already."""
    spending = spending or Spending()
    baselines = {(o.situation, o.seed): o for o in (*others, *rulings.baselines) if not o.invalid}
    pool = Pool.of(baselines.values())
    ranked = sorted(rulings.mutants.items(), key=lambda mutant: roster.rank(mutant[0].id))
    scored = [
        replace(mutant_score(subject, situations, space, pool, spending), severity=roster.severity(subject.id))
        for subject, situations in ranked
    ]
    mutants = tuple(m for m in scored if m.subject.id != PLACEBO_ID and not roster.is_control(m.subject))
    counted = tuple(mutant for mutant in mutants if roster.counts(mutant.subject))
    infected = {r.situation for m in mutants for r in m.results if r.infected}
    pooled = not infected or bool(infected & pool.flown)
    decided, operable = len(counted) if pooled else 0, pool.requirements(Kind.OPERABILITY)
    seeds = max((result.flown for mutant in counted for result in mutant.results), default=0)
    return Score(
        alpha=spending.alpha,
        exercised=Ratio(sum(mutant.flown for mutant in counted), len(roster.defaults)),
        infected=Ratio(sum(mutant.infected for mutant in counted), len(counted)),
        tested=Ratio(sum(mutant.tested for mutant in counted), len(counted)),
        mutation_score=Ratio(sum(mutant.detected for mutant in counted), decided),
        operability=Ratio(sum(m.operability.detected for m in counted), decided if operable else 0),
        mutants=mutants,
        counted=counted,
        controls=tuple(mutant for mutant in scored if roster.is_control(mutant.subject)),
        placebo=next((mutant for mutant in scored if mutant.subject.id == PLACEBO_ID), None),
        pool=pool,
        redraw=redraw(baselines.values(), seeds, spending.alpha),
        lacking=tuple(sorted(infected - pool.flown, key=space.rank)),
        pooled=pooled,
        selected=tuple(sorted(space.selected & rulings.situations, key=space.rank)),
        behaviours=_behaviours(counted, rulings),
        of_tests=space.of_tests,
    )


def _behaviours(counted: Iterable[MutantScore], rulings: Rulings) -> tuple[tuple[str, ...], ...]:
    """The detected among the counted mutants, grouped by equal flights, in order."""
    detected = (mutant.subject.id for mutant in counted if mutant.detected)
    return tuple(map(tuple, grouped(detected, rulings.behaviours.__getitem__).values()))


class By(StrEnum):
    """What to group by."""

    GUIDEWORD = "guideword"
    PARAMETER = "parameter"
    SEVERITY = "severity"
    SITUATION = "situation"
    REQUIREMENT = "requirement"
    AXIS = "axis"


@dataclass(frozen=True)
class Group:
    """One part of the score.

    Attributes:
        by: what the parts are.
        name: of the part: a guideword, a parameter, a class of severity (worst first, `no class` last), a key, a
            requirement, an axis with its value.
        tested: detected mutants of those put to the test; of a situation, a requirement or an axis value those with a
            kill there of those that it tests, and of an axis value mutants in situations.
        flown: the same detected, of those flown.
        axis: id of the axis; null: not by axis.
        value: id of the axis's value, as in keys of situations; null: not by axis.
    """

    by: By
    name: str
    tested: Ratio
    flown: Ratio
    axis: str | None = None
    value: str | None = None


def groups(scored: Score, by: By, space: Space) -> tuple[Group, ...]:
    """Group the default mutants of credible cells."""
    mutants = scored.counted
    results = [(result, space.point.get(result.situation)) for mutant in mutants for result in mutant.results]

    def group(name: str, facts: Iterable[tuple[bool, bool]], *place: str) -> Group:
        """Of facts whether each was hit, and whether it was tested."""
        hit, tested = zip(*facts, strict=True) if (facts := list(facts)) else ((), ())
        return Group(by, name, Ratio(sum(hit), sum(tested)), Ratio(sum(hit), len(hit)), *place)

    def of_results(name: str, own: Iterable[Result], *place: str) -> Group:
        return group(name, ((bool(result.kills), result.tested) for result in own), *place)

    if by is By.REQUIREMENT:
        shown = [(mutant.tests, (*mutant.safety.by, *mutant.operability.by)) for mutant in mutants]
        names = dict.fromkeys(name for tests, _ in shown for name in tests)
        return tuple(group(n, ((n in tests and n in told, n in tests) for tests, told in shown)) for n in names)
    if by is By.SITUATION:
        keys = sorted({result.situation for result, _ in results}, key=space.rank)
        return tuple(of_results(key, (r for r, _ in results if r.situation == key)) for key in keys)
    if by is By.AXIS:
        return tuple(
            of_results(f"{axis} = {space.word(n, value)}", (r for r, p in results if p and p[n] == value), axis, value)
            for n, axis in enumerate(space.axes)
            for value in space.values[n]
        )
    name_of: Mapping[By, Callable[[MutantScore], str]] = {
        By.GUIDEWORD: lambda mutant: mutant.subject.guideword,
        By.PARAMETER: lambda mutant: mutant.subject.parameter,
        By.SEVERITY: lambda mutant: class_of(mutant.severity) or UNCLASSED,
    }
    ordered = worst_first(mutants, lambda mutant: mutant.severity) if by is By.SEVERITY else mutants
    parts = grouped(ordered, name_of[by]).items()
    return tuple(group(name, [(one.detected, one.tested) for one in own]) for name, own in parts)


FROM = 20
"""Pool flights in every situation from which redraws are made."""
REDRAWS = 200
SEED = 20251
"""Of the choices; a fixed number, so that a score is the same whenever it is asked for."""

NONE = Ratio(0, 0)
"""The share where no redraw was made."""


@dataclass(frozen=True)
class Redraw:
    """What redraws of the unmutated drone gave.

    Attributes:
        seeds: flights of a redraw in each situation; 0 where none was made.
        safety: redraws detected by safety requirements, of all.
        operability: redraws detected by operability requirements, of all.
    """

    seeds: int = 0
    safety: Ratio = NONE
    operability: Ratio = NONE


def redraw(baselines: Iterable[Outcome], seeds: int, alpha: float, redraws: int = REDRAWS) -> Redraw:
    """Judge seeds of the baseline as mutants; none where a situation with a pool has fewer flights than `FROM`.

    Args:
        baselines: the pool.
        seeds: flights of a mutant in each situation.
        alpha: of the verdict.
        redraws: how many.
    """
    flown = grouped((o for o in baselines if o.subject.id == BASELINE and not o.invalid), lambda o: o.situation)
    by_seed = {key: {outcome.seed: outcome for outcome in own} for key, own in flown.items()}
    pooled = {key: own for key, own in by_seed.items() if len(own) >= LEAST}
    common = sorted(set.intersection(*(set(own) for own in pooled.values()))) if pooled else []
    if len(common) < max(FROM, LEAST + seeds) or not seeds:
        return Redraw()
    drawn = _Drawn({key: [own[seed] for seed in common] for key, own in pooled.items()})
    draw = np.random.Generator(np.random.PCG64(SEED))
    counts = dict.fromkeys((Kind.SAFETY, Kind.OPERABILITY), 0)
    for _ in range(redraws):
        order = draw.permutation(len(common))
        for kind in counts:
            p = drawn.p(order[:seeds], order[seeds : seeds + LEAST], kind)
            counts[kind] += min(p.values(), default=1.0) <= alpha
    return Redraw(seeds, *(Ratio(count, redraws) for count in counts.values()))


class _Drawn:
    """Baselines of the same seeds in each situation.

    Args:
        flown: by situation, in the order of the seeds.
    """

    def __init__(self, flown: Mapping[str, Sequence[Outcome]]) -> None:
        self._violated = {
            key: [tuple(violation.requirement for violation in outcome.violations) for outcome in own]
            for key, own in flown.items()
        }
        self._counted: dict[tuple[str, str, Kind], NDArray[np.int64]] = {}
        for key, own in flown.items():
            readings = zip(*(outcome.readings for outcome in own), strict=True)
            for column in readings:
                facts = [(r.violated, r.open, r.violated or r.triggered > 0) for r in column]
                if column[0].kind is not Kind.REPORTED:
                    self._counted[key, column[0].requirement, column[0].kind] = np.array(facts, np.int64)

    def p(self, chosen: NDArray[np.int64], others: NDArray[np.int64], kind: Kind) -> dict[str, float]:
        """Adjusted p per requirement of some flights, judged as a mutant beside some others as the pool."""
        counts = {
            (key, name): Pair(key, name, own, len(others), *map(int, facts[others].sum(axis=0)))
            for (key, name, own), facts in self._counted.items()
            if own is kind
        }
        samples = [Sample(key, tuple(own[i] for i in chosen), infected=True) for key, own in self._violated.items()]
        pool = Pool(counts)
        return adjusted(samples, pool, pool.requirements(kind))
