"""Fork the process where a mutant's flight leaves its baseline; the child has the whole state, bit for bit."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable
from contextlib import suppress
from multiprocessing import Pipe
from multiprocessing.connection import Connection

from scaloft_fi.campaign.flight import Flight
from scaloft_fi.campaign.processes import ATTEMPTS, LINUX, PATIENCE_S, cause_of_death, die_with
from scaloft_fi.judge.outcome import Outcome

CAN_FORK = LINUX
"""On other systems a fork with numeric libraries loaded is not safe, and every flight is flown whole."""


class Fork:
    """Forks flights off the flight of this process.

    The trunk is the process that flies the baseline.  It waits for each child, so one process computes at a time.

    Args:
        report: receives the outcome of each forked flight.
        invalid: makes the outcome of a flight that failed in the harness, from the flight and the reason.
        patience_s: a child without an outcome after this time is hung [s, wall].

    Attributes:
        taken: in a child, the flight that it flies; None in the trunk.
    """

    def __init__(
        self,
        report: Callable[[Outcome], None],
        invalid: Callable[[Flight, str], Outcome],
        patience_s: float = PATIENCE_S,
    ) -> None:
        self.taken: Flight | None = None
        self._report, self._invalid, self._patience_s = report, invalid, patience_s
        self._writer: Connection | None = None

    def __call__(self, flight: Flight) -> bool:
        """Fork `flight`.  Returns True in the child, which flies on, and False in the trunk after the outcome's report.

        A flight that fails in the harness is tried again from the same state.
        """
        attempts = ATTEMPTS
        while True:
            attempts -= 1
            try:
                outcome = self._split(flight)
            except OSError as error:
                outcome = self._invalid(flight, f"its process could not be started: {error.strerror}")
            if outcome is None:
                return True
            if not (outcome.invalid and attempts):
                self._report(outcome)
                return False

    def end(self, outcome: Outcome) -> None:
        """In a child, send its outcome to the trunk and end the process; in the trunk, do nothing."""
        if self._writer is not None:
            try:
                with suppress(OSError):  # the trunk has ended, or has stopped waiting
                    self._writer.send(outcome)
            finally:
                os._exit(0)

    def _split(self, flight: Flight) -> Outcome | None:
        """Fork once; returns None in the child, and the child's outcome in the trunk."""
        reader, writer = Pipe(duplex=False)
        trunk = os.getpid()
        child = os.fork()
        if not child:
            die_with(trunk)
            reader.close()
            self.taken, self._writer = flight, writer
            return None
        writer.close()
        try:
            outcome, reason = self._listen(reader)
        finally:
            os.kill(child, signal.SIGKILL)  # the child has sent its outcome, is hung, or is a zombie
            _, status = os.waitpid(child, 0)
            reader.close()
        return outcome or self._invalid(flight, reason or f"its process died: {cause_of_death(status)}")

    def _listen(self, reader: Connection) -> tuple[Outcome | None, str]:
        if not reader.poll(self._patience_s):
            return None, f"it hung: no end in {self._patience_s:g} s of wall time"
        try:
            return reader.recv(), ""
        except (EOFError, OSError):
            return None, ""
