"""Runs on a real Dask scheduler and real workers, without physics: who flies, who is refused, what is told.

Strangers take no part in a run; who takes its tasks away does not make it wait.  What a cluster
needs before: `--executor`, certificates, and the study that it is sent; and the signals that end a run.
"""

from __future__ import annotations

import gc
import os
import shutil
import signal
import subprocess
import sys
import threading
import time
import warnings
from collections.abc import Callable, Iterator
from importlib import import_module
from pathlib import Path
from typing import Any

import distributed
import pytest
from processes import ROOT, alive, soon
from refused import refusal

from scaloft_fi.campaign import workers as working
from scaloft_fi.campaign.flights.fly import Batch, Flight
from scaloft_fi.campaign.processes import HANGUP
from scaloft_fi.errors import InputError
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.mutants.catalogue import realise
from scaloft_fi.study import Study

LATE, MORE = "LATE-human@3s", "MORE-goal@1m"

pytestmark = pytest.mark.filterwarnings("ignore:unclosed <(ssl|socket):ResourceWarning")
"""A handshake of Dask that its scheduler does not end leaves a socket to the garbage collector, at any later time."""


@pytest.fixture(scope="module")
def address(dask: Any, flyer: Any) -> str:
    """A scheduler with a worker."""
    address = dask.scheduler()
    dask.worker(address, "--no-nanny")
    with dask.client(address) as client:
        client.wait_for_workers(1)  # on a busy machine it may still be on its way
    return str(address)


def _flights(study: Study, *mutants: str) -> list[Flight]:
    subjects = [None, *(realise(study.matrix, name) for name in mutants)]
    return [Flight(subject, situation, 0) for situation in study.grid.situations[:3] for subject in subjects]


def _tasks(flights: list[Flight]) -> list[Batch]:
    keys = dict.fromkeys(flight.situation.key for flight in flights)
    return [Batch(tuple(f for f in flights if f.situation.key == key), shared=True) for key in keys]


def _flown(
    dask: Any,
    address: str,
    study: Study,
    flyer: Any,
    flights: list[Flight],
    stop: Callable[[list[Outcome]], bool] = lambda _home: False,
) -> tuple[list[Outcome], list[str]]:
    """What comes home, and what was said."""
    home: list[Outcome] = []
    said: list[str] = []
    with working.Cluster(address, dask.certificates).workers(
        study, flyer, stop=lambda: stop(home), say=said.append
    ) as workers:
        home.extend(workers.map(_tasks(flights)))
    return home, said


def _names(things: Any) -> list[str]:
    return sorted(thing.name for thing in things)


def test_every_outcome_comes_home_once_and_was_flown_from_the_study_that_was_sent(
    dask: Any, address: str, reference: Study, flyer: Any
):
    flights = _flights(reference, LATE, MORE)
    home, said = _flown(dask, address, reference, flyer(), flights)
    assert _names(home) == _names(flights)
    assert {outcome.invalid for outcome in home} == {""}
    assert said == []
    (folder,) = {outcome.stack_error for outcome in home}
    assert Path(folder) != ROOT
    assert (Path(folder) / "sim" / "world.yaml").read_bytes() == (ROOT / "sim" / "world.yaml").read_bytes()


def test_once_stopped_what_is_queued_is_cancelled(dask: Any, address: str, reference: Study, flyer: Any):
    flights = _flights(reference, LATE, MORE)
    home, _ = _flown(dask, address, reference, flyer(slow_s=0.2), flights, lambda home: len(home) >= 2)
    assert 2 <= len(home) < len(flights)
    again, _ = _flown(dask, address, reference, flyer(), flights)
    assert _names(again) == _names(flights)


