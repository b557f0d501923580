"""A run on a Dask cluster: nobody there is trusted without the key of the cluster."""

from __future__ import annotations

import hmac
import json
import logging
import os
import re
import ssl
import stat
import threading
import time
import uuid
from collections import defaultdict, deque
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import astuple, dataclass, field
from functools import lru_cache
from pathlib import Path
from queue import Empty, SimpleQueue
from typing import TYPE_CHECKING, Any, Final

from scaloft_fi.campaign.flight import Batch, Flight
from scaloft_fi.campaign.flights.fly import Flyer, invalid, left_of, lost
from scaloft_fi.campaign.pool import Pool
from scaloft_fi.campaign.processes import ATTEMPTS, started_clean
from scaloft_fi.campaign.store.origin import differences, fingerprint
from scaloft_fi.campaign.workers.local import Interrupted, LateWorker, Workers
from scaloft_fi.campaign.workers.plain import (
    batch_from_plain,
    batch_to_plain,
    digest_of,
    flyer_from_plain,
    flyer_to_plain,
    outcome_from_plain,
    outcome_to_plain,
    packed,
    unpacked,
)
from scaloft_fi.document import read_bytes
from scaloft_fi.errors import InputError
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.registry import in_one_line
from scaloft_fi.study import Study

if TYPE_CHECKING:
    from distributed import Client, Future, Security
    from distributed import Worker as DaskWorker


VARIABLE: Final = "SCALOFT_CLUSTER_KEY"
"""The environment variable with the path of the key file."""
MAKE = "(umask 077; head -c 32 /dev/urandom | base64 > cluster.key)"
"""A command that makes a key file."""
LEAST_BYTES, MOST_BYTES = 32, 4096
"""Least and greatest size of a key file [bytes]."""
MOST_MESSAGE: Final = 1 << 20
"""Greatest length of a sealed message; the largest of the reference campaign has 35,500, of a track of 25,857 bytes."""
_MAC_LENGTH = 64


@dataclass(frozen=True)
class Message:
    """What a run and a worker tell each other.

    Attributes:
        run: id of the run.
        number: number of the task in the run.
        worker: address of the worker that sends it, or that it is for; "" = any worker.
        order: 1 for the first message of this worker about this task, then 2, 3, ...; a repeated message is ignored.
        kind: what the message says.
        content: plain JSON values.
    """

    run: str
    number: int
    worker: str
    order: int
    kind: str
    content: Any = None


def read_key(path: Path) -> bytes:
    """Read a key file.

    Raises:
        InputError: it is no regular file, too short or too long, or others may read it.
    """
    content = read_bytes(path, MOST_BYTES).strip()
    mode = stat.S_IMODE(path.stat().st_mode)
    if os.name == "posix" and mode & 0o077:
        raise InputError(f"{path}: mode={mode:03o} lets others read the key; `chmod 600 {path}` stops that")
    if len(content) < LEAST_BYTES:
        raise InputError(f"{path}: a key file has {LEAST_BYTES} to {MOST_BYTES} bytes; {MAKE} makes one")
    return content


def sealed(key: bytes, message: Message) -> str:
    """The signature of a message, then the message.

    Raises:
        ValueError: the message is longer than `MOST_MESSAGE`, or a number in it is not finite.
    """
    body = json.dumps(astuple(message), allow_nan=False)
    if _MAC_LENGTH + len(body) > MOST_MESSAGE:
        raise ValueError(f"a message of {len(body)} bytes is longer than {MOST_MESSAGE}")
    return _mac(key, body) + body


def unsealed(key: bytes, text: object) -> Message:
    """The message in a sealed text; nothing of it is parsed before its signature is found right.

    Raises:
        ValueError: the text is too long, of another type, or not signed with this key.
    """
    if not isinstance(text, str) or not _MAC_LENGTH < len(text) <= MOST_MESSAGE:
        raise ValueError("no sealed message")
    mac, body = text[:_MAC_LENGTH], text[_MAC_LENGTH:]
    if not hmac.compare_digest(mac.encode(errors="replace"), _mac(key, body).encode()):
        raise ValueError("the message is not signed with this key")
    parts = json.loads(body)
    if not isinstance(parts, list) or list(map(type, parts[:-1])) != [str, int, str, int, str]:
        raise ValueError("the message has other parts")
    return Message(*parts)


