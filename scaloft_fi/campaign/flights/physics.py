"""The flyer that simulates flights in PyBullet."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from threading import Timer
from typing import TYPE_CHECKING

from scaloft_fi.campaign.flights.fly import fly_log, judged
from scaloft_fi.campaign.flights.share import fly_shared
from scaloft_fi.campaign.flights.worker import Worker, left_of, lost
from scaloft_fi.campaign.plan.batch import Batch
from scaloft_fi.campaign.plan.flight import Flight
from scaloft_fi.campaign.processes.patience import PATIENCE_S
from scaloft_fi.campaign.processes.pool import Pool
from scaloft_fi.judge.outcome import Outcome

if TYPE_CHECKING:
    from scaloft_fi.study import Study

KERNELS_S = 5.0
"""Length of the trial flight; by then the drone has climbed and plans, so every kernel was called [s]."""
NOTICE_S = 1.0
"""A preparation that takes longer prints a notice [s, wall]."""


class Physics:
    """Flies in PyBullet."""

    def prepare(self, study: Study, say: Callable[[str], None]) -> None:
        """Build the stack, compile its kernels and parse the formulas: fly and judge a few seconds.

        Processes that are forked afterwards inherit all of it.

        Raises:
            InputError: the settings of the stack do not fit.
        """
        with stderr_silenced():
            import pybullet  # noqa: F401 - its first import writes to standard error
        from scaloft_fi.sim import flight
        from scaloft_fi.stack.declaration import TICK_HZ, PlainWire

        notice = Timer(NOTICE_S, say, ["compiling kernels (first run only)"])
        notice.start()
        try:
            first = study.grid.situations[0]
            with flight.physics_server() as client:
                rehearsed = study.stack.rehearsed
                trial = flight.FlightLoop(client, study.sim, study.scenario(first), 0, PlainWire(), rehearsed)
                trial.step()
                for _ in range(round(KERNELS_S * TICK_HZ)):
                    trial.tick()
                    trial.advance()
                judged(study, Flight(None, first, 0), trial.log())
        finally:
            notice.cancel()
            notice.join()

    def __call__(self, study: Study, flight: Flight) -> Outcome:
        """Fly and judge one flight from take-off; with a stack that does not fork, in a process of its own."""
        if study.stack.forks:
            return judged(study, flight, fly_log(study, flight))
        with Pool(_Apart(study), 1, left=left_of, lost=lost, patience_s=PATIENCE_S) as apart:
            (outcome,) = apart.map([Batch((flight,))])
        return outcome

    def share(self, study: Study, batch: Batch, report: Callable[[Outcome], None]) -> None:
        """Fly the baseline once, and each mutant from the moment at which it leaves the baseline."""
        # in a process of its own, so that a crash loses one flight only
        with Pool(Worker(study, self), 1, left=left_of, lost=lost, patience_s=PATIENCE_S) as apart:
            fly_shared(study, batch, report, lambda flight: apart.map([Batch((flight,))]))


@dataclass(frozen=True)
class _Apart:
    """The work of a process that flies one flight and ends, with whatever threads the stack has started in it."""

    study: Study

    def __call__(self, batch: Batch, report: Callable[[Outcome], None]) -> None:
        for flight in batch.flights:
            report(judged(self.study, flight, fly_log(self.study, flight)))


@contextmanager
def stderr_silenced() -> Iterator[None]:
    """Drop what C code writes to standard error."""
    saved, nowhere = os.dup(2), os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 2)
    try:
        yield
    finally:
        os.dup2(saved, 2)
        os.close(saved)
        os.close(nowhere)
