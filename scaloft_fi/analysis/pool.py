"""The baseline pool: what the unmutated drone does in each situation, and so which pairs put a fault to the test."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from functools import cached_property

from scaloft_fi.judge.outcome import BASELINE, Outcome, Violation
from scaloft_fi.judge.requirement import Compliance, Kind, Reading, measured_rho
from scaloft_fi.judge.space import Space

LEAST = 10
"""Baseline flights that a situation needs before its pairs have a state."""


class State(StrEnum):
    """What the pool says of a requirement in a situation; the first that fits."""

    UNKNOWN = "unknown"
    """Fewer than ten baseline flights: a green one makes nothing steady."""
    VACUOUS = "vacuous"
    """Less than half of the flights trigger the requirement: nothing is tested by it."""
    OPEN = "open"
    """More than a tenth of the flights are cut short before the requirement is judged."""
    STEADY = "steady"
    """At least nine tenths hold it: here a fault is put to the test."""
    RED = "red"
    """Most violate it: the unmutated drone's own finding."""
    UNSTEADY = "unsteady"
    """Between: the unmutated drone holds it or not by chance."""


@dataclass(frozen=True)
class Pair:
    """A requirement in a situation, by the baseline flights that count.

    Attributes:
        situation: key of the situation.
        requirement: name of the requirement.
        kind: of the requirement.
        flights: of the baseline.
        violated: flights that violate the requirement.
        open: flights cut short before it was judged.
        triggered: flights in which its trigger came true, or that violate it.
    """

    KEYS = ("*", "state")

    situation: str
    requirement: str
    kind: Kind
    flights: int
    violated: int
    open: int
    triggered: int

    @cached_property
    def judged(self) -> int:
        """Flights that violate the requirement or hold it to their end: what a mutant's flights are compared with."""
        return self.flights - self.open

    @cached_property
    def state(self) -> State:
        """What the pool says."""
        if self.flights < LEAST:
            return State.UNKNOWN
        if 2 * self.triggered < self.flights:
            return State.VACUOUS
        if 10 * self.open > self.flights:
            return State.OPEN
        if 10 * (self.judged - self.violated) >= 9 * self.flights:
            return State.STEADY
        return State.RED if 2 * self.violated > self.flights else State.UNSTEADY

    @cached_property
    def tests(self) -> bool:
        """Whether the pair enters the stratified test: it is neither unknown nor vacuous nor open."""
        return self.state in (State.STEADY, State.RED, State.UNSTEADY)


@dataclass(frozen=True)
class Pool:
    """The pairs of a campaign.

    Attributes:
        pairs: by situation and requirement, requirements in the study's order; none of kind `reported`.
        by_seed: what each seed adds to `violated` and `judged` of the pairs in which it was flown.
    """

    pairs: Mapping[tuple[str, str], Pair]
    by_seed: Mapping[int, Mapping[tuple[str, str], tuple[int, int]]] = field(default_factory=dict)

    @classmethod
    def of(cls, baselines: Iterable[Outcome]) -> Pool:
        """The pool of baseline flights; invalid ones and flights of mutants say nothing."""
        counts: dict[tuple[str, str], list[int]] = {}
        by_seed: dict[int, dict[tuple[str, str], tuple[int, int]]] = {}
        kinds: dict[str, Kind] = {}
        for outcome in baselines:
            if outcome.subject.id != BASELINE or outcome.invalid:
                continue
            for reading in outcome.readings:
                if reading.kind is Kind.REPORTED:
                    continue
                kinds[reading.requirement] = reading.kind
                tally = counts.setdefault((outcome.situation, reading.requirement), [0, 0, 0, 0])
                tally[0] += 1
                tally[1] += reading.violated
                tally[2] += reading.open
                tally[3] += reading.violated or reading.triggered > 0
                place = outcome.situation, reading.requirement
                seeds = by_seed.setdefault(outcome.seed, {})
                violated, judged = seeds.get(place, (0, 0))
                seeds[place] = violated + reading.violated, judged + (not reading.open)
        pairs = {place: Pair(*place, kinds[place[1]], *tally) for place, tally in counts.items()}
        return cls(pairs, by_seed)

    @cached_property
    def states(self) -> Mapping[tuple[str, str], State]:
        """The state of each pair."""
        return {place: pair.state for place, pair in self.pairs.items()}

    @cached_property
    def _requirements(self) -> Mapping[str, Kind]:
        return {name: pair.kind for (_, name), pair in self.pairs.items()}

    def requirements(self, kind: Kind) -> tuple[str, ...]:
        """The requirements of a kind, in the study's order."""
        return tuple(name for name, own in self._requirements.items() if own is kind)

    def steady(self, situation: str, kind: Kind) -> tuple[str, ...]:
        """The requirements of a kind that are steady in a situation."""
        return self._steady.get((situation, kind), ())

    @cached_property
    def _steady(self) -> Mapping[tuple[str, Kind], tuple[str, ...]]:
        steady: dict[tuple[str, Kind], tuple[str, ...]] = {}
        for name, kind in self._requirements.items():
            for (situation, other), state in self.states.items():
                if other == name and state is State.STEADY:
                    steady[situation, kind] = (*steady.get((situation, kind), ()), name)
        return steady

    @cached_property
    def flown(self) -> frozenset[str]:
        """Situations with as many flights as a pool needs."""
        return frozenset(place[0] for place, state in self.states.items() if state is not State.UNKNOWN)


