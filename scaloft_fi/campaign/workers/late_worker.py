"""The work of a process that is a new interpreter: it reads the study itself, since it inherits nothing."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from scaloft_fi.campaign.flights.worker import Flyer, Worker
from scaloft_fi.campaign.plan.batch import Batch
from scaloft_fi.errors import InputError
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.study import Study


@dataclass
class LateWorker:
    """The work of a new process: it opens the study when it gets its first batch.

    Attributes:
        folder, grid_name: of the study.
        flyer: flies.
        inputs: hashes of the study that the run has read; None where others have compared them.
    """

    folder: Path
    grid_name: str | None
    flyer: Flyer
    inputs: Mapping[str, str] | None = None
    _worker: Worker | None = None

    def __call__(self, batch: Batch, report: Callable[[Outcome], None]) -> None:
        """Fly one batch.

        Raises:
            InputError: the study cannot be flown, or has changed since the run has read it.
        """
        if self._worker is None:
            study = Study.open(self.folder, self.grid_name)
            if self.inputs is not None and self.inputs != study.inputs:
                raise InputError(f"{self.folder}: the study has changed since the run began; run again")
            self.flyer.prepare(study, lambda _text: None)
            self._worker = Worker(study, self.flyer)
        self._worker(batch, report)
