"""Processes of this machine that fly.  Results arrive as they are done; nothing may depend on their order."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from itertools import islice
from multiprocessing.connection import wait as wait_for
from types import TracebackType
from typing import Generic, TypeVar

from scaloft_fi.campaign.processes.patience import ATTEMPTS, PATIENCE_S
from scaloft_fi.campaign.processes.start import Start, Started, forked

TaskT = TypeVar("TaskT")
ResultT = TypeVar("ResultT")

WORKER_PATIENCE_S = (ATTEMPTS + 1) * PATIENCE_S
"""A worker says nothing while a process that it split off is flown, at most so often again [s, wall]."""
LOOK_UP_S = 0.5
"""How often the parent looks up from waiting, to see whether it shall stop [s, wall]."""


@dataclass
class _Try(Generic[TaskT, ResultT]):
    """A task, how often it was handed out, this time counted, and the results of it that arrived this time."""

    task: TaskT
    attempt: int = 1
    arrived: list[ResultT] = field(default_factory=list)


@dataclass(eq=False)
class _Worker(Generic[TaskT, ResultT]):
    """A process and what it is busy with."""

    started: Started
    trial: _Try[TaskT, ResultT] | None = None
    last_s: float = 0.0

    def end(self) -> None:
        """Stop it: an idle one leaves by itself, a busy one is not waited for."""
        if self.trial is not None:
            self.started.process.kill()
        self.started.connection.close()
        self.started.process.join()


class Pool(Generic[TaskT, ResultT]):
    """`jobs` processes that turn each task into results; a context manager, at whose end they end.

    Args:
        work: called in a worker with one task and with what takes its results; whatever it raises ends the run.
        jobs: number of processes.
        left: what remains of a task of which some results have arrived when its worker dies; None = nothing.
        lost: the results of a task that took its worker with it `ATTEMPTS` times without a result, and how.
        stop: asked now and then; once true, no more tasks are handed out and the next results under way are taken.
        patient: whether they are waited for; else all ends within `LOOK_UP_S`.
        patience_s: a worker that says nothing for so long is hung [s, wall].
        start: how a process is started.
    """

    def __init__(
        self,
        work: Callable[[TaskT, Callable[[ResultT], None]], None],
        jobs: int,
        *,
        left: Callable[[TaskT, Sequence[ResultT]], TaskT | None],
        lost: Callable[[TaskT, str], Iterable[ResultT]],
        stop: Callable[[], bool] = lambda: False,
        patient: bool = True,
        patience_s: float = WORKER_PATIENCE_S,
        start: Start = forked,
    ) -> None:
        self.jobs = jobs
        self._work, self._left, self._lost = work, left, lost
        self._stop, self._patient, self._patience_s, self._start = stop, patient, patience_s, start
        self._workers: list[_Worker[TaskT, ResultT]] = []

    def __enter__(self) -> Pool[TaskT, ResultT]:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """End all processes."""
        self._end(self._workers)

    def map(self, tasks: Iterable[TaskT]) -> Iterator[ResultT]:
        """The results of `tasks`, as they are done; the next task is asked for when a process is free to do it.

        Raises:
            Exception: whatever the work raised.
        """
        source, waiting = iter(tasks), deque[_Try[TaskT, ResultT]]()
        try:
            while True:
                if not self._stop():
                    self._hand_out(source, waiting)
                elif not self._patient:
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
            with suppress(OSError):  # it has just died; that is heard when it is listened to
                worker.started.connection.send(trial.task)

    def _another(self) -> _Worker[TaskT, ResultT]:
        others = [worker.started.connection for worker in self._workers]
        self._workers.append(_Worker(self._start(self._work, others)))
        return self._workers[-1]

    def _receive(self, worker: _Worker[TaskT, ResultT], waiting: deque[_Try[TaskT, ResultT]]) -> Iterator[ResultT]:
        """One message of a worker."""
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
        if self._stop():
            self._end([worker])
        yield content

    def _end_hung(self, waiting: deque[_Try[TaskT, ResultT]]) -> Iterator[ResultT]:
        due_s = time.monotonic() - self._patience_s
        for worker in [worker for worker in self._workers if worker.trial is not None and worker.last_s < due_s]:
            yield from self._lose(worker, "hung", waiting)

    def _lose(
        self, worker: _Worker[TaskT, ResultT], how: str, waiting: deque[_Try[TaskT, ResultT]]
    ) -> Iterator[ResultT]:
        """A worker is lost: what it still owes is tried again, as long as that may lead anywhere."""
        trial = worker.trial
        self._end([worker])
        left = self._left(trial.task, trial.arrived) if trial is not None else None
        if trial is None or left is None:
            return
        attempt = 1 if trial.arrived else trial.attempt + 1
        if attempt <= ATTEMPTS:
            waiting.appendleft(_Try(left, attempt))
        else:
            yield from self._lost(left, f"{how} every time it was flown")
