"""A campaign in PyBullet exports the same bytes whoever flies it: one process, two, unshared, shards, a cluster.

One that is killed with SIGKILL at random moments and given again is the undisturbed one, byte for byte.
"""

from __future__ import annotations

import json
import signal
import sqlite3
import subprocess
import sys
from collections.abc import Callable
from contextlib import closing, suppress
from pathlib import Path
from typing import Any

import pytest
from processes import alive, soon

from scaloft_fi.campaign.store.archive import STORE_NAME

ROOT = Path(__file__).parents[3]
pytestmark = pytest.mark.flight

MUTANTS = ("LATE-human", "UNINTENDED-collision@20s")
SITUATIONS = ("T0O0W0D0H1", "T0O0W0D1H0")
FLIGHTS = len(SITUATIONS) * (2 + len(MUTANTS))
WORDS = (
    *(word for mutant in MUTANTS for word in ("--mutant", mutant)),
    *(word for situation in SITUATIONS for word in ("--situation", situation)),
    *("--baseline-seeds", "2"),
)
Export = Callable[..., str]


def _start(*words: str | Path) -> subprocess.Popen[str]:
    call = [sys.executable, "-m", "scaloft_fi", *map(str, words)]
    return subprocess.Popen(call, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def _output(process: subprocess.Popen[str]) -> str:
    output, errors = process.communicate()
    assert process.returncode == 0, errors
    return output


def _export(folder: Path) -> str:
    return _output(_start("export", "--campaign", folder))


def _flown(folder: Path, *words: str | Path) -> str:
    """What a campaign flown so exports."""
    _output(_start("run", *WORDS, "--quiet", "--campaign", folder, *words))
    return _export(folder)


def _saved(folder: Path) -> int:
    """How many outcomes are home by now."""
    with (
        suppress(sqlite3.OperationalError),
        closing(sqlite3.connect(f"file:{folder / STORE_NAME}?mode=ro", uri=True)) as db,
    ):
        return int(db.execute("SELECT count(*) FROM outcomes").fetchone()[0])
    return 0


def _children(process: int) -> set[int]:
    """Every process that descends from this one."""
    found: set[int] = set()
    for path in Path(f"/proc/{process}/task").glob("*/children"):
        own = set(map(int, path.read_text().split()))
        found |= own.union(*map(_children, own))
    return found


@pytest.fixture(scope="module")
def one_process(tmp_path_factory: pytest.TempPathFactory) -> str:
    """The export that every other must equal."""
    return _flown(tmp_path_factory.mktemp("one") / "c", "--jobs", "1")


def test_two_processes(one_process: str, tmp_path: Path) -> None:
    assert _flown(tmp_path / "c", "--jobs", "2") == one_process


@pytest.mark.release
def test_flights_that_are_flown_whole(one_process: str, tmp_path: Path) -> None:
    assert _flown(tmp_path / "c", "--jobs", "2", "--no-share") == one_process


@pytest.mark.release
def test_shards_that_are_merged(one_process: str, tmp_path: Path) -> None:
    for number in (1, 2):
        _flown(tmp_path / str(number), "--shard", f"{number}/2")
    _output(_start("merge", tmp_path / "1", tmp_path / "2", "--campaign", tmp_path / "c"))
    assert _export(tmp_path / "c") == one_process


@pytest.mark.release
def test_a_cluster_whose_worker_is_killed_in_flight_and_another_joins(
    one_process: str, dask: Any, tmp_path: Path
) -> None:
    address = dask.scheduler()
    killed = dask.worker(address, "--no-nanny")
    cluster = ("--executor", f"dask://{address}", "--cluster-security", dask.certificates)
    run = _start("run", *WORDS, "--campaign", tmp_path / "c", *cluster)
    assert soon(lambda: _saved(tmp_path / "c") >= 2 or run.poll() is not None, 300.0)
    flying = _children(killed.pid)
    killed.send_signal(signal.SIGKILL)
    killed.wait()
    assert 2 <= _saved(tmp_path / "c") < FLIGHTS
    assert flying
    assert soon(lambda: not any(map(alive, flying))), "what flew for the worker outlived it"
    dask.worker(address, "--no-nanny")
    _output(run)
    assert _export(tmp_path / "c") == one_process


@pytest.mark.release
def test_a_campaign_killed_and_resumed_exports_the_bytes_of_an_undisturbed_one() -> None:
    words = ("--kills", "1", "--mutant", "LATE-human", "--situation", "T0O0W0D0H1", "--baseline-seeds", "2")
    call = [sys.executable, "benchmarks/kill.py", *words]
    done = subprocess.run(call, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    figures = json.loads(done.stdout)
    assert figures["kills"] == figures["sound"] == 1
    assert figures["campaigns"] == figures["right"] > 0
    assert figures["outlived"] == 0
