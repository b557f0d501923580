"""What is known of one survivor: its flights, what it lost, where it infects, what its seam carries."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

from scaloft_fi.results.flights import Flight, flights_of
from scaloft_fi.results.kills.background import Background
from scaloft_fi.results.kills.condition import condition
from scaloft_fi.results.kills.kill_matrix import KillMatrix, Row
from scaloft_fi.results.kills.near_miss import Loss, losses, off_path_m
from scaloft_fi.results.outcome import BASELINE, Outcome
from scaloft_fi.results.requirement import Kind
from scaloft_fi.results.roster import cell_of
from scaloft_fi.results.space import Space
from scaloft_fi.results.status import Status


@dataclass(frozen=True)
class Campaign:
    """The flights, by mutant, and what the baselines and the other faults of a seam show."""

    space: Space
    flights: Mapping[str, Sequence[Flight]]
    baselines: Sequence[Outcome]
    carrying: Mapping[str, frozenset[str]]
    """Per seam the situations where it carried a sample in some flight."""
    units: Mapping[str, str]

    @classmethod
    def of(
        cls,
        outcomes: Iterable[Outcome],
        matrix: KillMatrix,
        backgrounds: Mapping[str, Background],
        units: Mapping[str, str],
    ) -> Campaign:
        """From outcomes, with or without trajectories; invalid flights say nothing."""
        listed = list(outcomes)
        flights: dict[str, list[Flight]] = {row.id: [] for row in matrix.rows}
        for flight in flights_of(listed):
            if flight.status is not Status.INVALID:
                flights.setdefault(flight.outcome.mutant, []).append(flight)
        carrying: dict[str, set[str]] = {}
        for id_, background in backgrounds.items():
            reached = {flight.outcome.situation for flight in flights.get(id_, ()) if flight.outcome.carried}
            carrying.setdefault(background.seam, set()).update(reached)
        return cls(
            space=matrix.space,
            flights=flights,
            baselines=[o for o in listed if o.mutant == BASELINE and not o.invalid],
            carrying={seam: frozenset(keys) for seam, keys in carrying.items()},
            units=units,
        )

    @cached_property
    def kinds(self) -> Mapping[str, Kind]:
        """Of each requirement."""
        return {reading.requirement: reading.kind for baseline in self.baselines for reading in baseline.readings}

    def where(self, true: Callable[[str], bool], known: Iterable[str]) -> str:
        """In words, the situations of `known` of which something is true."""
        among = {key for key in known if key in self.space.point}
        holds = {key for key in among if true(key)}
        return condition(self.space, holds, among - holds) or "nowhere"


@dataclass(frozen=True)
class Case:
    """One survivor and its flights."""

    campaign: Campaign
    row: Row
    background: Background

    @property
    def flights(self) -> Sequence[Flight]:
        """Those that count."""
        return self.campaign.flights.get(self.row.id, ())

    @cached_property
    def flown(self) -> frozenset[str]:
        """Situations with a flight of it that counts."""
        return frozenset(flight.outcome.situation for flight in self.flights)

    @cached_property
    def infected(self) -> frozenset[str]:
        """Those where it changes a sample."""
        return frozenset(flight.outcome.situation for flight in self.flights if flight.status.infected)

    @cached_property
    def eligible(self) -> tuple[Flight, ...]:
        """Flights that could have killed."""
        return tuple(flight for flight in self.flights if flight.eligible)

    @cached_property
    def loss(self) -> Loss | None:
        """The greatest share of a margin lost in an eligible flight; the first of equals."""
        return max((loss for f in self.eligible for loss in losses(f)), key=lambda loss: loss.share, default=None)

    @cached_property
    def off_path_m(self) -> float:
        """How far an eligible flight was off its baseline's path at the most [m]."""
        return max((off_path_m(flight) for flight in self.eligible if flight.status is Status.SURVIVED), default=0.0)

    @property
    def left(self) -> str:
        """What of the grid is left to fly."""
        left = len(self.campaign.space.points) - len(self.flown)
        return f"{left} situations of the grid were not flown." if left else "no situation of the grid does: add one."

    @property
    def infected_where(self) -> str:
        """The situations where it changes a sample, in words."""
        return self.campaign.where(self.infected.__contains__, self.flown)

    @property
    def larger(self) -> str:
        """What to do where a larger fault may kill."""
        return (
            f"the next rung is {self.background.stronger[0]}; "
            f"`scaloft-fi margin {cell_of(self.row.id)}` searches the least magnitude that kills."
        )