def test_what_flies_for_a_run_that_is_killed_ends_with_it(
    dask: Any, address: str, reference: Study, flyer: Any, tmp_path: Path
):
    program = (
        "import cluster_flyer\nfrom pathlib import Path\n"
        "from scaloft_fi.campaign.workers import Cluster\n"
        "from scaloft_fi.campaign.flights.fly import Batch, Flight\n"
        "from scaloft_fi.study import Study\n"
        f"study, flyer = Study.open({str(ROOT)!r}), cluster_flyer.Flyer(slow_s=300.0, mark={str(tmp_path / 'pid')!r})\n"
        f"cluster = Cluster({address!r}, Path({str(dask.certificates)!r}))\n"
        "with cluster.workers(study, flyer, stop=lambda: False, say=print) as workers:\n"
        "    list(workers.map([Batch((Flight(None, study.grid.situations[0], 0),))]))\n"
    )
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
    run = subprocess.Popen([sys.executable, "-c", program], env=environment)
    flying = _written(tmp_path / "pid")
    os.kill(flying, 0)
    run.kill()
    run.wait()
    assert soon(lambda: not alive(flying), 60.0)


def test_a_further_grid_is_flown_by_its_own_situations(dask: Any, address: str, flyer: Any):
    study = Study.open(ROOT, "wide")
    home, said = _flown(dask, address, study, flyer(), _flights(study, LATE))
    assert _names(home) == _names(_flights(study, LATE))
    assert {outcome.situation for outcome in home} <= set(study.grid.by_key)
    assert said == []


