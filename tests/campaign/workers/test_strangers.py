"""Strangers to a real cluster take no part in a run; who takes its tasks away does not make it wait."""

from __future__ import annotations

import subprocess
import threading
from pathlib import Path
from typing import Any

import distributed
import pytest

from scaloft_fi.campaign.flight import Batch, Flight
from scaloft_fi.campaign.workers.cluster import MAKE, Cluster, security_of
from scaloft_fi.campaign.workers.local import Interrupted
from scaloft_fi.errors import InputError
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.mutants.catalogue import realise
from scaloft_fi.study import Study


@pytest.fixture(scope="module")
def address(dask: Any, flyer: Any) -> str:
    """A scheduler with a worker."""
    address = dask.scheduler()
    dask.worker(address, "--no-nanny")
    with dask.client(address) as client:
        client.wait_for_workers(1, timeout=60)
    return str(address)


@pytest.fixture(scope="module")
def strange(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A certificate that nobody in the cluster knows."""
    folder = tmp_path_factory.mktemp("strange")
    subprocess.run(MAKE, shell=True, check=True, cwd=folder, capture_output=True)
    return folder / "cluster"


def _batches(study: Study) -> list[Batch]:
    subjects = [None, realise(study.matrix, "LATE-human@3s")]
    situations = study.grid.situations[:3]
    return [Batch(tuple(Flight(subject, at, 0) for subject in subjects), shared=True) for at in situations]


@pytest.mark.parametrize("scheme", ["tcp", "tls"])
def test_a_client_without_the_certificate_is_not_let_in(address: str, strange: Path, scheme: str) -> None:
    security = security_of(strange) if scheme == "tls" else None
    with pytest.raises((OSError, TypeError)):
        distributed.Client(f"{scheme}://{address}", set_as_default=False, security=security, timeout=2.0)


def test_a_run_with_another_certificate_is_refused_in_a_sentence(
    address: str, strange: Path, flyer: Any, reference: Study, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("scaloft_fi.campaign.workers.cluster.CONNECT_S", 1.0)
    cluster = Cluster(address, strange)
    with (
        pytest.raises(InputError, match=r"cannot be reached: no Dask scheduler answers .* with the certificates in"),
        cluster.workers(reference, flyer(), stop=lambda: False, say=print),
    ):
        pass


def test_a_worker_without_the_certificate_gets_no_flight(
    address: str, dask: Any, strange: Path, flyer: Any, reference: Study
) -> None:
    worker = dask.worker(address, "--no-nanny", certificates=strange)
    with Cluster(address, dask.certificates).workers(
        reference, flyer(slow_s=0.2), stop=lambda: False, say=print
    ) as workers:
        home = list(workers.map(_batches(reference)))
        assert workers.jobs == 8, "one thread of the one worker, and those that batches are arranged for"
    worker.kill()
    assert len(home) == 6


def test_a_run_whose_tasks_somebody_takes_away_flies_them_again_or_ends(
    address: str, dask: Any, flyer: Any, reference: Study
) -> None:
    home: list[Outcome] = []
    done = threading.Event()

    def attack() -> None:
        with dask.client(address) as client:
            while not done.wait(0.1):
                keys = [key for key in client.processing().values() for key in key if str(key).startswith("scaloft-fi")]
                client.cancel([distributed.Future(key, client) for key in keys], force=True)

    attacker = threading.Thread(target=attack)
    with Cluster(address, dask.certificates).workers(
        reference, flyer(slow_s=0.3), stop=lambda: False, say=print
    ) as workers:
        attacker.start()
        try:
            home.extend(workers.map(_batches(reference)))
            said = "every flight"
        except (InputError, Interrupted) as error:
            said = str(error)
        finally:
            done.set()
            attacker.join()
    whole = {flight.name for batch in _batches(reference) for flight in batch.flights}
    assert {outcome.name for outcome in home} == whole if said == "every flight" else "is saved" in said
