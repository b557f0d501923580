"""One run on a Dask cluster: workers prove that they have the key, then they get batches and send outcomes."""

from __future__ import annotations

import re
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from scaloft_fi.campaign.flights.worker import Flyer, left_of, lost
from scaloft_fi.campaign.plan.batch import Batch
from scaloft_fi.campaign.processes.patience import ATTEMPTS
from scaloft_fi.campaign.store.fingerprint import fingerprint
from scaloft_fi.campaign.workers.bundle import digest_of
from scaloft_fi.campaign.workers.inbox import Inbox
from scaloft_fi.campaign.workers.interrupt import Interrupted
from scaloft_fi.campaign.workers.key import VARIABLE, Message
from scaloft_fi.campaign.workers.plain import batch_to_plain, flyer_to_plain, outcome_from_plain
from scaloft_fi.campaign.workers.slot import fly_batch, join
from scaloft_fi.errors import InputError
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.study import Study

if TYPE_CHECKING:
    from distributed import Client, Future

LOOK_UP_S = 0.1
"""Interval between checks for finished batches [s, wall]."""
COUNT_S = 1.0
"""Interval between counts of the workers and their threads [s, wall]."""
LEAST_JOBS = 8
"""Least number of threads for which batches are arranged, because workers may join."""
AHEAD = 2
"""Number of batches per thread that are handed out at a time, so that no thread waits."""
SILENT = 100
"""A run ends when this many batches in sequence end without a word of a worker."""

GONE = "the Dask scheduler is gone; what was flown is saved, the same command resumes"
_ADDRESS = re.compile(r"[a-z]+://[A-Za-z0-9_.:%\[\]-]+")


@contextmanager
def disconnecting() -> Iterator[None]:
    """Ignore errors of the disconnect: the scheduler may be gone, and then the client has closed itself."""
    from distributed.client import ClosedClientError

    with suppress(OSError, TimeoutError, ClosedClientError, AttributeError):
        yield


@dataclass
class _Trial:
    """A batch that was handed out.

    Attributes:
        where: addresses of the workers that may fly it.
        begun: number of starts without any outcome.
        lost_before: how often messages were lost before it was handed out.
        arrived: its outcomes so far, by name.
    """

    batch: Batch
    future: Future[None]
    where: frozenset[str]
    begun: int
    lost_before: int
    arrived: dict[str, Outcome] = field(default_factory=dict)


