"""What is known of one survivor: its flights, what it lost, where it infects, what its seam carries."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

from scaloft_fi.analysis.condition import condition
from scaloft_fi.analysis.kills.background import Background
from scaloft_fi.analysis.kills.kill_matrix import KillMatrix, KillRow
from scaloft_fi.analysis.kills.near_miss import Loss, losses, off_path_m
from scaloft_fi.analysis.scoring.mutant_score import MutantScore
from scaloft_fi.analysis.scoring.pool import Pool, State
from scaloft_fi.analysis.scoring.score import Score
from scaloft_fi.defaults import CAMPAIGN
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.judge.requirement import Kind
from scaloft_fi.judge.space import Space
from scaloft_fi.judge.status import JudgedFlight, Status, flights_of


@dataclass(frozen=True)
class Campaign:
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
    ) -> Campaign:
        """From outcomes, with or without trajectories, and their score; invalid flights say nothing."""
        flights: dict[str, list[JudgedFlight]] = {row.id: [] for row in matrix.rows}
        for flight in flights_of(outcomes):
            if flight.status is not Status.INVALID:
                flights.setdefault(flight.outcome.mutant, []).append(flight)
        carrying: dict[str, set[str]] = {}
        for id_, background in backgrounds.items():
            reached = {flight.outcome.situation for flight in flights.get(id_, ()) if flight.outcome.carried}
            carrying.setdefault(background.seam, set()).update(reached)
        return cls(
            space=matrix.space,
            pool=scored.pool,
            scores={mutant.subject.id: mutant for mutant in scored.mutants},
            flights=flights,
            carrying={seam: frozenset(keys) for seam, keys in carrying.items()},
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


@dataclass(frozen=True)
class Case:
    """One survivor and its flights."""

    campaign: Campaign
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