def topic_of(key: bytes) -> str:
    """The topic of the events of all runs with this key; the scheduler keeps the last thousand events of each topic."""
    return f"scaloft-fi-{_mac(key, 'topic')[:16]}"


def _mac(key: bytes, body: str) -> str:
    return hmac.new(key, f"scaloft-fi 1 {body}".encode(errors="surrogatepass"), "sha256").hexdigest()


FILES = ("ca.pem", "cert.pem", "key.pem")
"""The files of the folder: the certificate of the authority, our own certificate, our own private key."""


def check_certificates(folder: Path) -> None:
    """Check early that the files of `folder` are certificates and a key that fit.

    Raises:
        InputError: a file is missing or no certificate.
    """
    for name in FILES:
        if not (folder / name).is_file():
            raise InputError(f"--cluster-security={folder}: {folder / name} is missing; needed: {', '.join(FILES)}")
    authority, certificate, key = (str(folder / name) for name in FILES)
    try:
        context = ssl.create_default_context(cafile=authority)
        context.load_cert_chain(certificate, key, password="")
    except (OSError, ValueError) as error:
        reason = getattr(error, "reason", None) or error
        raise InputError(f"--cluster-security={folder}: {', '.join(FILES)} do not fit each other: {reason}") from error


def security_of(folder: Path | None) -> Security:
    """The security of a client with the certificates in `folder`; None = not encrypted."""
    from distributed import Security

    if folder is None:
        return Security()
    authority, certificate, key = (str(folder / name) for name in FILES)
    return Security(tls_ca_file=authority, tls_client_cert=certificate, tls_client_key=key, require_encryption=True)


class Inbox:
    """The messages of one run.

    Args:
        key: key of the cluster.

    Attributes:
        strange: number of messages that were none of this run's.
        nonsense: number of messages with the key that made no sense.
        lost: number of times at which messages of our workers may have been lost among strange ones.
    """

    def __init__(self, key: bytes) -> None:
        self._key, self._run = key, uuid.uuid4().hex
        self._messages: SimpleQueue[Message] = SimpleQueue()
        self._numbers = 0
        self._heard: dict[tuple[int, str], int] = {}
        self.strange, self.nonsense, self.lost = 0, 0, 0

    def order(self, kind: str, content: Any, worker: str = "") -> tuple[int, str]:
        """The number of a new task, and the sealed order for it; `worker` = "" is for any worker."""
        self._numbers += 1
        return self._numbers, sealed(self._key, Message(self._run, self._numbers, worker, 1, kind, content))

    @property
    def run(self) -> str:
        """Id of the run."""
        return self._run

    def receive(self, event: Any) -> None:
        """Receive an event of the topic, a pair of time and sealed message; called in a thread of the client."""
        try:
            message = unsealed(self._key, event[1])
        except (ValueError, TypeError, LookupError):
            self.strange += 1
            return
        if message.run != self._run:  # another run with the same key uses the same topic
            return
        sender = message.number, message.worker
        if message.number > self._numbers or message.order <= self._heard.get(sender, 0):
            self.strange += 1
            return
        self._heard[sender] = message.order
        self._messages.put(message)

    def skip(self) -> None:
        """Count what the connection did not read; messages of our workers may have been packed with it."""
        self.strange += 1
        self.lost += 1

    def messages(self, wait_s: float) -> Iterator[Message]:
        """The messages that have arrived; wait at most `wait_s` for the first of them [s, wall]."""
        with suppress(Empty):
            while True:
                yield self._messages.get(block=wait_s > 0.0, timeout=wait_s)
                wait_s = 0.0

    def summary(self) -> Iterator[str]:
        """How many messages were ignored, for the end of a run."""
        if self.strange:
            yield f"warning: {self.strange} messages on the scheduler did not carry the key of the run and were ignored"
        if self.nonsense:
            yield f"warning: {self.nonsense} messages of workers held no outcome that was asked for and were ignored"


