"""What is handed to a worker in one go: a flight, or the flights that share one baseline's beginning."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace

from scaloft_fi.campaign.plan.flight import Flight
from scaloft_fi.mutants.mutant import PLACEBO


@dataclass(frozen=True)
class Batch:
    """Flights of one situation and seed.

    Attributes:
        flights: whose outcomes are wanted.
        shared: whether they are flown together with the baseline, each from where it leaves it; else each is whole.
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
        """What is left when the flights called `names` have arrived; None = nothing."""
        left = tuple(flight for flight in self.flights if flight.name not in names)
        return replace(self, flights=left) if left else None
