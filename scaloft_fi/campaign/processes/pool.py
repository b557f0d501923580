"""Processes of this machine that fly.  Results stream home as they are done; nothing may depend on their order."""

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

from scaloft_fi.campaign.processes.hire import Hire, Hired, forked
from scaloft_fi.campaign.processes.patience import ATTEMPTS, PATIENCE_S

TaskT = TypeVar("TaskT")
ResultT = TypeVar("ResultT")

WORKER_PATIENCE_S = (ATTEMPTS + 1) * PATIENCE_S
"""A worker says nothing while a process that it split off is flown, at most so often again [s, wall]."""
LOOK_UP_S = 0.5
"""How often the parent looks up from waiting, to see whether it shall stop [s, wall]."""


@dataclass
class _Try(Generic[TaskT, ResultT]):
    """A task, how often it was handed out, this time counted, and what came home of it this time."""

    task: TaskT
    attempt: int = 1
    home: list[ResultT] = field(default_factory=list)


@dataclass(eq=False)
class _Worker(Generic[TaskT, ResultT]):
    """A process and what it is busy with."""

    hired: Hired
    trial: _Try[TaskT, ResultT] | None = None
    heard_s: float = 0.0

    def end(self) -> None:
        """Stop it: an idle one leaves by itself, a busy one is not waited for."""
        if self.trial is not None:
            self.hired.process.kill()
        self.hired.connection.close()
        self.hired.process.join()


class Pool(Generic[TaskT, ResultT]):
    """`jobs` processes that turn each task into results; a context manager, at whose end they end.

    Args:
        work: called in a worker with one task and with what takes its results; whatever it raises ends the run.
        jobs: number of processes.
        left: what remains of a task of which some results are home when its worker dies; None = nothing.
        lost: the results of a task that took its worker with it `ATTEMPTS` times without a result, and how.
        stop: asked now and then; once true, no more tasks are handed out and the next results in the air come home.
        patient: whether they are waited for; else all ends within `LOOK_UP_S`.
        patience_s: a worker that says nothing for so long is hung [s, wall].
        hire: how a process is started.
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
        hire: Hire = forked,
    ) -> None:
        self.jobs = jobs
        self._work, self._left, self._lost = work, left, lost
        self._stop, self._patient, self._patience_s, self._hire = stop, patient, patience_s, hire
        self._crew: list[_Worker[TaskT, ResultT]] = []

    def __enter__(self) -> Pool[TaskT, ResultT]:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """End all processes."""
        self._end(self._crew)

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
                busy = {worker.hired.connection: worker for worker in self._crew if worker.trial is not None}
                if not busy:
                    return
                for connection in wait_for(list(busy), timeout=LOOK_UP_S):
                    yield from self._hear(busy[connection], waiting)  # type: ignore[index]
                yield from self._end_hung(waiting)
        finally:
            self._end([worker for worker in self._crew if worker.trial is not None])

    def _end(self, workers: Iterable[_Worker[TaskT, ResultT]]) -> None:
        for worker in list(workers):
            self._crew.remove(worker)
            worker.end()

    def _hand_out(self, source: Iterator[TaskT], waiting: deque[_Try[TaskT, ResultT]]) -> None:
        idle = [worker for worker in self._crew if worker.trial is None]
        while idle or len(self._crew) < self.jobs:
            waiting.extend(_Try(task) for task in islice(source, 0 if waiting else 1))
            if not waiting:
                return
            worker = idle.pop() if idle else self._another()
            trial = waiting.popleft()
            worker.trial, worker.heard_s = trial, time.monotonic()
            with suppress(OSError):  # it has just died; that is heard when it is listened to
                worker.hired.connection.send(trial.task)

    def _another(self) -> _Worker[TaskT, ResultT]:
        others = [worker.hired.connection for worker in self._crew]
        self._crew.append(_Worker(self._hire(self._work, others)))
        return self._crew[-1]

    def _hear(self, worker: _Worker[TaskT, ResultT], waiting: deque[_Try[TaskT, ResultT]]) -> Iterator[ResultT]:
        """One message of a worker."""
        trial = worker.trial
        if trial is None:
            return
        try:
            kind, content = worker.hired.connection.recv()
        except (EOFError, OSError):
            yield from self._bury(worker, "died", waiting)
            return
        worker.heard_s = time.monotonic()
        if kind == "raised":
            raise content
        if kind == "done":
            worker.trial = None
            return
        trial.home.append(content)
        if self._stop():
            self._end([worker])
        yield content

    def _end_hung(self, waiting: deque[_Try[TaskT, ResultT]]) -> Iterator[ResultT]:
        due_s = time.monotonic() - self._patience_s
        for worker in [worker for worker in self._crew if worker.trial is not None and worker.heard_s < due_s]:
            yield from self._bury(worker, "hung", waiting)

    def _bury(
        self, worker: _Worker[TaskT, ResultT], how: str, waiting: deque[_Try[TaskT, ResultT]]
    ) -> Iterator[ResultT]:
        """A worker is lost: what it still owes is tried again, as long as that may lead anywhere."""
        trial = worker.trial
        self._end([worker])
        left = self._left(trial.task, trial.home) if trial is not None else None
        if trial is None or left is None:
            return
        attempt = 1 if trial.home else trial.attempt + 1
        if attempt <= ATTEMPTS:
            waiting.appendleft(_Try(left, attempt))
        else:
            yield from self._lost(left, f"{how} every time it was flown")
