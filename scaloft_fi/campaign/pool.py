"""A pool of worker processes on this machine.  Results arrive in any order; no caller may depend on the order."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import KW_ONLY, dataclass, field
from itertools import islice
from multiprocessing.connection import wait as wait_for
from typing import Generic, TypeVar

from scaloft_fi.campaign.processes import ATTEMPTS, PATIENCE_S, Start, Started, forked

TaskT = TypeVar("TaskT")
ResultT = TypeVar("ResultT")

WORKER_PATIENCE_S = (ATTEMPTS + 1) * PATIENCE_S
"""Longer than the longest silence of a worker, which waits for a forked flight and its repetitions [s, wall]."""
LOOK_UP_S = 0.5
"""Interval at which the waiting parent checks whether to stop [s, wall]."""


@dataclass
class _Try(Generic[TaskT, ResultT]):
    """An attempt at a task: its number, from 1, and the results of this attempt."""

    task: TaskT
    attempt: int = 1
    arrived: list[ResultT] = field(default_factory=list)


@dataclass(eq=False)
class _Worker(Generic[TaskT, ResultT]):
    """A process and its current task."""

    started: Started
    trial: _Try[TaskT, ResultT] | None = None
    last_s: float = 0.0

    def end(self) -> None:
        """End the process: an idle process ends when its connection closes, a busy one is killed."""
        if self.trial is not None:
            self.started.kill()
        self.started.connection.close()
        self.started.join()


@dataclass(eq=False)
class ProcessPool(Generic[TaskT, ResultT]):
    """`jobs` processes that turn tasks into results; a context manager, at whose end the processes end.

    Attributes:
        work: called in a worker with a task and a callback for its results; an exception ends the run.
        jobs: number of processes.
        left: the rest of a task after some results, when its worker dies; None = nothing.
        lost: the results of a task whose worker died `ATTEMPTS` times without a result, from task and reason.
        stop: polled; once true, no more tasks are handed out, and each busy worker's next result is awaited.
        patient: whether those results are awaited; if not, the pool ends within `LOOK_UP_S`.
        patience_s: a worker without a message for this time is hung [s, wall].
        start: starts a process.
    """

    work: Callable[[TaskT, Callable[[ResultT], None]], None]
    jobs: int
    _: KW_ONLY
    left: Callable[[TaskT, Sequence[ResultT]], TaskT | None]
    lost: Callable[[TaskT, str], Iterable[ResultT]]
    stop: Callable[[], bool] = lambda: False
    patient: bool = True
    patience_s: float = WORKER_PATIENCE_S
    start: Start = forked
    _workers: list[_Worker[TaskT, ResultT]] = field(default_factory=list, init=False)

    def __enter__(self) -> ProcessPool[TaskT, ResultT]:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """End all processes."""
        self._end(self._workers)

    def map(self, tasks: Iterable[TaskT]) -> Iterator[ResultT]:
        """Yield the results of `tasks` as they arrive; the next task is taken when a process is free.

        Raises:
            Exception: `work` raised it.
        """
        source, waiting = iter(tasks), deque[_Try[TaskT, ResultT]]()
        try:
            while True:
                if not self.stop():
                    self._hand_out(source, waiting)
                elif not self.patient:
                    return
                busy = {worker.started.connection: worker for worker in self._workers if worker.trial is not None}
                if not busy:
                    return
                for connection in wait_for(list(busy), timeout=LOOK_UP_S):
                    yield from self._receive(busy[connection], waiting)  # type: ignore[index]
                yield from self._end_hung(waiting)
        finally:
            self._end([worker for worker in self._workers if worker.trial is not None])

    def _end(self, workers: Iterable[_Worker[TaskT, ResultT]]) -> None:
        for worker in list(workers):
            self._workers.remove(worker)
            worker.end()

    def _hand_out(self, source: Iterator[TaskT], waiting: deque[_Try[TaskT, ResultT]]) -> None:
        idle = [worker for worker in self._workers if worker.trial is None]
        while idle or len(self._workers) < self.jobs:
            waiting.extend(_Try(task) for task in islice(source, 0 if waiting else 1))
            if not waiting:
                return
            worker = idle.pop() if idle else self._another()
            trial = waiting.popleft()
            worker.trial, worker.last_s = trial, time.monotonic()
            with suppress(OSError):  # the worker has just died; `_receive` notices it
                worker.started.connection.send(trial.task)

    def _another(self) -> _Worker[TaskT, ResultT]:
        others = [worker.started.connection for worker in self._workers]
        self._workers.append(_Worker(self.start(self.work, others)))
        return self._workers[-1]

    def _receive(self, worker: _Worker[TaskT, ResultT], waiting: deque[_Try[TaskT, ResultT]]) -> Iterator[ResultT]:
        """Handle one message of a worker."""
        trial = worker.trial
        if trial is None:
            return
        try:
            kind, content = worker.started.connection.recv()
        except (EOFError, OSError):
            yield from self._lose(worker, "died", waiting)
            return
        worker.last_s = time.monotonic()
        if kind == "raised":
            raise content
        if kind == "done":
            worker.trial = None
            return
        trial.arrived.append(content)
        if self.stop():
            self._end([worker])
        yield content

    def _end_hung(self, waiting: deque[_Try[TaskT, ResultT]]) -> Iterator[ResultT]:
        due_s = time.monotonic() - self.patience_s
        for worker in [worker for worker in self._workers if worker.trial is not None and worker.last_s < due_s]:
            yield from self._lose(worker, "hung", waiting)

    def _lose(
        self, worker: _Worker[TaskT, ResultT], how: str, waiting: deque[_Try[TaskT, ResultT]]
    ) -> Iterator[ResultT]:
        """Handle a lost worker: try the rest of its task again, up to `ATTEMPTS` times without a result."""
        trial = worker.trial
        self._end([worker])
        left = self.left(trial.task, trial.arrived) if trial is not None else None
        if trial is None or left is None:
            return
        attempt = 1 if trial.arrived else trial.attempt + 1
        if attempt <= ATTEMPTS:
            waiting.appendleft(_Try(left, attempt))
        else:
            yield from self.lost(left, f"{how} every time it was flown")
