"""Fly a campaign on a Dask cluster: batches are submitted as tasks, outcomes arrive as events of the scheduler."""

from __future__ import annotations

import logging
import pickle
import tempfile
import time
import uuid
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path
from queue import Empty, SimpleQueue
from typing import TYPE_CHECKING, Any

from scaloft_fi.campaign.flights.worker import Flyer, left_of, lost
from scaloft_fi.campaign.plan.batch import Batch
from scaloft_fi.campaign.processes.patience import ATTEMPTS
from scaloft_fi.campaign.store.fingerprint import fingerprint
from scaloft_fi.campaign.workers.bundle import digest_of, packed
from scaloft_fi.campaign.workers.executor import Workers
from scaloft_fi.campaign.workers.interrupt import Interrupted
from scaloft_fi.campaign.workers.slot import TOPIC, fly_batch
from scaloft_fi.errors import InputError
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.study import Study

if TYPE_CHECKING:
    from distributed import Client, Future

CONNECT_S = 10.0
"""Greatest time to wait for an answer of the scheduler [s, wall]."""
LOOK_UP_S = 0.1
"""Interval between checks for finished batches [s, wall]."""
COUNT_S = 1.0
"""Interval between counts of the workers' threads [s, wall]."""
LEAST_JOBS = 8
"""Least number of threads for which batches are arranged, because workers may join."""
AHEAD = 2
"""Number of batches per thread that are handed out at a time, so that no thread waits."""

GONE = "the Dask scheduler is gone; what was flown is saved, the same command resumes"

Event = tuple[str, int, str, str, Any]
"""Run, number of the batch, address of the worker, kind, content."""


@dataclass(frozen=True)
class Cluster:
    """The workers of the scheduler at `address`, as HOST:PORT."""

    address: str

    @contextmanager
    def workers(
        self, study: Study, flyer: Flyer, *, stop: Callable[[], bool], say: Callable[[str], None]
    ) -> Iterator[Workers]:
        """Connect to the scheduler, and send the study to every worker, also to workers that join later.

        Raises:
            InputError: `distributed` is not installed, or the scheduler cannot be reached.
        """
        try:
            from distributed import Client
            from distributed.diagnostics.plugin import UploadFile
        except ImportError as error:
            how = "pip install 'scaloft-fi[cluster]'"
            raise InputError(f"--executor=dask://{self.address} needs the package distributed: {how}") from error
        logging.getLogger("distributed").setLevel(logging.CRITICAL)  # this package prints its own messages
        bundle = packed(study.folder)
        digest = digest_of(bundle)
        try:
            client = Client(f"tcp://{self.address}", timeout=CONNECT_S, set_as_default=False, name="scaloft-fi")
        except (OSError, ValueError) as error:
            reason = f"no Dask scheduler answers there within {CONNECT_S:g} s"
            raise InputError(f"--executor=dask://{self.address} cannot be reached: {reason}") from error
        with client:
            with tempfile.TemporaryDirectory() as folder:
                path = Path(folder) / digest
                path.write_bytes(bundle)
                client.register_plugin(UploadFile(str(path), load=False), name=f"scaloft-fi-{digest}")
            run = _ClusterWorkers(client, digest, study, flyer, stop, say)
            try:
                client.subscribe_topic(TOPIC, run.receive)
                yield run
            finally:
                with _disconnecting():
                    client.unregister_worker_plugin(f"scaloft-fi-{digest}")


@contextmanager
def _disconnecting() -> Iterator[None]:
    """Ignore errors of the disconnect: the scheduler may be gone, and then the client has closed itself."""
    from distributed.client import ClosedClientError

    with suppress(OSError, TimeoutError, ClosedClientError, AttributeError):
        yield


@dataclass
class _Trial:
    """A batch that was handed out, its outcomes so far, and the number of starts without any outcome."""

    batch: Batch
    future: Future[None]
    begun: int
    arrived: dict[str, Outcome] = field(default_factory=dict)


