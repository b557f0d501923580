"""Local processes that fly.  Results stream home in whatever order they are done; nothing may depend on that order."""

from __future__ import annotations

import multiprocessing
import os
import signal
import time
import traceback
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from itertools import islice
from multiprocessing.connection import Connection
from multiprocessing.connection import wait as wait_for
from multiprocessing.process import BaseProcess
from typing import Any, Generic, TypeVar

from scaloft_fi.campaign.lifeline import die_with

Task = TypeVar("Task")
Result = TypeVar("Result")

THREAD_SETTINGS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")
"""A worker is one core: numeric libraries must not start threads of their own.  Set before numpy is imported."""

ATTEMPTS = 3
PATIENCE_S = 300.0
"""A flight that takes longer is hung: a hundred times what it should take [s, wall]."""
WORKER_PATIENCE_S = (ATTEMPTS + 1) * PATIENCE_S
"""A worker says nothing while a process that it split off is flown, at most so often again [s, wall]."""
LOOK_UP_S = 0.5
"""How often the parent looks up from waiting, to see whether it shall stop [s, wall]."""


def one_thread_each() -> None:
    """Keep the numeric libraries of this process and its children to one thread."""
    for name in THREAD_SETTINGS:
        os.environ.setdefault(name, "1")


def cores() -> int:
    """How many processors this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@dataclass
class _Try(Generic[Task, Result]):
    """A task, how often it was handed out, this time counted, and what came home of it this time."""

    task: Task
    attempt: int = 1
    home: list[Result] = field(default_factory=list)


@dataclass(eq=False)
class _Worker(Generic[Task, Result]):
    """A process and what it is busy with."""

    process: BaseProcess
    connection: Connection
    trial: _Try[Task, Result] | None = None
    heard_s: float = 0.0

    def end(self) -> None:
        """Stop it: an idle one leaves by itself, a busy one is not waited for."""
        if self.trial is not None:
            self.process.kill()
        self.connection.close()
        self.process.join()


class Pool(Generic[Task, Result]):
    """`jobs` processes that turn each task into results.

    Args:
        work: called in a worker with one task and with what takes its results; whatever it raises ends the run.
        jobs: number of processes.
        left: what remains of a task of which some results are home when its worker dies; None = nothing.
        lost: the results of a task that took its worker with it `ATTEMPTS` times without a result, and how.
        stop: asked between results; once true, no more tasks are handed out and the next results in the air come home.
        patience_s: a worker that says nothing for so long is hung [s, wall].
    """

    def __init__(
        self,
        work: Callable[[Task, Callable[[Result], None]], None],
        jobs: int,
        *,
        left: Callable[[Task, Sequence[Result]], Task | None],
        lost: Callable[[Task, str], Iterable[Result]],
        stop: Callable[[], bool] = lambda: False,
        patience_s: float = WORKER_PATIENCE_S,
    ) -> None:
        self._work, self._jobs, self._left, self._lost = work, jobs, left, lost
        self._stop, self._patience_s = stop, patience_s

    def map(self, tasks: Iterable[Task]) -> Iterator[Result]:
        """The results of `tasks`, as they are done; the next task is asked for when a process is free to do it."""
        source, waiting = iter(tasks), deque[_Try[Task, Result]]()
        crew: list[_Worker[Task, Result]] = []
        try:
            while True:
                if not self._stop():
                    self._hand_out(source, waiting, crew)
                busy = {worker.connection: worker for worker in crew if worker.trial is not None}
                if not busy:
                    return
                for connection in wait_for(list(busy), timeout=LOOK_UP_S):
                    yield from self._hear(busy[connection], waiting, crew)  # type: ignore[index]
                yield from self._end_hung(waiting, crew)
        finally:
            for worker in crew:
                worker.end()

    def _hand_out(
        self, source: Iterator[Task], waiting: deque[_Try[Task, Result]], crew: list[_Worker[Task, Result]]
    ) -> None:
        idle = [worker for worker in crew if worker.trial is None]
        while idle or len(crew) < self._jobs:
            waiting.extend(_Try(task) for task in islice(source, 0 if waiting else 1))
            if not waiting:
                return
            worker = idle.pop() if idle else self._hire(crew)
            trial = waiting.popleft()
            worker.trial, worker.heard_s = trial, time.monotonic()
            with suppress(OSError):  # it has just died; that is heard when it is listened to
                worker.connection.send(trial.task)

    def _hear(
        self, worker: _Worker[Task, Result], waiting: deque[_Try[Task, Result]], crew: list[_Worker[Task, Result]]
    ) -> Iterator[Result]:
        """One message of a worker."""
        trial = worker.trial
        if trial is None:
            return
        try:
            kind, content = worker.connection.recv()
        except (EOFError, OSError):
            yield from self._bury(worker, "died", waiting, crew)
            return
        worker.heard_s = time.monotonic()
        if kind == "raised":
            raise content
        if kind == "done":
            worker.trial = None
            return
        trial.home.append(content)
        if self._stop():
            crew.remove(worker)
            worker.end()
        yield content

    def _end_hung(self, waiting: deque[_Try[Task, Result]], crew: list[_Worker[Task, Result]]) -> Iterator[Result]:
        due_s = time.monotonic() - self._patience_s
        for worker in [worker for worker in crew if worker.trial is not None and worker.heard_s < due_s]:
            yield from self._bury(worker, "hung", waiting, crew)

    def _bury(
        self,
        worker: _Worker[Task, Result],
        how: str,
        waiting: deque[_Try[Task, Result]],
        crew: list[_Worker[Task, Result]],
    ) -> Iterator[Result]:
        """A worker is lost: what it still owes is tried again, as long as that may lead anywhere."""
        trial = worker.trial
        crew.remove(worker)
        worker.end()
        left = self._left(trial.task, trial.home) if trial is not None else None
        if trial is None or left is None:
            return
        attempt = 1 if trial.home else trial.attempt + 1
        if attempt <= ATTEMPTS:
            waiting.appendleft(_Try(left, attempt))
        else:
            yield from self._lost(left, f"{how} every time it was flown")

    def _hire(self, crew: list[_Worker[Task, Result]]) -> _Worker[Task, Result]:
        forked = "fork" in multiprocessing.get_all_start_methods()
        context = multiprocessing.get_context("fork") if forked else multiprocessing.get_context("spawn")
        ours, theirs = context.Pipe()
        inherited = [ours, *(worker.connection for worker in crew)] if forked else []
        process = context.Process(target=_serve, args=(self._work, theirs, inherited, os.getpid()))
        process.start()
        theirs.close()
        worker: _Worker[Task, Result] = _Worker(process, ours)
        crew.append(worker)
        return worker


def _serve(
    work: Callable[[Any, Callable[[Any], None]], None], connection: Connection, inherited: list[Connection], parent: int
) -> None:
    """The life of a worker: it leaves Ctrl-C to its parent, works on what it is sent, and never outlives it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    die_with(parent)
    for other in inherited:
        other.close()
    while True:
        try:
            task = connection.recv()
        except EOFError:
            return
        try:
            work(task, lambda result: connection.send(("result", result)))
            connection.send(("done", None))
        except BrokenPipeError:
            return
        except Exception as error:  # noqa: BLE001 - it is raised again where the run is
            error.add_note(traceback.format_exc())
            connection.send(("raised", error))
