"""A batch: the task of a worker, either one flight or flights that share the beginning of one baseline."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace

from scaloft_fi.campaign.plan.flight import Flight
from scaloft_fi.mutants.mutant import PLACEBO


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
