"""The flyer of a study whose flights a command flies."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from scaloft_fi.campaign.flights.fly import fly_log, judged
from scaloft_fi.campaign.flights.worker import Worker
from scaloft_fi.campaign.plan.batch import Batch
from scaloft_fi.campaign.plan.flight import Flight
from scaloft_fi.judge.outcome import Outcome

if TYPE_CHECKING:
    from scaloft_fi.study import Study


@dataclass(frozen=True)
class Commanded:
    """Flies with the command of the study, each flight alone."""

    def prepare(self, study: Study, say: Callable[[str], None]) -> None:
        """Prove before the first flight what would fail in each, and parse the formulas.

        Raises:
            InputError: the study cannot be flown.
        """
        from scaloft_fi.campaign.flights.command_check import check_command

        assert study.command is not None
        check_command(study, study.command, say)

    def __call__(self, study: Study, flight: Flight) -> Outcome:
        """Fly and judge one flight; a failure of the command is raised."""
        return judged(study, flight, fly_log(study, flight))

    def share(self, study: Study, batch: Batch, report: Callable[[Outcome], None]) -> None:
        """Fly each flight alone: nobody can fork a simulator of somebody else's."""
        alone = Worker(study, self)
        for flight in batch.flights:
            alone(Batch((flight,)), report)