IDLE_S = 60.0
"""A process without a task for this time ends, because its run has ended or died [s, wall]."""

_idle: dict[tuple[Path, str | None, str], list[_Slot]] = defaultdict(list)
_taken: set[tuple[str, int]] = set()
_lock = threading.Lock()

Send = Callable[[str, Any], None]


def join(order: str, bundle: bytes) -> None:
    """Prove to a run that this worker has its key, and take its study.

    Sends `ready`; or `refused` when the hashes of study or code are others than in the run; or `failed` when the study
    cannot be read there; before that `platform` when the platform is another than the run's.

    Args:
        order: a sealed message with the digest of the bundle, the hashes of the run's inputs, its platform.
        bundle: the packed study.

    Raises:
        ScaloftError: the order does not carry the key of this worker.
    """
    with _opened(order, "join") as (content, scratch, send, _):
        if digest_of(bundle) != content["bundle"]:
            raise InputError("the study that came is not the one that was sent")
        ours = _study(unpacked(bundle, _folder(scratch, content)), content["grid"]).inputs
        theirs = content["inputs"]
        other = [part for part, digest in theirs.items() if ours.get(part) != digest]
        changed = differences(content["platform"], fingerprint())
        if changed:
            send("platform", ", ".join(changed))
        if other:
            parts = (f"{part} {ours.get(part, 'none')[:12]}, not {theirs[part][:12]}" for part in other)
            send("refused", ", ".join(parts))
        else:
            send("ready", None)


def fly_batch(order: str) -> None:
    """Fly one batch; sends `begun`, then each `outcome` when it is known, or `failed` when the study cannot be flown.

    Args:
        order: a sealed message with the digest of the study's bundle, the flyer and the batch.

    Raises:
        ScaloftError: the order does not carry the key of this worker.
    """
    with _opened(order, "fly") as (content, scratch, send, stop):
        send("begun", None)
        folder = _folder(scratch, content)
        study = _study(folder, content["grid"])
        batch = batch_from_plain(study, content["batch"])
        flights = {flight.name: flight for flight in batch.flights}
        with _slot(study, content["flyer"], stop) as pool:
            for outcome in pool.map([batch]):
                _send_outcome(send, flights[outcome.name], outcome)


def _send_outcome(send: Send, flight: Flight, outcome: Outcome) -> None:
    try:
        send("outcome", outcome_to_plain(outcome))
    except ValueError as error:
        send("outcome", outcome_to_plain(invalid(flight, f"its outcome cannot be sent: {error}")))


@contextmanager
def _opened(order: str, kind: str) -> Iterator[tuple[Mapping[str, Any], Path, Send, Callable[[], bool]]]:
    """Content of a sealed order, folder of the worker, a function that sends, and whether the run gave the order up.

    An error inside the context is sent as `failed`.
    """
    from distributed import get_worker

    worker: DaskWorker = get_worker()
    task = worker.get_current_task()
    path = os.environ.get(VARIABLE)
    if not path:
        raise InputError(f"{VARIABLE} is not set: start the worker with the path of the run's key file in it")
    key = read_key(Path(path))
    try:
        message = unsealed(key, order)
    except ValueError as error:
        raise InputError(f"an order does not carry the key in {path}, and is not followed") from error
    known = (message.run, message.number)
    with _lock:
        if message.kind != kind or message.worker not in ("", worker.address) or known in _taken:
            raise InputError("an order was sent twice, or is for another worker, and is not followed")
        _taken.add(known)
    orders = iter(range(1, 1 << 31))

    def send(kind: str, content: Any) -> None:
        note = Message(message.run, message.number, worker.address, next(orders), kind, content)
        worker.log_event(topic_of(key), sealed(key, note))

    def stop() -> bool:  # the run no longer wants the batch
        state = worker.state.tasks.get(task)
        return state is None or state.state == "cancelled"

    try:
        yield message.content, Path(worker.local_directory), send, stop
    except Exception as error:  # noqa: BLE001 - an exception would reach the run as a pickle, which it does not read
        send("failed", str(error) if isinstance(error, InputError) else in_one_line(error))


