"""A baseline flown once with its mutants watched alongside; each is flown only from where it leaves the baseline.

Those that leave it at take-off are flown whole, in another process that is the same for all of them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

from scaloft_fi.campaign.flights.fly import Physics, Worker, invalid, judged, left_of, lost, reason_of, wire_of
from scaloft_fi.campaign.flights.fork import Fork
from scaloft_fi.campaign.plan.task import Task
from scaloft_fi.campaign.workers.pool import PATIENCE_S, Pool
from scaloft_fi.judge.outcome import Outcome, Subject
from scaloft_fi.study import Study

if TYPE_CHECKING:
    from scaloft_fi.mutants.wire import SeamCount

SOON_S = 1.0
"""Who leaves the baseline sooner is flown whole: to be split off takes longer than so much flight [s from take-off]."""


def fly_shared(study: Study, task: Task, home: Callable[[Outcome], None]) -> None:
    """Fly a shared task; every outcome equals that of the flight flown from take-off by itself.

    Raises:
        Exception: the harness failed over the baseline; what was home before stands.
    """
    from scaloft_fi.mutants.watch import WatchingWire
    from scaloft_fi.mutants.wire import TappedWire
    from scaloft_fi.sim.flight import fly

    mutants = {flight.name: flight for flight in task.flights if flight.mutant is not None}
    wires = {name: wire_of(study, flight) for name, flight in mutants.items()}
    fork, carrier = Fork(home, invalid), task.carrier

    # who takes this other process with it takes no other flight
    with Pool(Worker(study, Physics()), 1, left=left_of, lost=lost, patience_s=PATIENCE_S) as apart:

        def branch(name: str, t_s: float) -> bool:
            if t_s >= SOON_S:
                return fork(mutants[name])
            for outcome in apart.map([Task((mutants[name],))]):
                home(outcome)
            return False

        wire = WatchingWire(
            {name: tapped for name, tapped in wires.items() if isinstance(tapped, TappedWire)},
            branch=branch,
            failed=lambda name, error: home(invalid(mutants[name], reason_of(error))),
        )
        try:
            log = fly(study.sim, carrier.situation, carrier.seed, wire)
            outcome = judged(study, fork.taken or carrier, log)
        except BaseException as error:
            if fork.taken is not None:
                fork.end(invalid(fork.taken, reason_of(error)))
            raise
        fork.end(outcome)
    for flight in task.flights:
        if flight.mutant is None:
            home(outcome)
        elif flight.name in wire.silent:
            home(as_baseline(outcome, flight.subject, wire.silent[flight.name]))


def as_baseline(baseline: Outcome, subject: Subject, counts: Mapping[str, SeamCount]) -> Outcome:
    """The outcome of a mutant of whose samples none ever differed: its baseline's, but for what its seams carried."""
    carried = sum(count.carried for count in counts.values())
    return replace(baseline, subject=subject, carried=carried, altered=0, infected_at_s=None, realised=())
