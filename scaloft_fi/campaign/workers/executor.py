"""The protocols of an executor and of its workers, which fly a run."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import AbstractContextManager
from typing import Protocol

from scaloft_fi.campaign.flights.worker import Flyer
from scaloft_fi.campaign.plan.batch import Batch
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.study import Study


class Workers(Protocol):
    """The workers of one run."""

    @property
    def jobs(self) -> int:
        """Number of processes for which batches are arranged."""
        ...

    def ready(self) -> None:
        """Prepare the workers for flights; `map` calls it if necessary.

        Raises:
            InputError: the study cannot be flown.
        """
        ...

    def map(self, batches: Iterable[Batch]) -> Iterator[Outcome]:
        """Yield the outcomes of `batches` as they arrive, in any order.

        A batch whose worker dies is tried again in another worker; flights that fail every time are `invalid`.

        Raises:
            ScaloftError: the study cannot be flown, or no worker is left.
        """
        ...


class Executor(Protocol):
    """Starts workers."""

    def workers(
        self, study: Study, flyer: Flyer, *, stop: Callable[[], bool], say: Callable[[str], None]
    ) -> AbstractContextManager[Workers]:
        """Start workers for `study`; they end with the context.

        Args:
            study: the study.
            flyer: flies.
            stop: polled; once true, no batch begins, and `map` ends soon.
            say: prints a line for the user.

        Raises:
            InputError: no worker can be started.
        """
        ...
