"""Arrange flights in batches, in the order in which the workers get them."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence

from scaloft_fi.campaign.plan.batch import Batch
from scaloft_fi.campaign.plan.flight import Flight
from scaloft_fi.mutants.mutant import PLACEBO

SHARES_PER_JOB = 2
"""A batch is at most 1 / this of the remaining work of one process, so that all processes end at about one time."""
LEAST_SHARING = 8
"""A baseline is flown once more for another process only if at least this number of mutants share it."""


def alone(flights: Iterable[Flight]) -> list[Batch]:
    """One batch for each flight, flown whole."""
    return [Batch((flight,)) for flight in flights]


def together(flights: Sequence[Flight], weight_s: Callable[[Flight], float], jobs: int) -> list[Batch]:
    """Batches of mutants with the baseline of their situation and seed; a baseline outside `flights` is flown again.

    Batches get smaller towards the end (Polychronopoulos and Kuck, Guided self-scheduling, IEEE Trans. Computers
    36(12), 1987): the duration of a flight is unknown beforehand, and small last batches balance the processes.

    Args:
        flights: the flights.
        weight_s: expected duration of a flight [s].
        jobs: number of processes; several processes fly a baseline with many mutants if that keeps them busy.

    Returns:
        The batches; the longest batch is first.
    """
    batches = alone(flight for flight in flights if flight.mutant == PLACEBO)
    sharing: list[tuple[float, Flight, list[Flight]]] = []
    for baseline, mutants in _by_baseline(flights).items():
        if len(mutants) == 1 and baseline not in flights:  # the baseline would cost more than it saves
            batches += alone(mutants)
        else:
            sharing.append((weight_s(baseline) * (1 + len(mutants)), baseline, mutants))

    def whole_s(batch: Batch) -> float:
        return sum(map(weight_s, batch.flights))

    left_s = sum(map(whole_s, batches)) + sum(own_s for own_s, _, _ in sharing)
    for own_s, baseline, mutants in sorted(sharing, key=lambda entry: entry[0], reverse=True):
        most = len(mutants) // LEAST_SHARING if jobs > 1 else 1
        pieces = max(1, min(most, math.ceil(own_s * SHARES_PER_JOB * jobs / left_s) if left_s else 1))
        batches += [Batch((baseline, *mutants[piece::pieces]), shared=True) for piece in range(pieces)]
        left_s -= own_s
    return sorted(batches, key=whole_s, reverse=True)


def _by_baseline(flights: Iterable[Flight]) -> dict[Flight, list[Flight]]:
    """The mutants by their baseline, without PLACEBO, which shares no baseline."""
    draws: dict[Flight, list[Flight]] = {}
    for flight in flights:
        if flight.mutant != PLACEBO:
            mutants = draws.setdefault(Flight(None, flight.situation, flight.seed), [])
            if flight.mutant is not None:
                mutants.append(flight)
    return draws
