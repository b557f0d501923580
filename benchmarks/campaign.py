"""Measure the savings by sharing and the speed of a second process on a sample of the default catalogue.

    python benchmarks/campaign.py [--situation KEY|GLOB]... [--every N] [--whole]

sim_s_shared: simulated seconds when mutants share their baseline up to the first altered sample, counted in the flight
loop of every process.  sim_s_unavoidable: simulated seconds of baselines and PLACEBO, and of each other flight from its
first altered sample on.  sim_s_brute: simulated seconds when every flight is flown whole.  digests_equal: whether both
ways give the same outcomes, field for field.  flights_per_s and efficiency: outcomes per second of wall time with 1 and
with 2 processes, the faster of two runs each, in turn (of one run with --whole).  cpu_s: processor time of these runs,
which is comparable on a busy machine.
"""

from __future__ import annotations

import checkout  # first: it sets the path and the threads

# isort: split

import mmap
import resource
import struct
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from operator import itemgetter
from typing import Any
from unittest.mock import patch

from scaloft_fi.campaign.flights.fly import Batch, Worker, left_of, lost
from scaloft_fi.campaign.flights.physics import Physics
from scaloft_fi.campaign.plan import alone, plan, together
from scaloft_fi.campaign.processes import ProcessPool
from scaloft_fi.judge.outcome import BASELINE, Outcome
from scaloft_fi.mutants.catalogue import defaults
from scaloft_fi.mutants.mutant import PLACEBO
from scaloft_fi.sim import flight as flight_module
from scaloft_fi.study import Study

SITUATIONS = ("T0O0W0D0H1", "T0O1W0D1H0")
ROUNDS = 2
"""Number of runs of which the fastest counts, because other load can only slow a run down."""


class TickCounter:
    """Counts the ticks that this process and its forked processes fly."""

    def __init__(self) -> None:
        self._memory = mmap.mmap(-1, 8)

    @property
    def ticks(self) -> int:
        """Number of ticks so far."""
        return int(struct.unpack("q", self._memory[:8])[0])

    @contextmanager
    def counting(self) -> Iterator[None]:
        """Count every tick in this context; one process flies at a time."""
        tick: Callable[[Any], bool] = flight_module.FlightLoop.tick

        def counted(flight: Any) -> bool:
            goes_on = tick(flight)
            if goes_on:
                self._memory[:8] = struct.pack("q", self.ticks + 1)
            return goes_on

        with patch.object(flight_module.FlightLoop, "tick", counted):
            yield


def flown(study: Study, batches: Sequence[Batch], jobs: int) -> tuple[dict[str, Outcome], float, float]:
    """The outcomes of `batches` by name, and the wall time and the processor time they took [s]."""
    begin_s, begin_cpu_s = time.perf_counter(), cpu_s()
    with ProcessPool(Worker(study, Physics()), jobs, left=left_of, lost=lost) as pool:
        outcomes = {outcome.name: outcome for outcome in pool.map(batches)}
    return outcomes, time.perf_counter() - begin_s, cpu_s() - begin_cpu_s


def cpu_s() -> float:
    """Processor time of all processes that this one has started and that have ended [s]."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def unavoidable_s(outcomes: Sequence[Outcome]) -> float:
    """Simulated time that sharing cannot save [s]."""
    total_s = 0.0
    for outcome in outcomes:
        if outcome.mutant in (BASELINE, PLACEBO.id):
            total_s += outcome.duration_s
        elif outcome.infected_at_s is not None:
            total_s += outcome.duration_s - outcome.infected_at_s
    return total_s


def measure(study: Study, keys: Sequence[str], every: int, rounds: int) -> dict[str, Any]:
    """All figures; one and two processes fly `rounds` times in turn."""
    planned = plan(study.grid.select(keys), (0,), defaults(study.matrix)[::every], None)
    flights = (*planned.baselines, *planned.mutants)
    weight_s = {flight.name: study.expected_s(flight.situation) for flight in flights}

    def batches(jobs: int) -> list[Batch]:
        return together(flights, lambda flight: weight_s[flight.name], jobs)

    counter = TickCounter()
    with counter.counting():
        counted = flown(study, batches(1), 1)
    ones, twos = [counted], [flown(study, batches(2), 2)]
    for _ in range(rounds - 1):
        ones.append(flown(study, batches(1), 1))
        twos.append(flown(study, batches(2), 2))
    (shared, one_s, one_cpu_s), (_, two_s, two_cpu_s) = (min(runs, key=itemgetter(1)) for runs in (ones, twos))
    brute, brute_s, brute_cpu_s = flown(study, alone(flights), 1)
    unavoidable = unavoidable_s(list(brute.values()))
    shared_s = counter.ticks / 20
    per_s = {"1": len(flights) / one_s, "2": len(flights) / two_s}
    return {
        "situations": len(planned.baselines),
        "flights": len(flights),
        "sim_s_shared": round(shared_s, 2),
        "sim_s_unavoidable": round(unavoidable, 2),
        "sim_s_brute": round(sum(outcome.duration_s for outcome in brute.values()), 2),
        "shared_over_unavoidable": round(shared_s / unavoidable, 4),
        "wall_s": {"brute": round(brute_s, 1), "1": round(one_s, 1), "2": round(two_s, 1)},
        "cpu_s": {"brute": round(brute_cpu_s, 1), "1": round(one_cpu_s, 1), "2": round(two_cpu_s, 1)},
        "digests_equal": all(outcomes == brute for outcomes, _, _ in (*ones, *twos)),
        "not_infected": sum(not outcome.altered for outcome in shared.values()),
        "invalid": sum(bool(outcome.invalid) for outcome in shared.values()),
        "flights_per_s": {jobs: round(rate, 2) for jobs, rate in per_s.items()},
        "efficiency": round(per_s["2"] / per_s["1"] / 2, 3),
    }


def main() -> None:
    """Measure and print."""
    parser = checkout.parser(__doc__)
    parser.add_argument("--situation", action="append", default=[], help="key or glob, repeatable")
    parser.add_argument("--every", type=int, default=4, help="fly every N-th default mutant (default: 4)")
    parser.add_argument("--whole", action="store_true", help="every default in every situation: an hour and a half")
    options = parser.parse_args()
    study = Study.open(None)
    Physics().prepare(study, lambda text: print(text, file=sys.stderr))
    keys = options.situation or ([] if options.whole else SITUATIONS)
    every, rounds = (1, 1) if options.whole else (options.every, ROUNDS)
    figures = measure(study, keys, every, rounds)
    checkout.tell(figures)


if __name__ == "__main__":
    main()
