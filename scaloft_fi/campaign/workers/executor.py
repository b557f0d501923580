"""Who flies: processes of this machine, or a Dask cluster."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass
from typing import Protocol

from scaloft_fi.campaign.flights.fly import Flyer, Worker, left_of, lost
from scaloft_fi.campaign.plan.task import Task
from scaloft_fi.campaign.workers.hire import cores
from scaloft_fi.campaign.workers.pool import Pool
from scaloft_fi.errors import InputError
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.study import Study

LOCAL = "local"
_DASK = re.compile(r"dask://(?P<address>[^/\s:@]+:[0-9]{1,5}|\[[0-9A-Fa-f:.]+\]:[0-9]{1,5})/?")


class Hands(Protocol):
    """Those who fly, while they are hired."""

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

    def map(self, tasks: Iterable[Task]) -> Iterator[Outcome]:
        """The outcomes of `tasks`, each as it is known, in no order.

        A task whose worker is lost is tried again elsewhere; flights that are lost every time are `invalid`.

        Raises:
            ScaloftError: the study cannot be flown, or nobody is left to fly it.
        """
        ...


class Executor(Protocol):
    """Has hands."""

    def hands(
        self, study: Study, flyer: Flyer, *, stop: Callable[[], bool], say: Callable[[str], None]
    ) -> AbstractContextManager[Hands]:
        """Those who fly `study` while the context lasts.

        Args:
            study: what is flown.
            flyer: what flies it.
            stop: asked now and then; once true, no more is begun, and `map` ends soon.
            say: takes a line for a person.

        Raises:
            InputError: nobody can be hired.
        """
        ...


@dataclass(frozen=True)
class Local:
    """So many processes of this machine."""

    jobs: int

    @contextmanager
    def hands(
        self, study: Study, flyer: Flyer, *, stop: Callable[[], bool], say: Callable[[str], None]
    ) -> Iterator[Hands]:
        """Processes that inherit what was made ready here; each is forked when it is first needed."""
        with Pool(Worker(study, flyer), self.jobs, left=left_of, lost=lost, stop=stop) as pool:
            yield _Here(pool, lambda: flyer.prepare(study, say))


class _Here:
    """A pool that is made ready once."""

    def __init__(self, pool: Pool[Task, Outcome], prepare: Callable[[], None]) -> None:
        self.jobs = pool.jobs
        self._pool, self._prepare = pool, prepare
        self._is_ready = False

    def ready(self) -> None:
        if not self._is_ready:
            self._prepare()
            self._is_ready = True

    def map(self, tasks: Iterable[Task]) -> Iterator[Outcome]:
        self.ready()
        return self._pool.map(tasks)


def executor_named(name: str, jobs: int | None) -> Executor:
    """The executor that `--executor` and `--jobs` stand for.

    Raises:
        InputError: it is none, or what it needs is not installed.
    """
    if name == LOCAL:
        return Local(jobs or cores())
    found = _DASK.fullmatch(name)
    if found is None:
        raise InputError(f"--executor={name!r} must be 'local' or 'dask://HOST:PORT', the address of a Dask scheduler")
    if jobs is not None:
        raise InputError(f"--jobs={jobs} is for --executor=local; how many fly on {name} is up to its workers")
    from scaloft_fi.campaign.workers.cluster import Cluster

    return Cluster(found["address"])
