"""What flies a run: the protocol of an executor and of its workers."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import AbstractContextManager
from typing import Protocol

from scaloft_fi.campaign.flights.worker import Flyer
from scaloft_fi.campaign.plan.batch import Batch
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.study import Study


class Workers(Protocol):
    """The processes that fly, while they run."""

    @property
    def jobs(self) -> int:
        """For how many processes the work is best cut."""
        ...

    def ready(self) -> None:
        """Do what has to be done before anything can be flown; done by `map` if need be.

        Raises:
            InputError: the study cannot be flown.
        """
        ...

    def map(self, batches: Iterable[Batch]) -> Iterator[Outcome]:
        """The outcomes of `batches`, each as it is known, in no order.

        A batch whose worker is lost is tried again elsewhere; flights that are lost every time are `invalid`.

        Raises:
            ScaloftError: the study cannot be flown, or no worker is left to fly it.
        """
        ...


class Executor(Protocol):
    """Starts workers."""

    def workers(
        self, study: Study, flyer: Flyer, *, stop: Callable[[], bool], say: Callable[[str], None]
    ) -> AbstractContextManager[Workers]:
        """The workers that fly `study` while the context lasts.

        Args:
            study: what is flown.
            flyer: what flies it.
            stop: asked now and then; once true, no more is begun, and `map` ends soon.
            say: takes a line for a person.

        Raises:
            InputError: no worker can be started.
        """
        ...
