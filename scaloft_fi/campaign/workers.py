"""Who flies a run: processes of this machine, or a Dask cluster; and the signals that let a run save and end.

The cluster is Dask as it is, over mutual TLS only, so that nobody without its certificate takes part.  Everybody who
has the certificate is trusted: Dask lets each of them run code on scheduler and workers, and the run unpickles what
workers answer.
"""

from __future__ import annotations

import hashlib
import io
import logging
import math
import os
import re
import signal
import ssl
import stat
import tempfile
import threading
import time
import uuid
import zipfile
from collections import defaultdict, deque
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager, suppress
from dataclasses import dataclass, field
from functools import cache, lru_cache
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING, Any, Protocol

from scaloft_fi.campaign import processes
from scaloft_fi.campaign.flights.fly import Batch, Flyer, Worker, left_of, lost
from scaloft_fi.campaign.processes import ProcessPool, Work
from scaloft_fi.campaign.store.archive import study_files
from scaloft_fi.campaign.store.platforms import differences, fingerprint
from scaloft_fi.document import read_bytes
from scaloft_fi.errors import InputError, ScaloftError, needed
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.registry import in_one_line
from scaloft_fi.study import Study

if TYPE_CHECKING:
    from distributed import Client, Future, Security
    from distributed import Worker as DaskWorker


class Workers(Protocol):
    """The workers of one run."""

    @property
    def jobs(self) -> int:
        """Number of processes for which batches are arranged."""

    def ready(self) -> None:
        """Prepare the workers for flights; `map` calls it if necessary.

        Raises:
            InputError: the study cannot be flown.
        """

    def map(self, batches: Iterable[Batch]) -> Iterator[Outcome]:
        """Yield the outcomes of `batches` as they arrive, in any order.

        A batch whose worker dies is tried again in another worker; flights that fail every time are `invalid`.

        Raises:
            ScaloftError: the study cannot be flown, or no worker is left.
        """


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

    hangup = [number for number in processes.HANGUP if signal.getsignal(number) != signal.SIG_IGN]
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
    """The work of a new process: it reads the study when it gets its first batch.

    Attributes:
        study: the study.
        flyer: flies.
        inputs: hashes of the study that the run has read; None where others have compared them.
    """

    study: Study
    flyer: Flyer
    inputs: Mapping[str, str] | None = None
    _worker: Worker | None = None

    def __call__(self, batch: Batch, report: Callable[[Outcome], None]) -> None:
        """Fly one batch.

        Raises:
            InputError: the study cannot be flown, or has changed since the run has read it.
        """
        if self._worker is None:
            if self.inputs is not None and self.inputs != self.study.inputs:
                raise InputError(f"{self.study.folder}: the study has changed since the run began; run again")
            self.flyer.prepare(self.study, lambda _text: None)
            self._worker = Worker(self.study, self.flyer)
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
            work = LateWorker(study, flyer, study.inputs)
        # a command ends itself after its limit, before the pool takes its worker for hung
        with ProcessPool(
            work,
            self.jobs,
            left=left_of,
            lost=lost,
            stop=stop,
            patience_s=max(processes.WORKER_PATIENCE_S, (processes.ATTEMPTS + 1) * study.most_wall_s),
            start=processes.started_clean if self.clean else processes.forked,
        ) as pool:

            def prepare() -> None:
                if self.clean:  # an empty batch prepares the first process, which compiles the kernels for all of them
                    list(pool.map([Batch(())]))
                else:
                    flyer.prepare(study, say)

            yield LocalWorkers(pool.jobs, pool, cache(prepare))


@dataclass(frozen=True)
class LocalWorkers:
    """The workers of a pool.

    Attributes:
        jobs: number of its processes.
        pool: the pool.
        ready: prepares its processes, once.
    """

    jobs: int
    pool: ProcessPool[Batch, Outcome]
    ready: Callable[[], None]

    def map(self, batches: Iterable[Batch]) -> Iterator[Outcome]:
        """Yield the outcomes of `batches` as they arrive."""
        self.ready()
        return self.pool.map(batches)


CERTIFICATE, KEY, AUTHORITY = "cert.pem", "key.pem", "ca.pem"
"""The files of the folder: our certificate, our private key, and the authority's certificate if that is not ours."""
MAKE = (
    "(umask 077; mkdir cluster; openssl req -x509 -newkey rsa:3072 -nodes -days 365 -subj /CN=cluster "
    "-keyout cluster/key.pem -out cluster/cert.pem)"
)
"""The command that makes a certificate which all parts of a cluster share."""