class ClusterRun:
    """One run on a cluster.

    Args:
        client: connected to the scheduler.
        inbox: receives the messages of the workers.
        bundle: the packed study.
        study, flyer, stop, say: as for an executor.
    """

    def __init__(
        self,
        client: Client,
        inbox: Inbox,
        bundle: bytes,
        study: Study,
        flyer: Flyer,
        stop: Callable[[], bool],
        say: Callable[[str], None],
    ) -> None:
        self._client, self._inbox, self._bundle, self._stop, self._say = client, inbox, bundle, stop, say
        self._line = client.scheduler_comm
        self._greeting = {
            "bundle": digest_of(bundle),
            "grid": study.grid_name,
            "inputs": dict(study.inputs),
            "platform": fingerprint(),
        }
        self._flyer = flyer_to_plain(flyer)
        self._trials: dict[int, _Trial] = {}
        self._again: deque[tuple[Batch, int]] = deque()
        self._joins: dict[str, Future[None]] = {}
        self._ready: set[str] = set()
        self._barred: dict[str, str] = {}
        self._lines_shown: set[str] = set()
        self._threads: dict[str, int] = {}
        self._counted_s = -COUNT_S
        self._silent = 0

    @property
    def jobs(self) -> int:
        """Number of threads of all workers."""
        self._look_round()
        return max(LEAST_JOBS, sum(self._threads.values()))

    def ready(self) -> None:
        """Do nothing: every worker prepares itself."""

    def map(self, batches: Iterable[Batch]) -> Iterator[Outcome]:
        """Yield the outcomes of `batches` as they arrive; the next batch is taken when a thread may soon be free."""
        source = iter(batches)
        is_empty = False
        try:
            while not self._stop():
                self._look_round()
                while self._room() and not is_empty:
                    batch, begun = self._again.popleft() if self._again else (next(source, None), 0)
                    if batch is None:
                        is_empty = True
                    else:
                        self._hand_out(batch, begun)
                if is_empty and not self._trials and not self._again:
                    return
                # finished batches first: all their events were sent before they ended
                ended = [number for number, trial in self._trials.items() if self._has_ended(trial)]
                yield from self._received(0.0 if ended else LOOK_UP_S)
                for number in ended:
                    yield from self._end(self._trials.pop(number))
                is_empty = is_empty and not self._again
        finally:
            with disconnecting():
                self._client.cancel([trial.future for trial in self._trials.values()])
        yield from self._received(0.0)
        self._trials.clear()
        self._again.clear()

    def _room(self) -> bool:
        return len(self._trials) < AHEAD * sum(self._threads.get(worker, 0) for worker in self._ready)

    def _hand_out(self, batch: Batch, begun: int) -> None:
        content = {
            "bundle": self._greeting["bundle"],
            "grid": self._greeting["grid"],
            "flyer": self._flyer,
            "batch": batch_to_plain(batch),
        }
        number, order = self._inbox.order("fly", content)
        where = frozenset(self._ready)
        future = self._client.submit(
            fly_batch,
            order,
            key=f"scaloft-fi-{self._inbox.run}-{number}",
            workers=sorted(where),
            pure=False,
        )
        self._trials[number] = _Trial(batch, future, where, begun, self._inbox.lost)

    def _has_ended(self, trial: _Trial) -> bool:
        """Whether a batch is done, or waits for workers that are gone."""
        return trial.future.done() or not trial.where & self._threads.keys()

    def _received(self, wait_s: float) -> Iterator[Outcome]:
        """Yield the outcomes among the received messages; wait at most `wait_s` for the first message [s, wall]."""
        for message in self._inbox.messages(wait_s):
            self._silent = 0
            if message.kind == "outcome":
                yield from self._outcome(message)
            else:
                self._note(message)
        if self._inbox.strange:
            self._say_once("warning: messages on the scheduler do not carry the key of the run; they are ignored")

    def _outcome(self, message: Message) -> Iterator[Outcome]:
        trial = self._trials.get(message.number)
        if trial is None:
            return
        try:
            outcome = outcome_from_plain(trial.batch, message.content)
        except ValueError as error:
            self._inbox.nonsense += 1
            self._bar(message.worker, f"the worker at {message.worker} sent what is no outcome of its batch: {error}")
            return
        if outcome.name not in trial.arrived:  # a batch is flown again whole when its worker is lost
            trial.arrived[outcome.name] = outcome
            yield outcome

    def _note(self, message: Message) -> None:
        trial, place = self._trials.get(message.number), f"the worker at {message.worker}"
        if message.kind == "ready":
            if message.worker not in self._barred:
                self._ready.add(message.worker)
        elif message.kind == "begun":
            if trial is not None:
                trial.begun += 1
        elif message.kind == "refused":
            self._bar(message.worker, f"{place} has other code or data and flies nothing: {message.content}")
        elif message.kind == "platform":
            self._say_once(f"warning: {place} is another platform, digests may differ: {message.content}")
        elif message.kind == "failed":
            self._bar(message.worker, f"{place} cannot fly the study: {message.content}")
        else:
            self._inbox.nonsense += 1
            self._bar(message.worker, f"{place} sent a message of no known kind")

    def _bar(self, worker: str, reason: str) -> None:
        """Give a worker no more batches."""
        self._ready.discard(worker)
        self._barred.setdefault(worker, reason)
        self._say_once(f"warning: {self._barred[worker]}")

    def _end(self, trial: _Trial) -> Iterator[Outcome]:
        """Handle the end of a batch: try the flights without an outcome again, within `ATTEMPTS`."""
        if trial.future.cancelled():
            raise Interrupted(GONE)
        if not trial.future.done():
            self._client.cancel([trial.future])
        left = left_of(trial.batch, trial.arrived.values())
        if left is None:
            return
        # Dask also gives up batches that only waited on workers that died
        is_unsure = trial.arrived or self._inbox.lost > trial.lost_before
        begun = 0 if is_unsure else trial.begun
        self._silent += 1
        if self._silent > SILENT:
            raise InputError("the Dask workers begin no batch; what was flown is saved, their logs tell the reason")
        if begun < ATTEMPTS:
            self._again.append((left, begun))
        else:
            yield from lost(left, "died with its Dask worker every time")

    def _look_round(self) -> None:
        """Count the workers and their threads at intervals, greet new workers, and tell when there are none."""
        if time.monotonic() - self._counted_s < COUNT_S:
            return
        # a new connection, even to a new scheduler at the same address, knows neither our tasks nor our topic
        if self._client.status == "closed" or self._client.scheduler_comm is not self._line:
            raise Interrupted(GONE)
        try:
            found = self._client.nthreads().items()
            self._threads = {worker: int(threads) for worker, threads in found if _ADDRESS.fullmatch(worker)}
        except Exception as error:
            raise Interrupted(GONE) from error
        self._counted_s = time.monotonic()
        self._ready &= self._threads.keys()
        for worker in self._threads.keys() - self._joins.keys():
            self._greet(worker)
        for worker in self._joins.keys() - self._threads.keys():
            del self._joins[worker]
        for worker in [worker for worker, future in self._joins.items() if future.status == "finished"]:
            if worker not in self._ready | self._barred.keys():  # its answer was lost, or is about to arrive
                self._greet(worker)
        mute = {worker for worker, future in self._joins.items() if future.status == "error"}
        for worker in sorted(mute):
            self._say_once(
                f"warning: the worker at {worker} did not prove that it has the key of the run and flies nothing; "
                f"start it with {VARIABLE}=FILE and with the same scaloft-fi"
            )
        if not self._threads:
            self._say_once("waiting for workers: `dask worker` with the address of the scheduler starts some")
        elif self._barred and self._threads.keys() <= self._barred.keys() | mute:
            raise InputError(next(iter(self._barred.values())))

    def _greet(self, worker: str) -> None:
        """Ask a worker for a proof that it has the key, and send it the study."""
        number, order = self._inbox.order("join", self._greeting, worker)
        self._joins[worker] = self._client.submit(
            *(join, order, self._bundle),
            key=f"scaloft-fi-{self._inbox.run}-{number}",
            workers=[worker],
            pure=False,
            priority=1,
        )

    def _say_once(self, line: str) -> None:
        if line not in self._lines_shown:
            self._lines_shown.add(line)
            self._say(line)
