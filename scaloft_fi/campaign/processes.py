"""Worker processes on this machine, each on one core, that end with their parent; and a pool of them.

Results of a pool arrive in any order; no caller may depend on the order.
"""

from __future__ import annotations

import ctypes
import multiprocessing
import os
import signal
import socket
import subprocess
import sys
import threading
import time
import traceback
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import KW_ONLY, dataclass, field
from itertools import islice
from multiprocessing import parent_process
from multiprocessing.connection import Connection, wait
from typing import Any, Generic, NamedTuple, TypeVar

from scaloft_fi.aside import answers_apart

LINUX = sys.platform.startswith("linux")
_PR_SET_PDEATHSIG = 1
_prctl: Callable[..., int] | None = getattr(ctypes.CDLL(None), "prctl", None) if LINUX else None


def die_with(parent: int, sentinel: int | None = None) -> None:
    """End this process when its parent, which has the id `parent`, ends.

    On Linux the kernel ends it.  On other systems a thread waits for `sentinel`, a descriptor that becomes readable
    when the parent ends; None = the sentinel of `multiprocessing`.
    """
    if _prctl is not None:
        _prctl(_PR_SET_PDEATHSIG, signal.SIGKILL, 0, 0, 0)
        if os.getppid() != parent:  # the parent ended before this call
            os._exit(1)
        return
    process = parent_process()
    if sentinel is None and process is not None:
        sentinel = process.sentinel
    if sentinel is not None:
        threading.Thread(target=_end_after, args=(sentinel,), daemon=True).start()


def _end_after(sentinel: int) -> None:
    wait([sentinel])
    os._exit(1)


def cause_of_death(status: int) -> str:
    """The exit code or the signal that ended a process, from its wait status.

    >>> cause_of_death(9), cause_of_death(256)
    ('SIGKILL', 'exit code 1')
    """
    code = os.waitstatus_to_exitcode(status)
    return f"exit code {code}" if code >= 0 else signal.Signals(-code).name


ATTEMPTS = 3
"""Number of attempts for a flight that fails in the harness."""
PATIENCE_S = 300.0
"""A flight that takes longer is hung; a hundred times the usual time [s, wall]."""


THREAD_SETTINGS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")
"""A worker uses one core, so numeric libraries must not start threads.  Set these before numpy is imported."""

HANGUP = (signal.SIGHUP,) if hasattr(signal, "SIGHUP") else ()
"""Sent to every process of a terminal that closes; Windows has no such signal."""
STOPS = frozenset({signal.SIGINT, *HANGUP})
"""Signals that a terminal sends to all processes of a run: the run's own process answers, its workers ignore them."""

Work = Callable[[Any, Callable[[Any], None]], None]
"""Called with a task and a callback for its results; an exception ends the run."""


class Started(NamedTuple):
    """A process: how it is ended at once, how its end is awaited, and the connection to it."""

    kill: Callable[[], None]
    join: Callable[[], object]
    connection: Connection


Start = Callable[[Work, Sequence[Connection]], Started]
"""Starts a process that runs `work`; the process must close the given connections, which belong to other workers."""


def one_thread_each() -> None:
    """Keep the numeric libraries of this process and its children to one thread."""
    for name in THREAD_SETTINGS:
        os.environ.setdefault(name, "1")


def cores() -> int:
    """Number of processors that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def forked(work: Work, others: Sequence[Connection]) -> Started:
    """Start a fork of this process, which must have one thread only; without fork, a spawned process."""
    can_fork = "fork" in multiprocessing.get_all_start_methods()
    context = multiprocessing.get_context("fork") if can_fork else multiprocessing.get_context("spawn")
    ours, theirs = context.Pipe()
    inherited = [ours, *others] if can_fork else []
    process = context.Process(target=_run_worker, args=(work, theirs, inherited, os.getpid()))
    with _interrupts_blocked():
        process.start()
    theirs.close()
    return Started(process.kill, process.join, ours)


def started_clean(work: Work, _others: Sequence[Connection]) -> Started:
    """Start a new interpreter with the same import path, from a process with threads; `work` is pickled.

    `multiprocessing` refuses this: the workers of Dask are daemonic, and daemonic processes may have no children.
    """
    ours, theirs = socket.socketpair()
    with theirs, _interrupts_blocked():
        process = subprocess.Popen(
            [sys.executable, "-P", "-m", __name__, str(theirs.fileno()), str(os.getpid())],
            env=os.environ | dict.fromkeys(THREAD_SETTINGS, "1") | {"PYTHONPATH": os.pathsep.join(sys.path)},
            stdin=subprocess.PIPE,
            pass_fds=[theirs.fileno()],
        )
    connection = Connection(ours.detach())
    with suppress(OSError):  # the process has just died; the reader of the connection notices it
        connection.send(work)
    return Started(process.kill, process.communicate, connection)


@contextmanager
def _interrupts_blocked() -> Iterator[None]:
    """Block `STOPS` for processes that start in this context; this process receives them afterwards."""
    if not hasattr(signal, "pthread_sigmask"):  # on Windows a worker receives Ctrl-C until it ignores it
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, STOPS)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _run_worker(work: Work, connection: Connection, inherited: Sequence[Connection], parent: int) -> None:
    """Run a worker: it ignores `STOPS`, works on its tasks, and ends with its parent."""
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    die_with(parent)
    for other in inherited:
        other.close()
    with answers_apart():
        _serve(work, connection)


def _serve(work: Work, connection: Connection) -> None:
    for number in STOPS:
        signal.signal(number, signal.SIG_IGN)
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
        except Exception as error:  # noqa: BLE001 - the parent raises it again
            error.add_note(traceback.format_exc())
            connection.send(("raised", error))


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
                for connection in wait(list(busy), timeout=LOOK_UP_S):
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


if __name__ == "__main__":  # a worker in a new interpreter, whose standard input closes when its parent ends
    die_with(int(sys.argv[2]), sys.stdin.fileno())
    parent = Connection(int(sys.argv[1]))
    with suppress(EOFError), answers_apart():
        _serve(parent.recv(), parent)