def check_certificates(folder: Path) -> None:
    """Check early that the files of `folder` are certificates and a key that fit.

    Raises:
        InputError: a file is missing or no certificate, or others may read the key.
    """
    place = f"--cluster-security={folder}"
    for name in (CERTIFICATE, KEY):
        if not (folder / name).is_file():
            raise InputError(f"{place}: {folder / name} is missing; `{MAKE}` makes {CERTIFICATE} and {KEY}")
    mode = stat.S_IMODE((folder / KEY).stat().st_mode)
    if os.name == "posix" and mode & 0o077:
        key = folder / KEY
        raise InputError(f"{key}: mode={mode:03o} lets others read the key; `chmod 600 {key}` stops that")
    try:
        context = ssl.create_default_context(cafile=str(_authority(folder)))
        context.load_cert_chain(folder / CERTIFICATE, folder / KEY, password="")
    except (OSError, ValueError) as error:
        reason = getattr(error, "reason", None) or error
        names = ", ".join(dict.fromkeys((_authority(folder).name, CERTIFICATE, KEY)))
        raise InputError(f"{place}: {names} do not fit each other: {reason}") from error


def _authority(folder: Path) -> Path:
    """The certificate that has signed those of all parts; without one ours, which all share."""
    own = folder / AUTHORITY
    return own if own.is_file() else folder / CERTIFICATE


def security_of(folder: Path) -> Security:
    """The security of a client with the certificates in `folder`."""
    from distributed import Security

    authority, certificate, key = (str(path) for path in (_authority(folder), folder / CERTIFICATE, folder / KEY))
    return Security(tls_ca_file=authority, tls_client_cert=certificate, tls_client_key=key, require_encryption=True)


LOCAL = "local"
_DASK = re.compile(r"dask://(?P<address>[^/\s:@]+:[0-9]{1,5}|\[[0-9A-Fa-f:.]+\]:[0-9]{1,5})/?")


def executor_named(name: str, jobs: int | None, certificates: Path | None = None) -> Executor:
    """The executor for the values of `--executor`, `--jobs` and `--cluster-security`.

    Raises:
        InputError: the name is no executor, an option does not belong to it, or a certificate is missing.
    """
    if name == LOCAL:
        if certificates is not None:
            raise InputError(f"--cluster-security={certificates} is for --executor=dask://HOST:PORT")
        return Local(jobs or processes.cores())
    match = _DASK.fullmatch(name)
    if match is None:
        raise InputError(f"--executor={name!r} must be 'local' or 'dask://HOST:PORT', the address of a Dask scheduler")
    if jobs is not None:
        raise InputError(f"--jobs={jobs} is for --executor=local; how many fly on {name} is up to its workers")
    if certificates is None:
        raise InputError(
            f"--executor={name} needs a certificate, because on an open scheduler anybody can run code: make one with "
            f"`{MAKE}`, start scheduler and workers with it, and give run --cluster-security=cluster"
        )
    check_certificates(certificates)
    return Cluster(match["address"], certificates)


def packed(study: Path) -> bytes:
    """Pack the documents of a study; equal content gives equal bytes.

    Raises:
        InputError: a file cannot be read.
    """
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w") as archive:
        for path in study_files(study):
            name = zipfile.ZipInfo(path.relative_to(study).as_posix())
            archive.writestr(name, read_bytes(path), zipfile.ZIP_DEFLATED)
    return content.getvalue()


def unpacked(bundle: bytes, folder: Path) -> Path:
    """Unpack the study of `bundle` into `folder` once; other processes may do the same at the same time.

    Raises:
        OSError, zipfile.BadZipFile: the study cannot be unpacked.
    """
    if not folder.is_dir():
        with tempfile.TemporaryDirectory(prefix=f"{folder.name}-", dir=folder.parent) as begun:
            fresh = Path(begun) / folder.name
            with zipfile.ZipFile(io.BytesIO(bundle)) as archive:
                archive.extractall(fresh)
            with suppress(OSError):  # another process was faster
                os.rename(fresh, folder)  # noqa: PTH104 - it must fail then
    return folder


