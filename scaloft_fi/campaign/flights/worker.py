"""Turn batches into outcomes; a flight that fails in the harness is tried again, then it is `invalid`."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Protocol

from scaloft_fi.campaign.flights.fly import invalid, reason_of
from scaloft_fi.campaign.plan.batch import Batch
from scaloft_fi.campaign.plan.flight import Flight
from scaloft_fi.campaign.processes.patience import ATTEMPTS
from scaloft_fi.errors import InputError
from scaloft_fi.judge.outcome import Outcome

if TYPE_CHECKING:
    from scaloft_fi.study import Study


class Flyer(Protocol):
    """Turns planned flights into outcomes."""

    def prepare(self, study: Study, say: Callable[[str], None]) -> None:
        """Prepare in the parent process what every worker needs.

        Raises:
            InputError: the study cannot be flown.
        """
        ...

    def __call__(self, study: Study, flight: Flight) -> Outcome:
        """Fly and judge one flight from take-off; a failure of the harness is raised."""
        ...

    def share(self, study: Study, batch: Batch, report: Callable[[Outcome], None]) -> None:
        """Fly and judge the flights of a shared batch; a failure of the harness in the baseline is raised."""
        ...


class Worker:
    """The work of one process: a callable that raises for a wrong study, never for a single flight.

    Args:
        study: the study, opened in the parent process; a forked worker shares it.
        flyer: flies.
    """

    def __init__(self, study: Study, flyer: Flyer) -> None:
        self.study, self.flyer = study, flyer

    def __call__(self, batch: Batch, report: Callable[[Outcome], None]) -> None:
        """Report the outcome of every flight of `batch`; a flight that fails in the harness is tried twice more.

        Raises:
            InputError: the study cannot be flown.
        """
        if batch.shared:
            self._share(batch, report)
            return
        for flight in batch.flights:
            report(self._alone(flight))

    def _alone(self, flight: Flight) -> Outcome:
        reason = ""
        for _ in range(ATTEMPTS):
            try:
                return self.flyer(self.study, flight)
            except InputError:
                raise
            except Exception as error:  # noqa: BLE001 - any failure of the harness is reported as invalid, never as a verdict
                reason = reason_of(error)
        return invalid(flight, reason)

    def _share(self, batch: Batch, report: Callable[[Outcome], None]) -> None:
        known: set[str] = set()

        def note(outcome: Outcome) -> None:
            known.add(outcome.name)
            report(outcome)

        reason = ""
        for _ in range(ATTEMPTS):
            left = batch.without(known)
            if left is None:
                return
            try:
                self.flyer.share(self.study, left, note)
            except InputError:
                raise
            except Exception as error:  # noqa: BLE001 - as above
                reason = reason_of(error)
        left = batch.without(known)
        for flight in left.flights if left else ():
            report(invalid(flight, f"its baseline: {reason}"))


def lost(batch: Batch, reason: str) -> list[Outcome]:
    """The outcomes of flights whose worker process died every time."""
    return [invalid(flight, f"its worker process {reason}") for flight in batch.flights]


def left_of(batch: Batch, outcomes: Iterable[Outcome]) -> Batch | None:
    """The flights of a batch without an outcome; None without any."""
    return batch.without({outcome.name for outcome in outcomes})
