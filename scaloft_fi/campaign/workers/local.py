"""Worker processes on this machine."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from scaloft_fi.campaign.flights.worker import Flyer, Worker, left_of, lost
from scaloft_fi.campaign.plan.batch import Batch
from scaloft_fi.campaign.processes.patience import ATTEMPTS
from scaloft_fi.campaign.processes.pool import WORKER_PATIENCE_S, Pool
from scaloft_fi.campaign.workers.executor import Workers
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.study import Study


@dataclass(frozen=True)
class Local:
    """`jobs` processes on this machine."""

    jobs: int

    @contextmanager
    def workers(
        self, study: Study, flyer: Flyer, *, stop: Callable[[], bool], say: Callable[[str], None]
    ) -> Iterator[Workers]:
        """Start a pool; each process is forked at its first task and inherits the prepared state."""
        # a command ends itself after its limit, before the pool takes its worker for hung
        limit_s = study.command.limit_s if study.command else 0.0
        patience_s = max(WORKER_PATIENCE_S, (ATTEMPTS + 1) * limit_s)
        with Pool(Worker(study, flyer), self.jobs, left=left_of, lost=lost, stop=stop, patience_s=patience_s) as pool:
            yield _LocalWorkers(pool, lambda: flyer.prepare(study, say))


class _LocalWorkers:
    """A pool that is prepared once."""

    def __init__(self, pool: Pool[Batch, Outcome], prepare: Callable[[], None]) -> None:
        self.jobs = pool.jobs
        self._pool, self._prepare = pool, prepare
        self._is_ready = False

    def ready(self) -> None:
        if not self._is_ready:
            self._prepare()
            self._is_ready = True

    def map(self, batches: Iterable[Batch]) -> Iterator[Outcome]:
        self.ready()
        return self._pool.map(batches)