@dataclass(frozen=True)
class SituationBaseline:
    """A situation's baseline over the seeds.

    Attributes:
        situation: key of the situation.
        flown: baseline flights that count.
        violated: requirements that any of them violates, in the study's order.
        open: requirements left open by a flight cut short, and violated in none.
        vacuous: requirements whose trigger never came true in any.
        first: the earliest safety violation and its seed.
        red: flights that violate a safety requirement.
    """

    KEYS = ("situation", "violated")
    situation: str
    flown: int
    violated: tuple[str, ...]
    open: tuple[str, ...]
    vacuous: tuple[str, ...]
    first: tuple[Violation, int] | None
    red: int


def findings(outcomes: Iterable[Outcome], space: Space) -> tuple[SituationBaseline, ...]:
    """One finding per situation with a baseline that counts, in the grid's order."""
    flown: dict[str, list[Outcome]] = {}
    for outcome in outcomes:
        if outcome.mutant == BASELINE and not outcome.invalid:
            flown.setdefault(outcome.situation, []).append(outcome)
    return tuple(_finding(key, flown[key]) for key in sorted(flown, key=space.rank))


def _finding(situation: str, baselines: list[Outcome]) -> SituationBaseline:
    shown: dict[str, set[Compliance]] = {}
    for outcome in baselines:
        for reading in outcome.readings:
            shown.setdefault(reading.requirement, set()).add(reading.compliance)
    firsts = [(v, outcome.seed) for outcome in baselines if (v := outcome.first_violation)]
    return SituationBaseline(
        situation=situation,
        flown=len(baselines),
        violated=tuple(name for name, own in shown.items() if Compliance.VIOLATED in own),
        open=tuple(name for name, own in shown.items() if Compliance.OPEN in own and Compliance.VIOLATED not in own),
        vacuous=tuple(name for name, own in shown.items() if own == {Compliance.VACUOUS}),
        first=min(firsts, key=lambda pair: (pair[0].t_s, pair[1]), default=None),
        red=len(firsts),
    )


@dataclass(frozen=True)
class Tally:
    """A requirement over flights: how many of each compliance, how often it was triggered, the least robustness.

    The robustness is that of flights that put it to the test; None when none did.
    """

    requirement: str
    kind: Kind
    compliances: tuple[tuple[Compliance, int], ...]
    triggered: int
    least_rho: float | None


def tallies(outcomes: Iterable[Outcome]) -> tuple[Tally, ...]:
    """One tally per requirement over the baseline flights that count, in the study's order."""
    read: dict[str, list[Reading]] = {}
    for outcome in outcomes:
        if outcome.mutant == BASELINE and not outcome.invalid:
            for reading in outcome.readings:
                read.setdefault(reading.requirement, []).append(reading)
    return tuple(_tally(name, readings) for name, readings in read.items())


def _tally(name: str, readings: list[Reading]) -> Tally:
    compliances = [reading.compliance for reading in readings]
    return Tally(
        requirement=name,
        kind=readings[0].kind,
        compliances=tuple((compliance, compliances.count(compliance)) for compliance in Compliance),
        triggered=sum(reading.triggered for reading in readings),
        least_rho=min((rho for r in readings if (rho := measured_rho(r)) is not None), default=None),
    )
