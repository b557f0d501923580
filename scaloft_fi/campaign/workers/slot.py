"""The code in a Dask worker: each of its threads has a process that flies, and sends the outcomes as events."""

from __future__ import annotations

import pickle
import threading
import time
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path

from scaloft_fi.campaign.flights.worker import Flyer, Worker, left_of, lost
from scaloft_fi.campaign.plan.batch import Batch
from scaloft_fi.campaign.processes.pool import Pool
from scaloft_fi.campaign.processes.start import started_clean
from scaloft_fi.campaign.store.fingerprint import differences, fingerprint
from scaloft_fi.campaign.workers.bundle import MOST_BYTES, digest_of, unpacked
from scaloft_fi.errors import ScaloftError
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.reading import UnreadableError, read_bytes
from scaloft_fi.study import Study

TOPIC = "scaloft-fi"
"""The topic of the events; one for all runs, because the scheduler keeps the last thousand events of each."""
IDLE_S = 60.0
"""A process without a task for this time ends, because its run has ended or died [s, wall]."""
ARRIVAL_S = 30.0
"""Greatest time that a new worker waits for the study [s, wall]."""

_idle: dict[tuple[Path, bytes], list[_Slot]] = defaultdict(list)
_lock = threading.Lock()


def fly_batch(
    run: str, number: int, bundle: str, inputs: Mapping[str, str], platform: dict[str, str], work: bytes
) -> None:
    """Fly one batch; each outcome is sent as an event `(run, number, worker, kind, content)` when it is known.

    Args:
        run, number: id of the run, number of the batch.
        bundle: hash of the study; every worker has received its file.
        inputs: hashes of study and code in the run; a worker with other hashes flies nothing and sends `refused`.
        platform: fingerprint of the run's platform; a worker on another platform sends its differences as `platform`.
        work: flyer and batch, pickled, because another version of the package may be unable to read them.

    Raises:
        Exception: the study cannot be flown.
    """
    from distributed import get_worker

    worker = get_worker()
    key = worker.get_current_task()

    def send(kind: str, content: str | bytes) -> None:
        worker.log_event(TOPIC, (run, number, worker.address, kind, content))

    folder = _study(Path(worker.local_directory), bundle)
    ours = _inputs(folder)
    other = [part for part, digest in inputs.items() if ours.get(part) != digest]
    if other:
        send("refused", ", ".join(f"{part} {ours.get(part, 'none')[:12]}, not {inputs[part][:12]}" for part in other))
        return
    changed = differences(platform, fingerprint())
    if changed:
        send("platform", ", ".join(changed))

    def stop() -> bool:  # the run no longer wants the batch
        state = worker.state.tasks.get(key)
        return state is None or state.state == "cancelled"

    send("begun", "")
    flyer, batch = pickle.loads(work)
    with _slot(folder, flyer, stop) as pool:
        for outcome in pool.map([batch]):
            send("outcome", pickle.dumps(outcome))


@dataclass
class LateWorker:
    """The work of a new process: it opens the study when it gets its first batch."""

    study: Path
    flyer: Flyer
    _worker: Worker | None = None

    def __call__(self, batch: Batch, report: Callable[[Outcome], None]) -> None:
        """Fly one batch."""
        if self._worker is None:
            study = Study.open(self.study)
            self.flyer.prepare(study, lambda _text: None)
            self._worker = Worker(study, self.flyer)
        self._worker(batch, report)


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
def _slot(study: Path, flyer: Flyer, stop: Callable[[], bool]) -> Iterator[Pool[Batch, Outcome]]:
    """The pool of an idle slot, else of a new slot; the slot is kept for the next batch, or closed after an error."""
    slots = _idle[study, pickle.dumps(flyer)]
    with _lock:
        slot = slots.pop() if slots else _Slot(LateWorker(study, flyer))
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


@lru_cache
def _study(scratch: Path, bundle: str) -> Path:
    """The folder of the study that was sent to `scratch`.

    Raises:
        ScaloftError: the study did not arrive in time.
    """
    due_s = time.monotonic() + ARRIVAL_S
    while time.monotonic() < due_s:
        try:
            content = read_bytes(scratch / bundle, MOST_BYTES)
        except UnreadableError:
            content = b""
        if digest_of(content) == bundle:
            return unpacked(content, scratch / f"study-{bundle}")
        time.sleep(0.05)
    raise ScaloftError(f"the study did not reach the worker in {scratch}")


@lru_cache
def _inputs(folder: Path) -> Mapping[str, str]:
    return Study.open(folder).inputs