@dataclass(eq=False)
class _Slot:
    """A process that flies; its pool starts it at its first batch and replaces it when it dies."""

    work: LateWorker
    stop: Callable[[], bool] = lambda: False
    pool: Pool[Batch, Outcome] = field(init=False)
    expiry: threading.Timer | None = None

    def __post_init__(self) -> None:
        self.pool = Pool(
            self.work, 1, left=left_of, lost=lost, stop=lambda: self.stop(), patient=False, start=started_clean
        )


@contextmanager
def _slot(study: Study, flyer: Mapping[str, Any], stop: Callable[[], bool]) -> Iterator[Pool[Batch, Outcome]]:
    """The pool of an idle slot, else of a new slot; the slot is kept for the next batch, or closed after an error."""
    slots = _idle[study.folder, study.grid_name, json.dumps(flyer)]
    with _lock:
        slot = slots.pop() if slots else _Slot(LateWorker(study.folder, study.grid_name, flyer_from_plain(flyer)))
        if slot.expiry:
            slot.expiry.cancel()
    slot.stop = stop
    try:
        yield slot.pool
    except BaseException:
        slot.pool.close()
        raise
    with _lock:
        slots.append(slot)
        slot.expiry = threading.Timer(IDLE_S, _expire, (slots, slot))
        slot.expiry.daemon = True
        slot.expiry.start()


def _expire(slots: list[_Slot], slot: _Slot) -> None:
    with _lock:
        if slot not in slots:
            return
        slots.remove(slot)
    slot.pool.close()


def _folder(scratch: Path, content: Mapping[str, Any]) -> Path:
    return scratch / f"study-{content['bundle']}"


@lru_cache
def _study(folder: Path, grid_name: str | None) -> Study:
    return Study.open(folder, grid_name)


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


CONNECT_S = 10.0
"""Greatest time to wait for an answer of the scheduler [s, wall]."""


@dataclass(frozen=True)
class Cluster:
    """The workers of a scheduler that have the key.

    Attributes:
        address: of the scheduler, as HOST:PORT.
        key: key of the cluster.
        certificates: folder of the certificates; None = Dask does not encrypt.
    """

    address: str
    key: bytes = field(repr=False)
    certificates: Path | None = None

    @contextmanager
    def workers(
        self, study: Study, flyer: Flyer, *, stop: Callable[[], bool], say: Callable[[str], None]
    ) -> Iterator[Workers]:
        """Connect to the scheduler; each worker that proves that it has the key gets the study, also if it joins later.

        Raises:
            InputError: `distributed` is not installed, or the scheduler cannot be reached.
        """
        try:
            from distributed import Client

            from scaloft_fi.campaign.workers.inert import inert_scheme

        except ImportError as error:
            how = "pip install 'scaloft-fi[cluster]'"
            raise InputError(f"--executor=dask://{self.address} needs the package distributed: {how}") from error
        for name in ("distributed", "distributed.client"):  # this package prints its own messages
            logging.getLogger(name).setLevel(logging.CRITICAL)
        bundle, inbox = packed(study.folder), Inbox(self.key)
        with inert_scheme(tls=self.certificates is not None, skipped=inbox.skip) as scheme:
            try:
                client = Client(
                    f"{scheme}://{self.address}",
                    timeout=CONNECT_S,
                    set_as_default=False,
                    name="scaloft-fi",
                    security=security_of(self.certificates),
                )
            except (OSError, ValueError, TypeError, LookupError, AttributeError, AssertionError) as error:
                reason = f"no Dask scheduler answers there within {CONNECT_S:g} s"
                if self.certificates is not None:
                    reason += f" with the certificates in {self.certificates}"
                raise InputError(f"--executor=dask://{self.address} cannot be reached: {reason}") from error
            with client:
                try:
                    with disconnecting():
                        client.subscribe_topic(topic_of(self.key), inbox.receive)
                    yield ClusterRun(client, inbox, bundle, study, flyer, stop, say)
                finally:
                    for line in inbox.summary():
                        say(line)
