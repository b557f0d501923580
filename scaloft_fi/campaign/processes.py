"""Worker processes on this machine: each receives tasks, returns results, uses one core, and ends with its parent."""

from __future__ import annotations

import ctypes
import multiprocessing
import os
import signal
import socket
import subprocess
import sys
import threading
import traceback
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from multiprocessing import parent_process
from multiprocessing.connection import Connection, wait
from typing import Any, NamedTuple

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


if __name__ == "__main__":  # a worker in a new interpreter, whose standard input closes when its parent ends
    die_with(int(sys.argv[2]), sys.stdin.fileno())
    parent = Connection(int(sys.argv[1]))
    with suppress(EOFError):
        _serve(parent.recv(), parent)
