"""Worker processes that are new interpreters, for a process with threads, such as that of a notebook."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from scaloft_fi.campaign.flights.worker import Flyer, left_of, lost
from scaloft_fi.campaign.plan.batch import Batch
from scaloft_fi.campaign.processes.pool import Pool
from scaloft_fi.campaign.processes.start import started_clean
from scaloft_fi.campaign.workers.executor import Workers
from scaloft_fi.campaign.workers.late_worker import LateWorker
from scaloft_fi.campaign.workers.local import LocalWorkers, patience_s
from scaloft_fi.study import Study


@dataclass(frozen=True)
class Clean:
    """`jobs` new interpreters on this machine.

    A fork of a process with threads may hang, and its numeric libraries may use more than one thread.  A new
    interpreter has neither, and the module of the user's script is not imported again in it.
    """

    jobs: int

    @contextmanager
    def workers(
        self, study: Study, flyer: Flyer, *, stop: Callable[[], bool], say: Callable[[str], None]
    ) -> Iterator[Workers]:
        """Start a pool; each process reads the study and is prepared at its first task."""
        work = LateWorker(study.folder, study.grid_name, flyer, study.inputs)
        with Pool(
            work, self.jobs, left=left_of, lost=lost, stop=stop, patience_s=patience_s(study), start=started_clean
        ) as pool:
            # an empty batch prepares the first process, which compiles the kernels for all of them
            yield LocalWorkers(pool, lambda: list(pool.map([Batch(())])))