IDLE_S = 60.0
"""A process without a task for this time ends, because its run has ended or died [s, wall]."""

_Kept = tuple[ProcessPool[Batch, Outcome], threading.Timer]
"""A process that flies, and when it ends."""
_idle: dict[tuple[Path, str | None, Flyer], list[_Kept]] = defaultdict(list)
_lock = threading.Lock()


@dataclass(frozen=True)
class Sent:
    """What a worker needs to fly a study.

    Attributes:
        bundle: the packed study.
        name: its digest.
        grid: name of the grid.
        inputs: hashes of what the run flies, by part.
        platform: of the run.
    """

    bundle: bytes = field(repr=False)
    name: str
    grid: str | None
    inputs: Mapping[str, str]
    platform: Mapping[str, str]

    @classmethod
    def of(cls, study: Study) -> Sent:
        """Pack a study."""
        bundle = packed(study.folder)
        name = hashlib.sha256(bundle).hexdigest()
        return cls(bundle, name, study.grid_name, dict(study.inputs), fingerprint())


def greet(sent: Sent) -> tuple[str, str]:
    """Take the study of a run, and compare code, data and platform; runs on a worker.

    Returns:
        why it flies nothing, and how its platform differs from the run's; each "" where there is nothing to say.
    """
    try:
        ours = _study(unpacked(sent.bundle, _folder(sent.name)), sent.grid).inputs
    except Exception as error:  # noqa: BLE001 - whatever it is, the run has to tell it
        return f"cannot fly the study: {error if isinstance(error, InputError) else in_one_line(error)}", ""
    parts = [
        f"{part} {ours.get(part, 'none')[:12]}, not {digest[:12]}"
        for part, digest in sent.inputs.items()
        if ours.get(part) != digest
    ]
    refusal = f"has other code or data and flies nothing: {', '.join(parts)}" if parts else ""
    return refusal, ", ".join(differences(sent.platform, fingerprint()))


def fly_batch(name: str, grid: str | None, flyer: Flyer, batch: Batch) -> list[Outcome] | None:
    """Fly one batch in a process of its own; runs on a worker.  None where the worker has lost the study `name`."""
    folder = _folder(name)
    if not folder.is_dir():
        return None
    idle = _idle[folder, grid, flyer]  # a pool starts its process at its first batch and replaces it when it dies
    with _lock:
        pool, expiry = idle.pop() if idle else (None, None)
    if expiry is not None:
        expiry.cancel()
    if pool is None:
        work, start = LateWorker(_study(folder, grid), flyer), processes.started_clean
        pool = ProcessPool(work, 1, left=left_of, lost=lost, stop=_unwanted, patient=False, start=start)
    try:
        flown = list(pool.map([batch]))
    except BaseException:
        pool.close()
        raise
    entry: _Kept = pool, threading.Timer(IDLE_S, lambda: _expire(idle, entry))
    entry[1].daemon = True
    with _lock:
        idle.append(entry)
    entry[1].start()
    return flown


def _worker() -> DaskWorker:
    """The worker that runs this."""
    from distributed import get_worker

    return get_worker()


def _unwanted() -> bool:
    """Whether the run no longer wants the task that this thread of a worker flies."""
    worker = _worker()
    state = worker.state.tasks.get(worker.get_current_task())
    return state is None or state.state == "cancelled"


def _expire(idle: list[_Kept], entry: _Kept) -> None:
    with _lock:
        if entry not in idle:
            return
        idle.remove(entry)
    entry[0].close()


def _folder(name: str) -> Path:
    """Where this worker keeps a study."""
    return Path(_worker().local_directory) / f"study-{name}"


@lru_cache
def _study(folder: Path, grid_name: str | None) -> Study:
    return Study.open(folder, grid_name)


LOOK_UP_S = 0.1
"""Interval between checks for finished batches [s, wall]."""
COUNT_S = 1.0
"""Interval between counts of the workers and their threads [s, wall]."""
TAKEN = 10
"""Greatest number of tasks of a run that somebody may take from the scheduler."""
LEAST_JOBS = 8
"""Least number of threads for which batches are arranged, because workers may join."""
AHEAD = 2
"""Number of batches per thread that are handed out at a time, so that no thread waits."""
CONNECT_S = 10.0
"""Greatest time to wait for an answer of the scheduler [s, wall]."""

