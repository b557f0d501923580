from __future__ import annotations

import os
import subprocess
from pathlib import Path

import pytest

from scaloft_fi.campaign.workers.cluster import MAKE, Cluster
from scaloft_fi.campaign.workers.local import Local
from scaloft_fi.campaign.workers.named import executor_named
from scaloft_fi.errors import InputError


@pytest.fixture
def key_file(tmp_path: Path) -> Path:
    """A key file, made by the command that the refusal names."""
    subprocess.run(MAKE, shell=True, check=True, cwd=tmp_path)
    return tmp_path / "cluster.key"


def test_an_executor_is_local_or_the_address_of_a_scheduler(key_file: Path) -> None:
    key = key_file.read_bytes().strip()
    assert executor_named("local", 3) == Local(3)
    assert executor_named("local", 3, key_file) == Local(3), "the environment may hold a key for other runs"
    assert executor_named("dask://head-node:8786", None, key_file) == Cluster("head-node:8786", key)
    assert executor_named("dask://[::1]:8786/", None, key_file) == Cluster("[::1]:8786", key)
    for name in ("dask", "dask://", "dask://host", "ray://host:1", "tcp://host:8786", "dask://host:port"):
        with pytest.raises(InputError, match=r"must be 'local' or 'dask://HOST:PORT'"):
            executor_named(name, None, key_file)
    with pytest.raises(InputError, match="--jobs=2 is for --executor=local"):
        executor_named("dask://host:1", 2, key_file)
    with pytest.raises(InputError, match="--cluster-security=certs is for --executor=dask"):
        executor_named("local", None, None, Path("certs"))


def test_a_cluster_without_a_key_is_refused_with_the_commands_that_make_one() -> None:
    with pytest.raises(InputError) as caught:
        executor_named("dask://host:1", None)
    assert MAKE in str(caught.value)
    assert "start each worker with SCALOFT_CLUSTER_KEY=cluster.key" in str(caught.value)


def test_the_key_stays_out_of_the_text_of_an_executor(key_file: Path) -> None:
    assert key_file.read_text().strip() not in repr(executor_named("dask://host:1", None, key_file))


def test_a_bad_key_file_is_one_sentence(tmp_path: Path, key_file: Path) -> None:
    short = tmp_path / "short"
    short.touch(mode=0o600)
    huge = tmp_path / "huge"
    huge.touch(mode=0o600)
    os.truncate(huge, 1 << 40)
    for path, reason in (
        (tmp_path / "none", "cannot be read: No such file"),
        (tmp_path, "cannot be read: it is a folder"),
        (short, "has 32 to 4096 bytes"),
        (huge, "cannot be read: it has more than 4,096 bytes|cannot be read: .*4,096|larger"),
        (Path("/dev/zero"), "cannot be read: it is a device"),
    ):
        with pytest.raises(InputError, match=reason):
            executor_named("dask://host:1", None, path)
    key_file.chmod(0o640)
    with pytest.raises(InputError, match="mode=640 lets others read the key; `chmod 600"):
        executor_named("dask://host:1", None, key_file)


def test_bad_certificates_are_one_sentence(tmp_path: Path, key_file: Path) -> None:
    with pytest.raises(InputError, match=r"ca\.pem is missing; needed: ca\.pem, cert\.pem, key\.pem"):
        executor_named("dask://host:1", None, key_file, tmp_path)
    for name in ("ca.pem", "cert.pem", "key.pem"):
        (tmp_path / name).write_text("no certificate")
    with pytest.raises(InputError, match=r"ca\.pem, cert\.pem, key\.pem do not fit each other"):
        executor_named("dask://host:1", None, key_file, tmp_path)
