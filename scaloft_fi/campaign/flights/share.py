"""Fly a baseline once and watch its mutants; fly each mutant only from the moment at which it leaves the baseline.

Mutants that leave the baseline at take-off are flown whole, all in one other process.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

from scaloft_fi.campaign.flight import Batch, Flight
from scaloft_fi.campaign.flights.fly import invalid, judged, reason_of, wire_of
from scaloft_fi.campaign.flights.fork import Fork
from scaloft_fi.judge.outcome import Outcome, Subject

if TYPE_CHECKING:
    from scaloft_fi.mutants.wire import SeamCount
    from scaloft_fi.study import Study

SOON_S = 1.0
"""A mutant that leaves the baseline earlier is flown whole, which is faster than a fork [s from take-off]."""


def fly_shared(
    study: Study, batch: Batch, report: Callable[[Outcome], None], fly_apart: Callable[[Flight], Iterable[Outcome]]
) -> None:
    """Fly a shared batch; every outcome equals that of the flight flown alone from take-off.

    Args:
        study: the study.
        batch: the flights.
        report: receives the outcome of each flight as soon as it is known.
        fly_apart: flies one flight from take-off in another process.

    Raises:
        Exception: the baseline failed in the harness; outcomes that were reported before are valid.
    """
    from scaloft_fi.mutants.watch import WatchingWire
    from scaloft_fi.mutants.wire import TappedWire
    from scaloft_fi.sim.flight import fly

    mutants = {flight.name: flight for flight in batch.flights if flight.mutant is not None}
    wires = {name: wire_of(study, flight) for name, flight in mutants.items()}
    fork, carrier = Fork(report, invalid), batch.carrier

    def branch(name: str, t_s: float) -> bool:
        if t_s >= SOON_S:
            return fork(mutants[name])
        for outcome in fly_apart(mutants[name]):
            report(outcome)
        return False

    wire = WatchingWire(
        {name: tapped for name, tapped in wires.items() if isinstance(tapped, TappedWire)},
        branch=branch,
        failed=lambda name, error: report(invalid(mutants[name], reason_of(error))),
    )
    try:
        log = fly(study.sim, carrier.situation, carrier.seed, wire)
        outcome = judged(study, fork.taken or carrier, log)
    except BaseException as error:
        if fork.taken is not None:
            fork.end(invalid(fork.taken, reason_of(error)))
        raise
    fork.end(outcome)
    for flight in batch.flights:
        if flight.mutant is None:
            report(outcome)
        elif flight.name in wire.silent:
            report(as_baseline(outcome, flight.subject, wire.silent[flight.name]))


def as_baseline(baseline: Outcome, subject: Subject, counts: Mapping[str, SeamCount]) -> Outcome:
    """The outcome of a mutant without an altered sample: the outcome of its baseline, with the mutant's counts."""
    carried = sum(count.carried for count in counts.values())
    return replace(baseline, subject=subject, carried=carried, altered=0, infected_at_s=None, realised=())