GONE = "the Dask scheduler is gone; what was flown is saved, the same command resumes"
ROBBED = "somebody takes the tasks of this run from the Dask scheduler; what was flown is saved"


@contextmanager
def disconnecting() -> Iterator[None]:
    """Ignore errors of the disconnect: the scheduler may be gone, and then the client has closed itself."""
    from distributed.client import ClosedClientError

    with suppress(OSError, TimeoutError, ClosedClientError, AttributeError):
        yield


@dataclass(frozen=True)
class _Trial:
    """A batch that was handed out.

    Attributes:
        where: to which workers.
        alone: whether nothing else was under way, so that nobody else is to blame when its worker dies.
    """

    batch: Batch
    where: frozenset[str]
    alone: bool


class ClusterRun:
    """One run on a cluster.

    Args:
        client: connected to the scheduler.
        sent: the study.
        flyer, stop, say: as for an executor.
    """

    def __init__(
        self, client: Client, sent: Sent, flyer: Flyer, stop: Callable[[], bool], say: Callable[[str], None]
    ) -> None:
        self._client, self._flyer, self._stop, self._say = client, flyer, stop, say
        self._line = client.scheduler_comm
        self._run = uuid.uuid4().hex
        self._sent = sent
        self._trials: dict[Future[list[Outcome] | None], _Trial] = {}
        self._again = deque[Batch]()
        self._suspect = deque[Batch]()
        self._greeted: dict[str, Future[tuple[str, str]]] = {}
        self._ready: set[str] = set()
        self._barred: dict[str, str] = {}
        self._said: set[str] = set()
        self._taken = 0
        self._threads: dict[str, int] = {}
        self._counted_s = -COUNT_S

    @property
    def jobs(self) -> int:
        """Number of threads of all workers."""
        self._look_round()
        return max(LEAST_JOBS, sum(self._threads.values()))

    def ready(self) -> None:
        """Do nothing: every worker prepares itself."""

    def map(self, batches: Iterable[Batch]) -> Iterator[Outcome]:
        """Yield the outcomes of `batches` as they arrive; the next batch is taken when a thread may soon be free."""
        source, is_empty = iter(batches), False
        try:
            while not self._stop():
                self._look_round()
                self._hear()
                while self._room() and not is_empty:
                    batch = self._again.popleft() if self._again else next(source, None)
                    if batch is None:
                        is_empty = True
                    else:
                        self._hand_out(batch)
                if is_empty and not self._trials and not self._again:
                    if not self._suspect:
                        return
                    if self._room():
                        self._hand_out(self._suspect.popleft(), alone=True)
                alive = self._threads.keys()  # a batch ends, or waits for workers that are gone
                ended = [future for future, trial in self._trials.items() if future.done() or not trial.where & alive]
                for future in ended:
                    yield from self._end(future, self._trials.pop(future))
                if not ended:
                    time.sleep(LOOK_UP_S)
                is_empty = is_empty and not self._again
        finally:
            with disconnecting():
                self._client.cancel([*self._trials])
            self._trials.clear()
            self._again.clear()
            self._suspect.clear()

    def _room(self) -> bool:
        return len(self._trials) < AHEAD * sum(self._threads.get(worker, 0) for worker in self._ready)

    def _hand_out(self, batch: Batch, *, alone: bool = False) -> None:
        words = {"key": self._key(), "workers": sorted(self._ready), "pure": False}
        future = self._client.submit(fly_batch, self._sent.name, self._sent.grid, self._flyer, batch, **words)
        self._trials[future] = _Trial(batch, frozenset(self._ready), alone)

    def _key(self) -> str:
        return f"scaloft-fi-{self._run}-{uuid.uuid4().hex}"

    def _end(self, future: Future[list[Outcome] | None], trial: _Trial) -> Iterator[Outcome]:
        """Handle the end of a batch: flights without an outcome are flown again; Dask has tried several workers."""
        flown: list[Outcome] = []
        if future.status == "finished":
            told = future.result(timeout=CONNECT_S)
            if told is None:
                self._greeted.clear()
                self._ready.clear()
            wanted = {flight.name for flight in trial.batch.flights}
            flown = [outcome for outcome in told or () if outcome.name in wanted]
            yield from flown
        error = future.exception(timeout=CONNECT_S) if future.status == "error" else None
        if isinstance(error, InputError):  # the study cannot be flown there, nor anywhere
            raise error
        left = left_of(trial.batch, flown)
        if left is None:
            return
        if error is None:  # its workers are gone, lost the study, or somebody took the task
            if future.status in ("cancelled", "lost"):
                self._note_taken()
            self._client.cancel([future])
            self._again.append(left)
        elif trial.alone:
            yield from lost(left, "died with its Dask worker every time")
        else:  # over one of them, or of another batch, workers die
            self._suspect += [Batch((flight,)) for flight in left.flights]

    def _look_round(self) -> None:
        """Count the workers and their threads at intervals, greet new workers, and tell when there are none."""
        if time.monotonic() - self._counted_s < COUNT_S:
            return
        # a new connection, even to a new scheduler at the same address, knows nothing of our tasks
        if self._client.status == "closed" or self._client.scheduler_comm is not self._line:
            raise Interrupted(GONE)
        try:
            self._threads = dict(self._client.nthreads())
        except Exception as error:
            raise Interrupted(GONE) from error
        self._counted_s = time.monotonic()
        self._greeted = {worker: future for worker, future in self._greeted.items() if worker in self._threads}
        self._ready &= self._threads.keys()
        for worker in self._threads:
            if worker in self._greeted and self._greeted[worker].status in ("cancelled", "lost"):
                self._note_taken()
                del self._greeted[worker]
            if worker not in self._greeted:
                words = {"key": self._key(), "workers": [worker], "pure": False, "priority": 1}
                self._greeted[worker] = self._client.submit(greet, self._sent, **words)
        if not self._threads:
            self._say_once("waiting for workers: `dask worker` with the address of the scheduler starts some")
        elif self._threads.keys() <= self._barred.keys():
            raise InputError(next(iter(self._barred.values())))

    def _hear(self) -> None:
        """Hear what workers have answered."""
        for worker, future in self._greeted.items():
            if worker in self._ready or worker in self._barred or future.status not in ("finished", "error"):
                continue
            refusal, platform = "cannot take the study; start it with the same scaloft-fi", ""
            if future.status == "finished":
                refusal, platform = future.result(timeout=CONNECT_S)
            place = f"the worker at {worker}"
            if platform:
                self._say_once(f"warning: {place} is another platform, digests may differ: {platform}")
            if refusal:
                self._barred[worker] = f"{place} {refusal}"
                self._say_once(f"warning: {self._barred[worker]}")
            else:
                self._ready.add(worker)

    def _note_taken(self) -> None:
        """Note that a task was taken from the scheduler; it is handed out again.

        Raises:
            InputError: that happens again and again.
        """
        self._taken += 1
        if self._taken > TAKEN:
            raise InputError(ROBBED)

    def _say_once(self, line: str) -> None:
        if line not in self._said:
            self._said.add(line)
            self._say(line)


