"""The code in a Dask worker: each of its threads has a process that flies, and sends the outcomes as sealed events."""

from __future__ import annotations

import json
import os
import threading
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from scaloft_fi.campaign.flights.fly import invalid
from scaloft_fi.campaign.flights.worker import left_of, lost
from scaloft_fi.campaign.plan.batch import Batch
from scaloft_fi.campaign.plan.flight import Flight
from scaloft_fi.campaign.processes.pool import Pool
from scaloft_fi.campaign.processes.start import started_clean
from scaloft_fi.campaign.store.fingerprint import differences, fingerprint
from scaloft_fi.campaign.workers.bundle import digest_of, unpacked
from scaloft_fi.campaign.workers.key import VARIABLE, Message, read_key, sealed, topic_of, unsealed
from scaloft_fi.campaign.workers.late_worker import LateWorker
from scaloft_fi.campaign.workers.plain import batch_from_plain, flyer_from_plain, outcome_to_plain
from scaloft_fi.errors import InputError
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.registry import in_one_line
from scaloft_fi.study import Study

if TYPE_CHECKING:
    from distributed import Worker as DaskWorker

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
