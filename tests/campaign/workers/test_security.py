"""A cluster whose parts know each other by certificates lets nobody else in."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest

from scaloft_fi.campaign.flight import Batch, Flight
from scaloft_fi.campaign.workers.cluster import Cluster, check_certificates
from scaloft_fi.errors import InputError
from scaloft_fi.study import Study

pytestmark = pytest.mark.skipif(shutil.which("openssl") is None, reason="needs the command openssl")
NEW = ("req", "-newkey", "rsa:2048", "-nodes", "-subj")


def _openssl(folder: Path, *words: str) -> None:
    subprocess.run(["openssl", *words], cwd=folder, check=True, capture_output=True)


@pytest.fixture(scope="module")
def certificates(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An authority, and a certificate that it signed."""
    folder = tmp_path_factory.mktemp("certificates")
    _openssl(folder, *NEW, "/CN=authority", "-x509", "-keyout", "ca.key", "-out", "ca.pem")
    _openssl(folder, *NEW, "/CN=member", "-keyout", "key.pem", "-out", "member.csr")
    _openssl(
        folder,
        *[
            "x509",
            "-req",
            "-in",
            "member.csr",
            "-CA",
            "ca.pem",
            "-CAkey",
            "ca.key",
            "-CAcreateserial",
            "-out",
            "cert.pem",
        ],
    )
    return folder


def test_a_cluster_with_certificates_flies_for_who_has_one_and_answers_nobody_else(
    certificates: Path, dask: Any, flyer: Any, reference: Study, monkeypatch: pytest.MonkeyPatch
) -> None:
    files = [f"--tls-{what}={certificates / name}" for what, name in (("ca-file", "ca.pem"), ("cert", "cert.pem"))]
    files.append(f"--tls-key={certificates / 'key.pem'}")
    address = dask.scheduler(*files, protocol="tls")
    dask.worker(address, "--no-nanny", *files, protocol="tls")
    batch = Batch((Flight(None, reference.grid.situations[0], 0),))
    cluster = Cluster(address, dask.key, certificates)
    with cluster.workers(reference, flyer(), stop=lambda: False, say=print) as workers:
        (outcome,) = workers.map([batch])
    assert outcome.invalid == ""
    monkeypatch.setattr("scaloft_fi.campaign.workers.cluster.CONNECT_S", 1.0)
    stranger = Cluster(address, dask.key)
    with (
        pytest.raises(InputError, match="cannot be reached: no Dask scheduler answers"),
        stranger.workers(reference, flyer(), stop=lambda: False, say=print),
    ):
        pass


def test_files_that_do_not_fit_are_told_before_anything_is_flown(certificates: Path, tmp_path: Path) -> None:
    check_certificates(certificates)
    for name, other in (("cert.pem", "ca.pem"), ("key.pem", "ca.key"), ("ca.pem", "key.pem")):
        folder = tmp_path / name
        shutil.copytree(certificates, folder)
        shutil.copy(certificates / other, folder / name)
        with pytest.raises(InputError, match=r"ca\.pem, cert\.pem, key\.pem do not fit each other: \S"):
            check_certificates(folder)