@dataclass(frozen=True)
class Cluster:
    """The workers of a scheduler.

    Attributes:
        address: of the scheduler, as HOST:PORT.
        certificates: folder of the certificates.
    """

    address: str
    certificates: Path

    @contextmanager
    def workers(
        self, study: Study, flyer: Flyer, *, stop: Callable[[], bool], say: Callable[[str], None]
    ) -> Iterator[Workers]:
        """Connect to the scheduler; each worker gets the study, also if it joins later.

        Raises:
            InputError: `distributed` is not installed, or the scheduler cannot be reached.
        """
        needs = f"--executor=dask://{self.address} needs the package distributed"
        distributed = needed("distributed", needs, "cluster")
        for name in ("distributed", "distributed.client"):  # this package prints its own messages
            logging.getLogger(name).setLevel(logging.CRITICAL)
        try:
            client = distributed.Client(
                f"tls://{self.address}",
                timeout=CONNECT_S,
                set_as_default=False,
                name="scaloft-fi",
                security=security_of(self.certificates),
            )
        except (OSError, ValueError, TypeError, LookupError, AttributeError, AssertionError) as error:
            reason = f"no Dask scheduler answers there within {CONNECT_S:g} s with the certificates in"
            sentence = f"--executor=dask://{self.address} cannot be reached: {reason} {self.certificates}"
            raise InputError(sentence) from error
        with client, disconnecting():
            yield ClusterRun(client, Sent.of(study), flyer, stop, say)
