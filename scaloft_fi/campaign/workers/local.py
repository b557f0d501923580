"""Worker processes on this machine that fly a run, and the signals that let a run save and end."""

from __future__ import annotations

import math
import signal
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import FrameType
from typing import Any, Protocol

from scaloft_fi.campaign.flights.fly import Batch, Flyer, Worker, left_of, lost
from scaloft_fi.campaign.pool import WORKER_PATIENCE_S, ProcessPool
from scaloft_fi.campaign.processes import ATTEMPTS, HANGUP, Work, forked, started_clean
from scaloft_fi.errors import InputError, ScaloftError
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.study import Study


class Workers(Protocol):
    """The workers of one run."""

    @property
    def jobs(self) -> int:
        """Number of processes for which batches are arranged."""
        ...

    def ready(self) -> None:
        """Prepare the workers for flights; `map` calls it if necessary.

        Raises:
            InputError: the study cannot be flown.
        """
        ...

    def map(self, batches: Iterable[Batch]) -> Iterator[Outcome]:
        """Yield the outcomes of `batches` as they arrive, in any order.

        A batch whose worker dies is tried again in another worker; flights that fail every time are `invalid`.

        Raises:
            ScaloftError: the study cannot be flown, or no worker is left.
        """
        ...


class Executor(Protocol):
    """Starts workers."""

    def workers(
        self, study: Study, flyer: Flyer, *, stop: Callable[[], bool], say: Callable[[str], None]
    ) -> AbstractContextManager[Workers]:
        """Start workers for `study`; they end with the context.

        Args:
            study: the study.
            flyer: flies.
            stop: polled; once true, no batch begins, and `map` ends soon.
            say: prints a line for the user.

        Raises:
            InputError: no worker can be started.
        """
        ...


ECHO_S = 1.0
"""A second signal within this time is ignored, because terminal and wrapper may both pass on the first [s, wall]."""


class Interrupted(ScaloftError):  # noqa: N818 - an event, not an error
    """The user stopped the run; all outcomes are saved."""

    exit_code = 130


@contextmanager
def interruptible(stopped: threading.Event) -> Iterator[None]:
    """In this context the first signal that asks to stop sets the event, the second one does what it did before.

    A SIGHUP that is ignored, as `nohup` has it, stays ignored.
    """
    if threading.current_thread() is not threading.main_thread():  # only the main thread can handle signals
        yield
        return
    before: dict[int, Any] = {}
    first_s = math.inf

    def handle(number: int, frame: FrameType | None) -> None:
        nonlocal first_s
        stopped.set()
        first_s = min(first_s, time.monotonic())
        if time.monotonic() - first_s > ECHO_S:
            if not callable(before[number]):
                raise KeyboardInterrupt
            before[number](number, frame)

    hangup = [number for number in HANGUP if signal.getsignal(number) != signal.SIG_IGN]
    for number in (signal.SIGINT, signal.SIGTERM, *hangup):
        before[number] = signal.getsignal(number)
        signal.signal(number, handle)
    try:
        yield
    finally:
        for changed, handler in before.items():
            signal.signal(changed, handler)


@dataclass
class LateWorker:
    """The work of a new process: it opens the study when it gets its first batch.

    Attributes:
        folder, grid_name: of the study.
        flyer: flies.
        inputs: hashes of the study that the run has read; None where others have compared them.
    """

    folder: Path
    grid_name: str | None
    flyer: Flyer
    inputs: Mapping[str, str] | None = None
    _worker: Worker | None = None

    def __call__(self, batch: Batch, report: Callable[[Outcome], None]) -> None:
        """Fly one batch.

        Raises:
            InputError: the study cannot be flown, or has changed since the run has read it.
        """
        if self._worker is None:
            study = Study.open(self.folder, self.grid_name)
            if self.inputs is not None and self.inputs != study.inputs:
                raise InputError(f"{self.folder}: the study has changed since the run began; run again")
            self.flyer.prepare(study, lambda _text: None)
            self._worker = Worker(study, self.flyer)
        self._worker(batch, report)


@dataclass(frozen=True)
class Local:
    """Processes on this machine.

    A fork of a process with threads may hang, and its numeric libraries may use more than one thread.  A new
    interpreter has neither, and the module of the user's script is not imported again in it.

    Attributes:
        jobs: how many.
        clean: whether each is a new interpreter, instead of a fork.
    """

    jobs: int
    clean: bool = False

    @contextmanager
    def workers(
        self, study: Study, flyer: Flyer, *, stop: Callable[[], bool], say: Callable[[str], None]
    ) -> Iterator[Workers]:
        """Start a pool; each process starts at its first task: a fork inherits the prepared state, others prepare."""
        work: Work = Worker(study, flyer)
        if self.clean:
            work = LateWorker(study.folder, study.grid_name, flyer, study.inputs)
        # a command ends itself after its limit, before the pool takes its worker for hung
        limit_s = study.command.limit_s if study.command else 0.0
        with ProcessPool(
            work,
            self.jobs,
            left=left_of,
            lost=lost,
            stop=stop,
            patience_s=max(WORKER_PATIENCE_S, (ATTEMPTS + 1) * limit_s),
            start=started_clean if self.clean else forked,
        ) as pool:

            def prepare() -> None:
                if self.clean:  # an empty batch prepares the first process, which compiles the kernels for all of them
                    list(pool.map([Batch(())]))
                else:
                    flyer.prepare(study, say)

            yield LocalWorkers(pool, prepare)


class LocalWorkers:
    """The workers of a pool that is prepared once.

    Args:
        pool: the pool.
        prepare: prepares its processes.
    """

    def __init__(self, pool: ProcessPool[Batch, Outcome], prepare: Callable[[], object]) -> None:
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
