"""`--executor`, the certificates that a cluster needs, and the study that it is sent."""

from __future__ import annotations

import shutil
import signal
import subprocess
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest

from scaloft_fi.campaign.processes import HANGUP
from scaloft_fi.campaign.workers.cluster import MAKE, Cluster, executor_named, packed, unpacked
from scaloft_fi.campaign.workers.local import ECHO_S, Local, interruptible
from scaloft_fi.errors import InputError


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A certificate, made by the command that the refusal names."""
    folder = tmp_path_factory.mktemp("made")
    subprocess.run(MAKE, shell=True, check=True, cwd=folder, capture_output=True)
    return folder / "cluster"


@pytest.fixture
def certificates(made: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(made, tmp_path / "cluster"))


def test_an_executor_is_local_or_the_address_of_a_scheduler(certificates: Path) -> None:
    assert executor_named("local", 3) == Local(3)
    assert executor_named("dask://head-node:8786", None, certificates) == Cluster("head-node:8786", certificates)
    assert executor_named("dask://[::1]:8786/", None, certificates) == Cluster("[::1]:8786", certificates)
    for name in ("dask", "dask://", "dask://host", "ray://host:1", "tcp://host:8786", "dask://host:port"):
        with pytest.raises(InputError, match=r"must be 'local' or 'dask://HOST:PORT'"):
            executor_named(name, None, certificates)
    with pytest.raises(InputError, match="--jobs=2 is for --executor=local"):
        executor_named("dask://host:1", 2, certificates)
    with pytest.raises(InputError, match="--cluster-security=certs is for --executor=dask"):
        executor_named("local", None, Path("certs"))


@pytest.mark.parametrize("address", ["host:1", "127.0.0.1:8786", "[::1]:8786"])
def test_a_cluster_without_a_certificate_is_refused_with_the_command_that_makes_one(address: str) -> None:
    with pytest.raises(InputError) as caught:
        executor_named(f"dask://{address}", None)
    assert MAKE in str(caught.value)


def test_files_that_do_not_fit_are_told_before_anything_is_flown(certificates: Path) -> None:
    for name in ("cert.pem", "key.pem", "ca.pem"):
        folder = Path(shutil.copytree(certificates, certificates.parent / name))
        (folder / name).touch(mode=0o600)
        (folder / name).write_text("no certificate")
        with pytest.raises(InputError, match=r"cert\.pem, key\.pem do not fit each other: \S"):
            executor_named("dask://host:1", None, folder)
    (certificates / "key.pem").chmod(0o640)
    with pytest.raises(InputError, match="mode=640 lets others read the key; `chmod 600"):
        executor_named("dask://host:1", None, certificates)
    (certificates / "key.pem").unlink()
    with pytest.raises(InputError, match=r"key\.pem is missing; `.*openssl"):
        executor_named("dask://host:1", None, certificates)


def test_what_is_packed_is_unpacked_again(tmp_path: Path) -> None:
    for name in ("sim/world.yaml", "sim/deep/mine.obj", "hazop/a.yaml", "mutants/catalogue.jsonl", "sim/.hidden"):
        path = tmp_path / "study" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(name.encode())
    folder = unpacked(packed(tmp_path / "study"), tmp_path / "there")
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
def test_the_first_signal_asks_to_stop_and_the_handlers_come_back(number: signal.Signals) -> None:
    before = signal.getsignal(number)
    stopped = threading.Event()
    with interruptible(stopped):
        assert not stopped.is_set()
        signal.raise_signal(number)
        assert stopped.is_set()
    assert signal.getsignal(number) == before


def test_what_nohup_ignores_stays_ignored(hangup: signal.Signals) -> None:
    signal.signal(hangup, signal.SIG_IGN)
    stopped = threading.Event()
    with interruptible(stopped):
        signal.raise_signal(hangup)
        assert not stopped.is_set()
    assert signal.getsignal(hangup) == signal.SIG_IGN


def test_the_second_signal_does_what_it_did_before_and_an_echo_of_the_first_does_nothing(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    now_s = 100.0
    monkeypatch.setattr("scaloft_fi.campaign.workers.local.time.monotonic", lambda: now_s)
    stopped = threading.Event()
    with interruptible(stopped):
        signal.raise_signal(signal.SIGINT)
        now_s += ECHO_S / 2
        signal.raise_signal(signal.SIGINT)
        now_s += ECHO_S
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGTERM)