class _ClusterWorkers:
    """One run on a cluster."""

    def __init__(
        self,
        client: Client,
        bundle: str,
        study: Study,
        flyer: Flyer,
        stop: Callable[[], bool],
        say: Callable[[str], None],
    ) -> None:
        self._client, self._bundle, self._inputs, self._flyer = client, bundle, dict(study.inputs), flyer
        self._stop, self._say = stop, say
        self._id, self._platform = uuid.uuid4().hex, fingerprint()
        self._inbox: SimpleQueue[Event] = SimpleQueue()
        self._trials: dict[int, _Trial] = {}
        self._handed_out = 0
        self._barred: dict[str, str] = {}
        self._lines_shown: set[str] = set()
        self._threads, self._counted_s = 0, -COUNT_S

    @property
    def jobs(self) -> int:
        """Number of threads of all workers."""
        self._count_threads()
        return max(LEAST_JOBS, self._threads)

    def ready(self) -> None:
        """Do nothing: every worker prepares itself."""

    def receive(self, event: tuple[float, Event]) -> None:
        """Receive an event of the topic; called in a thread of the client."""
        self._inbox.put(event[1])

    def map(self, batches: Iterable[Batch]) -> Iterator[Outcome]:
        """Yield the outcomes of `batches` as they arrive; the next batch is taken when a thread may soon be free."""
        source = iter(batches)
        try:
            while not self._stop():
                self._count_threads()
                for batch in islice(source, max(0, AHEAD * self.jobs - len(self._trials))):
                    self._hand_out(batch)
                if not self._trials:
                    return
                # finished batches first: all their events were sent before they ended
                ended = [number for number, trial in self._trials.items() if trial.future.done()]
                yield from self._received(0.0 if ended else LOOK_UP_S)
                for number in ended:
                    yield from self._end(self._trials.pop(number))
        finally:
            with _disconnecting():
                self._client.cancel([trial.future for trial in self._trials.values()])
        yield from self._received(0.0)
        self._trials.clear()

    def _hand_out(self, batch: Batch, begun: int = 0) -> None:
        number = self._handed_out = self._handed_out + 1
        barred = self._barred.keys()
        where = [address for address in self._client.nthreads() if address not in barred] if barred else None
        if where == []:
            raise InputError(next(iter(self._barred.values())))
        work = pickle.dumps((self._flyer, batch))
        future = self._client.submit(
            fly_batch,
            *(self._id, number, self._bundle, self._inputs, self._platform, work),
            key=f"scaloft-fi-{self._id}-{number}",
            workers=where,
            pure=False,
        )
        self._trials[number] = _Trial(batch, future, begun)

    def _received(self, wait_s: float) -> Iterator[Outcome]:
        """Yield the outcomes among the received events; wait at most `wait_s` for the first event [s, wall]."""
        with suppress(Empty):
            while True:
                run, number, worker, kind, content = self._inbox.get(block=wait_s > 0.0, timeout=wait_s)
                wait_s = 0.0
                trial = self._trials.get(number)
                if run != self._id or trial is None:
                    continue
                if kind == "outcome":
                    outcome = pickle.loads(content)
                    if outcome.name not in trial.arrived:  # a batch is flown again whole when its worker is lost
                        trial.arrived[outcome.name] = outcome
                        yield outcome
                elif kind == "begun":
                    trial.begun += 1
                elif kind == "refused":
                    self._barred[worker] = f"the worker at {worker} has other code or data and flies nothing: {content}"
                    self._say_once(f"warning: {self._barred[worker]}")
                elif kind == "platform":
                    self._say_once(
                        f"warning: the worker at {worker} is another platform, digests may differ: {content}"
                    )

    def _end(self, trial: _Trial) -> Iterator[Outcome]:
        """Handle the end of a batch: try the flights without an outcome again, within `ATTEMPTS`."""
        from distributed import KilledWorker

        if trial.future.cancelled():
            raise Interrupted(GONE)
        error = trial.future.exception()
        if isinstance(error, ImportError):
            how = "install the same scaloft-fi on every worker"
            raise InputError(f"a Dask worker cannot fly: {error}; {how}") from error
        if error is not None and not isinstance(error, KilledWorker):
            raise error
        left = left_of(trial.batch, trial.arrived.values())
        if left is None:
            return
        begun = 0 if trial.arrived else trial.begun  # Dask also gives up batches that only waited on workers that died
        if begun < ATTEMPTS:
            self._hand_out(left, begun)
        else:
            yield from lost(left, "died with its Dask worker every time")

    def _count_threads(self) -> None:
        """Count the workers' threads at intervals, and print a notice when there are none."""
        if time.monotonic() - self._counted_s < COUNT_S:
            return
        if self._client.status == "closed":  # the client has given up
            raise Interrupted(GONE)
        try:
            self._threads = sum(self._client.nthreads().values())
        except OSError as error:
            raise Interrupted(GONE) from error
        self._counted_s = time.monotonic()
        if not self._threads:
            self._say_once("waiting for workers: `dask worker` with the address of the scheduler starts some")

    def _say_once(self, line: str) -> None:
        if line not in self._lines_shown:
            self._lines_shown.add(line)
            self._say(line)
