"""A planned flight (mutant, situation, seed), and a batch: one task of a worker."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from scaloft_fi.judge.outcome import Subject
from scaloft_fi.mutants.mutant import PLACEBO, Mutant

if TYPE_CHECKING:
    from scaloft_fi.sim.situation import Situation


@dataclass(frozen=True)
class Flight:
    """One planned flight.

    Attributes:
        mutant: the mutant; None = the baseline.
        situation, seed: situation and seed of the flight.
    """

    mutant: Mutant | None
    situation: Situation
    seed: int

    @property
    def subject(self) -> Subject:
        """The subject of the flight."""
        return Subject.of(self.mutant)

    @property
    def name(self) -> str:
        """`MUTANT/SITUATION/SEED`, the argument of `replay`."""
        return f"{self.subject.id}/{self.situation.key}/{self.seed}"


@dataclass(frozen=True)
class Batch:
    """Flights of one situation and seed.

    Attributes:
        flights: the flights.
        shared: whether the flights share the baseline, each up to the moment at which it leaves the baseline.
    """

    flights: tuple[Flight, ...]
    shared: bool = False

    def __post_init__(self) -> None:
        if self.shared and any(flight.mutant == PLACEBO for flight in self.flights):
            raise ValueError("PLACEBO is always flown whole")

    @property
    def carrier(self) -> Flight:
        """The baseline of the flights."""
        return Flight(None, self.flights[0].situation, self.flights[0].seed)

    def without(self, names: Collection[str]) -> Batch | None:
        """The batch without the flights called `names`; None if no flight remains."""
        left = tuple(flight for flight in self.flights if flight.name not in names)
        return replace(self, flights=left) if left else None