def test_another_platform_is_said(
    dask: Any, address: str, reference: Study, flyer: Any, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr("scaloft_fi.campaign.workers.fingerprint", lambda: {"machine": "PDP-11"})
    home, said = _flown(dask, address, reference, flyer(), _flights(reference))
    assert len(home) == 3
    assert len(said) == 1
    assert "is another platform, digests may differ" in said[0]
    assert "PDP-11" in said[0]


@pytest.mark.release
def test_a_worker_with_other_code_flies_nothing_while_others_do(
    dask: Any, reference: Study, flyer: Any, tmp_path: Path
):
    shutil.copytree(ROOT / "scaloft_fi", tmp_path / "scaloft_fi", ignore=shutil.ignore_patterns("__pycache__", ".*"))
    with (tmp_path / "scaloft_fi" / "sim" / "flight.py").open("a") as file:
        file.write("\nANSWER = 42\n")
    address = dask.scheduler()
    dask.worker(address, "--no-nanny", PYTHONPATH=os.pathsep.join([str(tmp_path), *sys.path]))
    with pytest.raises(InputError, match="has other code or data and flies nothing: code"):
        _flown(dask, address, reference, flyer(), _flights(reference))
    dask.worker(address, "--no-nanny")
    _wait_for_workers(dask, address, 2)
    flights = _flights(reference, LATE, MORE)
    home, said = _flown(dask, address, reference, flyer(), flights)
    assert _names(home) == _names(flights)
    assert ["has other code" in line for line in said] == [True]


@pytest.mark.release
def test_a_flight_over_which_every_worker_dies_is_invalid_with_the_reason(dask: Any, reference: Study, flyer: Any):
    address = dask.scheduler(DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES="0")
    dask.worker(address, "--nanny")
    flights = _flights(reference, LATE, MORE)
    deadly = next(flight.name for flight in flights if flight.subject.id == MORE)
    home, _ = _flown(dask, address, reference, flyer(deadly=deadly, slow_s=0.1), flights)
    assert _names(home) == _names(flights)
    reasons = {outcome.name: outcome.invalid for outcome in home if outcome.invalid}
    assert reasons == {deadly: "its worker process died with its Dask worker every time"}


@pytest.mark.release
def test_a_run_waits_for_workers_and_takes_those_that_join(dask: Any, reference: Study, flyer: Any):
    address = dask.scheduler()
    said: list[str] = []
    flights = _flights(reference)

    def say(line: str) -> None:
        said.append(line)
        dask.worker(address, "--no-nanny")

    with working.Cluster(address, dask.certificates).workers(
        reference, flyer(), stop=lambda: False, say=say
    ) as workers:
        assert _names(workers.map(_tasks(flights))) == _names(flights)
    assert len(said) == 1
    assert said[0].startswith("waiting for workers")


@pytest.mark.release
@pytest.mark.parametrize("until_the_client_gives_up_s", [0.0, 5.0])
def test_a_scheduler_that_ends_interrupts_the_run(
    dask: Any,
    reference: Study,
    flyer: Any,
    monkeypatch: pytest.MonkeyPatch,
    caplog: pytest.LogCaptureFixture,
    until_the_client_gives_up_s: float,
):
    monkeypatch.setattr("scaloft_fi.campaign.workers.CONNECT_S", 2.0)
    address = dask.scheduler()
    scheduler = dask.last
    dask.worker(address, "--no-nanny")

    def kill(home: list[Outcome]) -> bool:
        if home and scheduler.poll() is None:
            scheduler.send_signal(signal.SIGKILL)
            scheduler.wait()
            time.sleep(until_the_client_gives_up_s)
        return False

    with pytest.raises(working.Interrupted, match="the Dask scheduler is gone; what was flown is saved"):
        _flown(dask, address, reference, flyer(slow_s=0.2), _flights(reference, LATE, MORE), kill)
    assert [record.getMessage() for record in caplog.records if record.name.startswith("distributed")] == []


def test_a_scheduler_that_ends_and_starts_again_at_its_address_interrupts_a_run_that_waits(
    dask: Any, reference: Study, flyer: Any
):
    address = dask.scheduler()
    scheduler, begin_s = dask.last, time.monotonic()

    def start_again(_line: str) -> None:
        scheduler.send_signal(signal.SIGKILL)
        scheduler.wait()
        dask.scheduler("--port", address.rpartition(":")[2])
        dask.worker(address, "--no-nanny")

    def late() -> bool:
        return time.monotonic() - begin_s > 60.0

    with (
        pytest.raises(working.Interrupted, match="the Dask scheduler is gone; what was flown is saved"),
        working.Cluster(address, dask.certificates).workers(reference, flyer(), stop=late, say=start_again) as workers,
    ):
        list(workers.map(_tasks(_flights(reference))))


def test_a_scheduler_that_does_not_answer_is_one_sentence(
    dask: Any, reference: Study, flyer: Any, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr("scaloft_fi.campaign.workers.CONNECT_S", 0.3)
    with pytest.raises(InputError, match=r"^--executor=dask://127.0.0.1:9 cannot be reached: no Dask scheduler"):
        _flown(dask, "127.0.0.1:9", reference, flyer(), _flights(reference))


def test_without_distributed_it_is_said_how_to_install_it(
    dask: Any, reference: Study, flyer: Any, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(InputError, match=r"pip install 'scaloft-fi\[cluster\]'"):
        _flown(dask, "127.0.0.1:9", reference, flyer(), _flights(reference))


def _made_in(folder: Path) -> Path:
    subprocess.run(working.MAKE, shell=True, check=True, cwd=folder, capture_output=True)
    return folder / "cluster"


@pytest.fixture(scope="module")
def strange(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A certificate that nobody in the cluster knows."""
    return _made_in(tmp_path_factory.mktemp("strange"))


@pytest.mark.parametrize("scheme", ["tcp", "tls"])
def test_a_client_without_the_certificate_is_not_let_in(address: str, strange: Path, scheme: str):
    security = working.security_of(strange) if scheme == "tls" else None
    with pytest.raises((OSError, TypeError)):
        distributed.Client(f"{scheme}://{address}", set_as_default=False, security=security, timeout=2.0)


def test_a_run_with_another_certificate_is_refused_in_a_sentence(
    address: str, strange: Path, flyer: Any, reference: Study, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr("scaloft_fi.campaign.workers.CONNECT_S", 1.0)
    cluster = working.Cluster(address, strange)
    with (
        pytest.raises(InputError, match=r"cannot be reached: no Dask scheduler answers .* with the certificates in"),
        cluster.workers(reference, flyer(), stop=lambda: False, say=print),
    ):
        pass


def test_a_worker_without_the_certificate_gets_no_flight(
    address: str, dask: Any, strange: Path, flyer: Any, reference: Study
):
    worker = dask.worker(address, "--no-nanny", certificates=strange)
    flights = _flights(reference, LATE)
    with working.Cluster(address, dask.certificates).workers(
        reference, flyer(slow_s=0.2), stop=lambda: False, say=print
    ) as workers:
        assert _names(workers.map(_tasks(flights))) == _names(flights)
        assert workers.jobs == 8, "one thread of the one worker, and those that batches are arranged for"
    worker.kill()


def test_a_run_whose_tasks_somebody_takes_away_flies_them_again_or_ends(
    address: str, dask: Any, flyer: Any, reference: Study
):
    done, flights = threading.Event(), _flights(reference, LATE)

    def attack() -> None:
        with dask.client(address) as client:
            while not done.wait(0.1):
                keys = [key for key in client.processing().values() for key in key if str(key).startswith("scaloft-fi")]
                client.cancel([distributed.Future(key, client) for key in keys], force=True)

    attacker = threading.Thread(target=attack)
    attacker.start()
    said = ""
    try:
        assert _names(_flown(dask, address, reference, flyer(slow_s=0.3), flights)[0]) == _names(flights)
    except (InputError, working.Interrupted) as error:
        said = str(error)
    finally:
        done.set()
        attacker.join()
    assert not said or "is saved" in said


def _written(path: Path) -> int:
    assert soon(lambda: path.exists() and path.read_text().endswith("\n"), 60.0)
    return int(path.read_text())


def _wait_for_workers(dask: Any, address: str, count: int) -> None:
    with dask.client(address) as client:
        client.wait_for_workers(count, timeout=60)


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A certificate, made by the command that the refusal names."""
    return _made_in(tmp_path_factory.mktemp("made"))


@pytest.fixture
def certificates(made: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(made, tmp_path / "cluster"))


def test_an_executor_is_local_or_the_address_of_a_scheduler(certificates: Path):
    assert working.executor_named("local", 3) == working.Local(3)
    assert working.executor_named("dask://head-node:8786", None, certificates) == working.Cluster(
        "head-node:8786", certificates
    )
    assert working.executor_named("dask://[::1]:8786/", None, certificates) == working.Cluster(
        "[::1]:8786", certificates
    )
    for name in ("dask", "dask://", "dask://host", "ray://host:1", "tcp://host:8786", "dask://host:port"):
        with pytest.raises(InputError, match=r"must be 'local' or 'dask://HOST:PORT'"):
            working.executor_named(name, None, certificates)
    with pytest.raises(InputError, match="--jobs=2 is for --executor=local"):
        working.executor_named("dask://host:1", 2, certificates)
    with pytest.raises(InputError, match="--cluster-security=certs is for --executor=dask"):
        working.executor_named("local", None, Path("certs"))


@pytest.mark.parametrize("address", ["host:1", "127.0.0.1:8786", "[::1]:8786"])
def test_a_cluster_without_a_certificate_is_refused_with_the_command_that_makes_one(address: str):
    assert working.MAKE in refusal(working.executor_named, f"dask://{address}", None)


def test_files_that_do_not_fit_are_told_before_anything_is_flown(certificates: Path):
    for name in ("cert.pem", "key.pem", "ca.pem"):
        folder = Path(shutil.copytree(certificates, certificates.parent / name))
        (folder / name).touch(mode=0o600)
        (folder / name).write_text("no certificate")
        with pytest.raises(InputError, match=r"cert\.pem, key\.pem do not fit each other: \S"):
            working.executor_named("dask://host:1", None, folder)
    (certificates / "key.pem").chmod(0o640)
    with pytest.raises(InputError, match="mode=640 lets others read the key; `chmod 600"):
        working.executor_named("dask://host:1", None, certificates)
    (certificates / "key.pem").unlink()
    with pytest.raises(InputError, match=r"key\.pem is missing; `.*openssl"):
        working.executor_named("dask://host:1", None, certificates)


def test_what_is_packed_is_unpacked_again(tmp_path: Path):
    for name in ("sim/world.yaml", "sim/deep/mine.obj", "hazop/a.yaml", "mutants/catalogue.jsonl", "sim/.hidden"):
        path = tmp_path / "study" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(name.encode())
    folder = working.unpacked(working.packed(tmp_path / "study"), tmp_path / "there")
    found = {path.relative_to(folder).as_posix(): path.read_text() for path in folder.rglob("*") if path.is_file()}
    names = ("sim/world.yaml", "sim/deep/mine.obj", "hazop/a.yaml", "mutants/catalogue.jsonl")
    assert found == {name: name for name in names}
    assert sorted(path.name for path in tmp_path.iterdir()) == ["study", "there"]


@pytest.fixture
def hangup() -> Iterator[signal.Signals]:
    """The signal of a terminal that closes; its handler is put back."""
    if not HANGUP:
        pytest.skip("this system has no SIGHUP")
    before = signal.getsignal(HANGUP[0])
    yield HANGUP[0]
    signal.signal(HANGUP[0], before)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, *HANGUP])
def test_the_first_signal_asks_to_stop_and_the_handlers_come_back(number: signal.Signals):
    before = signal.getsignal(number)
    stopped = threading.Event()
    with working.interruptible(stopped):
        assert not stopped.is_set()
        signal.raise_signal(number)
        assert stopped.is_set()
    assert signal.getsignal(number) == before


@pytest.mark.release
def test_what_nohup_ignores_stays_ignored(hangup: signal.Signals):
    signal.signal(hangup, signal.SIG_IGN)
    stopped = threading.Event()
    with working.interruptible(stopped):
        signal.raise_signal(hangup)
        assert not stopped.is_set()
    assert signal.getsignal(hangup) == signal.SIG_IGN


@pytest.mark.release
def test_the_second_signal_does_what_it_did_before_and_an_echo_of_the_first_does_nothing(
    monkeypatch: pytest.MonkeyPatch,
):
    now_s = 100.0
    monkeypatch.setattr("scaloft_fi.campaign.workers.time.monotonic", lambda: now_s)
    stopped = threading.Event()
    with working.interruptible(stopped):
        signal.raise_signal(signal.SIGINT)
        now_s += working.ECHO_S / 2
        signal.raise_signal(signal.SIGINT)
        now_s += working.ECHO_S
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGTERM)


FLYER = """
import os, signal, time
from dataclasses import dataclass
from scaloft_fi.judge.outcome import Outcome

FLOWN = {"ending": "landed", "digest": "0" * 64, "perceived_digest": "0" * 64}

@dataclass(frozen=True)
class Flyer:
    deadly: str = ""  # over this flight the Dask worker dies
    slow_s: float = 0.0
    after: str = ""  # flies when this file exists
    mark: str = ""  # a file for the number of the process that flies

    def prepare(self, study, say):
        pass

    def __call__(self, study, flight):
        if self.mark:
            with open(self.mark, "w") as file:
                file.write(f"{os.getpid()}\\n")
        time.sleep(self.slow_s)
        while self.after and not os.path.exists(self.after):
            time.sleep(0.02)
        if flight.name == self.deadly:
            os.kill(os.getppid(), signal.SIGKILL)
            time.sleep(60.0)
        return Outcome(flight.subject, flight.situation.key, flight.seed, **FLOWN, stack_error=str(study.folder))

    def share(self, study, batch, home):
        for flight in batch.flights:
            home(self(study, flight))
"""


@pytest.fixture(scope="module", autouse=True)
def _sockets() -> Iterator[None]:
    """Sockets that Dask leaves are collected here, not in a test of another file."""
    yield
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ResourceWarning)
        gc.collect()


@pytest.fixture(scope="module")
def flyer(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    """The class of a flyer that workers can import."""
    folder = tmp_path_factory.mktemp("flyer")
    (folder / "cluster_flyer.py").write_text(FLYER)
    sys.path.insert(0, str(folder))
    yield import_module("cluster_flyer").Flyer
    sys.path.remove(str(folder))


@pytest.fixture(scope="module")
def reference() -> Study:
    return Study.open(ROOT)
