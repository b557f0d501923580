"""What is handed to a worker in one go: a flight, or the flights that share one baseline's beginning."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass, replace

from scaloft_fi.campaign.plan.plan import Flight
from scaloft_fi.mutants.mutant import PLACEBO

SHARES_PER_JOB = 2
"""A task is at most this part of what one process has still to do, so that all processes end at about the same time."""
LEAST_SHARING = 8
"""A baseline is flown once more for another process only when at least so many mutants share it."""


@dataclass(frozen=True)
class Task:
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

    def without(self, names: Collection[str]) -> Task | None:
        """What is left when the flights called `names` are home; None = nothing."""
        left = tuple(flight for flight in self.flights if flight.name not in names)
        return replace(self, flights=left) if left else None


def alone(flights: Iterable[Flight]) -> list[Task]:
    """Each flight whole and by itself."""
    return [Task((flight,)) for flight in flights]


def together(flights: Sequence[Flight], weight_s: Callable[[Flight], float], jobs: int) -> list[Task]:
    """Mutants with the baseline of their situation and seed, which is flown again when it is not among `flights`.

    Tasks get smaller towards the end (Polychronopoulos and Kuck, Guided self-scheduling, IEEE Trans. Computers 36(12),
    1987): how long a mutant flies is known only when it has flown, and small tasks last even that out.

    Args:
        flights: to be flown.
        weight_s: how long one is expected to take [s].
        jobs: number of processes; a baseline with many mutants is flown by several when that keeps them busy.

    Returns:
        The tasks, the longest first.
    """
    tasks = alone(flight for flight in flights if flight.mutant == PLACEBO)
    sharing: list[tuple[float, Flight, list[Flight]]] = []
    for baseline, mutants in _by_baseline(flights).items():
        if len(mutants) == 1 and baseline not in flights:  # the baseline would cost more than it saves
            tasks += alone(mutants)
        else:
            sharing.append((weight_s(baseline) * (1 + len(mutants)), baseline, mutants))

    def whole_s(task: Task) -> float:
        return sum(map(weight_s, task.flights))

    left_s = sum(map(whole_s, tasks)) + sum(own_s for own_s, _, _ in sharing)
    for own_s, baseline, mutants in sorted(sharing, key=lambda entry: entry[0], reverse=True):
        most = len(mutants) // LEAST_SHARING if jobs > 1 else 1
        pieces = max(1, min(most, math.ceil(own_s * SHARES_PER_JOB * jobs / left_s) if left_s else 1))
        tasks += [Task((baseline, *mutants[piece::pieces]), shared=True) for piece in range(pieces)]
        left_s -= own_s
    return sorted(tasks, key=whole_s, reverse=True)


def _by_baseline(flights: Iterable[Flight]) -> dict[Flight, list[Flight]]:
    """The mutants by the baseline they leave; PLACEBO leaves none."""
    draws: dict[Flight, list[Flight]] = {}
    for flight in flights:
        if flight.mutant != PLACEBO:
            mutants = draws.setdefault(Flight(None, flight.situation, flight.seed), [])
            if flight.mutant is not None:
                mutants.append(flight)
    return draws
