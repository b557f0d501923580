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
        with Pool(
            Worker(study, flyer), self.jobs, left=left_of, lost=lost, stop=stop, patience_s=patience_s(study)
        ) as pool:
            yield LocalWorkers(pool, lambda: flyer.prepare(study, say))


def patience_s(study: Study) -> float:
    """The time without a message after which a worker is hung [s, wall]."""
    # a command ends itself after its limit, before the pool takes its worker for hung
    limit_s = study.command.limit_s if study.command else 0.0
    return max(WORKER_PATIENCE_S, (ATTEMPTS + 1) * limit_s)


class LocalWorkers:
    """The workers of a pool that is prepared once.

    Args:
        pool: the pool.
        prepare: prepares its processes.
    """

    def __init__(self, pool: Pool[Batch, Outcome], prepare: Callable[[], object]) -> None:
        self.jobs = pool.jobs
        self._pool, self._prepare = pool, prepare
        self._is_ready = False

    def ready(self) -> None:
        """Prepare the processes, once."""
        if not self._is_ready:
            self._prepare()
            self._is_ready = True

    def map(self, batches: Iterable[Batch]) -> Iterator[Outcome]:
        """Yield the outcomes of `batches` as they arrive."""
        self.ready()
        return self._pool.map(batches)
