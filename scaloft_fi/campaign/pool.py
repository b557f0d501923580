"""Local processes that fly.  Results stream home in whatever order they are done; nothing may depend on that order."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from multiprocessing.connection import wait as wait_for
from multiprocessing.process import BaseProcess
from typing import Any, Generic, TypeVar

Task = TypeVar("Task")
Result = TypeVar("Result")

THREAD_SETTINGS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")
"""A worker is one core: numeric libraries must not start threads of their own.  Set before numpy is imported."""

ATTEMPTS = 3
AHEAD = 2
"""Tasks handed out per worker, so that none waits for the parent."""
LOOK_UP_S = 0.5
"""How often the parent looks up from waiting, to see whether it shall stop [s, wall]."""


def one_thread_each() -> None:
    """Keep the numeric libraries of this process and its children to one thread."""
    for name in THREAD_SETTINGS:
        os.environ.setdefault(name, "1")


def cores() -> int:
    """How many processors this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@dataclass(frozen=True)
class _Try(Generic[Task]):
    """A task and how often it was handed out, this time counted."""

    task: Task
    attempt: int = 1


class Pool(Generic[Task, Result]):
    """`jobs` processes that map tasks to results.

    Args:
        work: called in a worker with one task; whatever it raises ends the run.
        lost: the result of a task that took its worker with it `ATTEMPTS` times.
        jobs: number of processes.
        stop: asked between results; once true, no more tasks are handed out and those in the air come home.
    """

    def __init__(
        self,
        work: Callable[[Task], Result],
        lost: Callable[[Task], Result],
        jobs: int,
        stop: Callable[[], bool] = lambda: False,
    ) -> None:
        self._work, self._lost, self._jobs, self._stop = work, lost, jobs, stop

    def map(self, tasks: Iterable[Task]) -> Iterator[tuple[Task, Result]]:
        """(task, its result) for each, as they are done."""
        waiting = deque(_Try(task) for task in tasks)
        while waiting and not self._stop():
            yield from self._until_broken(waiting)

    def _until_broken(self, waiting: deque[_Try[Task]]) -> Iterator[tuple[Task, Result]]:
        """Work on `waiting` until it is empty or a worker dies; what was in the air then is put back."""
        others = set(multiprocessing.active_children())
        executor = self._executor()
        in_air: dict[Future[Result], _Try[Task]] = {}
        try:
            while True:
                while waiting and not self._stop() and self._may_start(waiting[0], in_air):
                    in_air[executor.submit(_call, waiting[0].task)] = waiting[0]
                    waiting.popleft()
                if not in_air:
                    return
                done, _ = wait(in_air, timeout=LOOK_UP_S, return_when=FIRST_COMPLETED)
                for future in done:
                    result = future.result()
                    yield in_air.pop(future).task, result
        except BrokenProcessPool:
            yield from self._put_back(in_air, waiting)
            in_air.clear()
        finally:
            _end(executor, set(multiprocessing.active_children()) - others if in_air else ())

    def _may_start(self, trial: _Try[Task], in_air: Mapping[Future[Result], _Try[Task]]) -> bool:
        """A task that was in the air when a worker died flies alone, so that its neighbours are not blamed for it."""
        if trial.attempt > 1 or any(other.attempt > 1 for other in in_air.values()):
            return not in_air
        return len(in_air) < AHEAD * self._jobs

    def _put_back(
        self, in_air: Mapping[Future[Result], _Try[Task]], waiting: deque[_Try[Task]]
    ) -> Iterator[tuple[Task, Result]]:
        for future, trial in in_air.items():
            if future.done() and not future.cancelled() and future.exception() is None:
                yield trial.task, future.result()
            elif trial.attempt < ATTEMPTS:
                waiting.appendleft(_Try(trial.task, trial.attempt + 1))
            else:
                yield trial.task, self._lost(trial.task)

    def _executor(self) -> ProcessPoolExecutor:
        method = "fork" if "fork" in multiprocessing.get_all_start_methods() else "spawn"
        context = multiprocessing.get_context(method)
        return ProcessPoolExecutor(self._jobs, mp_context=context, initializer=_begin, initargs=(self._work,))


_work: Callable[[Any], Any]
"""What this worker does; set once when it starts, so that a task is all that travels."""


def _call(task: Any) -> Any:
    return _work(task)


def _begin(work: Callable[[Any], Any]) -> None:
    """A worker leaves Ctrl-C to its parent, and never outlives it."""
    global _work
    _work = work
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    parent = multiprocessing.parent_process()
    if parent is not None:
        threading.Thread(target=_end_with, args=(parent.sentinel,), daemon=True).start()


def _end_with(sentinel: int) -> None:
    wait_for([sentinel])
    os._exit(1)


def _end(executor: ProcessPoolExecutor, busy: Iterable[BaseProcess]) -> None:
    """Stop the workers: idle ones leave by themselves, `busy` ones are not waited for."""
    for process in busy:
        process.kill()
    executor.shutdown(wait=True, cancel_futures=True)
