"""The reference study in PyBullet: a campaign, its replays, PLACEBO in every situation; stacks that do nothing.

A campaign exports the same bytes whoever flies it: one process, two, unshared, shards, a cluster.  One that is killed
with SIGKILL at random moments and given again is the undisturbed one, byte for byte.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import published_flights
import pytest
from builders import with_range
from processes import ROOT, alive, install, printed, saved, soon
from studies import copied, edit_in

from scaloft_fi.campaign.store.archive import STORE_NAME
from scaloft_fi.mutants.catalogue import source_of
from scaloft_fi.study import Study

pytestmark = pytest.mark.flight

MUTANTS = ("--mutant", "LATE-human", "--mutant", "UNINTENDED-collision@20s")
WORDS = (*MUTANTS, "--situation", "T0O0W0D0H1", "--baseline-seeds", "2", "--quiet")


def _call(*words: str | Path) -> str:
    return printed("-m", "scaloft_fi", *words)


@pytest.fixture(scope="module")
def campaign(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("one") / "c"
    _call("run", *WORDS, "--jobs", "1", "--campaign", folder)
    return folder


def _rows(campaign: Path) -> dict[str, dict[str, Any]]:
    """The flights with the mutants' own seed, without the pool's others."""
    return {row["mutant"]: row for row in json.loads(_call("export", "--campaign", campaign)) if not row["seed"]}


def test_placebo_is_the_baseline_bit_for_bit(campaign: Path):
    rows = _rows(campaign)
    assert rows["PLACEBO"]["digest"] == rows["baseline"]["digest"]
    assert rows["PLACEBO"]["status"] == "not_infected"
    assert rows["LATE-human@3s"]["digest"] != rows["baseline"]["digest"]


def test_the_person_reported_late_is_revealed_by_sr2(campaign: Path):
    rows = _rows(campaign)
    assert rows["baseline"]["status"] == "held"
    assert rows["LATE-human@3s"]["status"] == "revealed"
    assert "SR2" in rows["LATE-human@3s"]["violated"]


def test_a_replay_is_bit_for_bit_the_campaigns_flight_and_draws_it(campaign: Path, tmp_path: Path):
    picture = tmp_path / "map.png"
    done = _call("replay", "LATE-human@3s/T0O0W0D0H1/0", "--campaign", campaign, "--output", picture)
    assert "bit for bit" in done
    assert picture.read_bytes().startswith(b"\x89PNG")


@pytest.mark.release
def test_a_replay_of_a_drawn_number_is_bit_for_bit_the_campaigns_flight(tmp_path: Path):
    study = copied(tmp_path / "study")
    where = ("--study", with_range(study), "--campaign", tmp_path / "c")
    corner = ("--situation", "T0O0W0D1H0C1", "--situation", "T0O0W0D1H0C3", "--choose", "random:2")
    _call("run", "--mutant", "PLACEBO", *corner, "--baseline-seeds", "1", "--jobs", "1", "--quiet", *where)
    rows = [row for row in json.loads(_call("export", *where)) if row["mutant"] == "baseline"]
    slow, fast = (row["situation"] for row in rows)
    assert slow.startswith("T0O0W0D1H0C1=")
    assert fast.startswith("T0O0W0D1H0C3=")
    assert rows[0]["duration_s"] > rows[1]["duration_s"] + 1
    done = _call("replay", f"baseline/{fast}/0", *where)
    assert "bit for bit" in done
    assert f"{float(fast.split('=')[1]):g} m/s" in done


@pytest.mark.release
def test_placebo_is_the_baseline_bit_for_bit_in_every_situation(tmp_path: Path):
    _call("run", "--quiet", "--mutant", "PLACEBO", "--campaign", tmp_path / "c")
    rows = json.loads(_call("export", "--campaign", tmp_path / "c"))
    digests = {(row["mutant"], row["situation"]): row["digest"] for row in rows if row["seed"] == 0}
    keys = {situation for mutant, situation in digests if mutant == "PLACEBO"}
    assert len(keys) == 32
    for key in keys:
        assert digests["PLACEBO", key] == digests["baseline", key]


def test_what_is_expected_not_to_infect_did_not_in_the_published_flights():
    study = Study.open(ROOT)
    sources = {mutant.id: source_of(study.matrix, mutant) for mutant in study.catalogue}
    names = {mutant for mutant, (fault, rung) in sources.items() if fault.expects(rung)}
    statuses = {row["status"] for row in published_flights.rows() if row["mutant"] in names}
    assert statuses
    assert statuses <= {"not_infected", "not_reached"}


THEIR_MUTANTS = ("LATE-human", "UNINTENDED-collision@20s")
SITUATIONS = ("T0O0W0D0H1", "T0O0W0D1H0")
FLIGHTS = len(SITUATIONS) * (2 + len(THEIR_MUTANTS))
THEIR_WORDS = (
    *(word for mutant in THEIR_MUTANTS for word in ("--mutant", mutant)),
    *(word for situation in SITUATIONS for word in ("--situation", situation)),
    *("--baseline-seeds", "2"),
)


def _export(folder: Path) -> str:
    return _call("export", "--campaign", folder)


def _flown(folder: Path, *words: str | Path) -> str:
    """What a campaign flown so exports."""
    _call("run", *THEIR_WORDS, "--quiet", "--campaign", folder, *words)
    return _export(folder)


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


@pytest.mark.release
def test_two_processes(one_process: str, tmp_path: Path):
    assert _flown(tmp_path / "c", "--jobs", "2") == one_process


@pytest.mark.release
def test_flights_that_are_flown_whole(one_process: str, tmp_path: Path):
    assert _flown(tmp_path / "c", "--jobs", "2", "--no-share") == one_process


@pytest.mark.release
def test_shards_that_are_merged(one_process: str, tmp_path: Path):
    for number in (1, 2):
        _flown(tmp_path / str(number), "--shard", f"{number}/2")
    _call("merge", tmp_path / "1", tmp_path / "2", "--campaign", tmp_path / "c")
    assert _export(tmp_path / "c") == one_process


@pytest.mark.release
def test_a_cluster_whose_worker_is_killed_in_flight_and_another_joins(one_process: str, dask: Any, tmp_path: Path):
    address = dask.scheduler()
    killed = dask.worker(address, "--no-nanny")
    cluster = ("--executor", f"dask://{address}", "--cluster-security", dask.certificates)
    words = ("run", *THEIR_WORDS, "--campaign", tmp_path / "c", *cluster)
    call = [sys.executable, "-m", "scaloft_fi", *words]
    run = subprocess.Popen(call, cwd=ROOT, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    assert soon(lambda: saved(tmp_path / "c" / STORE_NAME) >= 2 or run.poll() is not None, 300.0)
    flying = _children(killed.pid)
    killed.send_signal(signal.SIGKILL)
    killed.wait()
    assert 2 <= saved(tmp_path / "c" / STORE_NAME) < FLIGHTS
    assert flying
    assert soon(lambda: not any(map(alive, flying))), "what flew for the worker outlived it"
    dask.worker(address, "--no-nanny")
    _, errors = run.communicate()
    assert run.returncode == 0, errors
    assert _export(tmp_path / "c") == one_process


@pytest.mark.release
def test_a_campaign_killed_and_resumed_exports_the_bytes_of_an_undisturbed_one():
    words = ("--kills", "1", "--mutant", "LATE-human", "--situation", "T0O0W0D0H1", "--baseline-seeds", "2")
    figures = json.loads(printed("benchmarks/kill.py", *words))
    assert figures["kills"] == figures["sound"] == 1
    assert figures["campaigns"] == figures["right"] > 0
    assert figures["outlived"] == 0


PLUGIN = """
from dataclasses import replace

from scaloft_fi.api import declare_stack
from scaloft_fi.stack.reference.declaration import REFERENCE
from scaloft_fi.stack.reference.stack import ReferenceStack


class Raising(ReferenceStack):
    def autopilot(self, now_s, frames):
        raise RuntimeError("no bus")


class Standing(ReferenceStack):
    def __init__(self, task, wire):
        super().__init__(task, wire)
        self.fast_path = None

    def step(self, now_s, imu):
        return None


declare_stack(replace(REFERENCE, name="raising", make=Raising))
declare_stack(replace(REFERENCE, name="standing", make=Standing))
"""


@pytest.fixture
def site(tmp_path: Path) -> Path:
    """A folder of packages with the plugin installed in it."""
    install(tmp_path / "site", "dead-stacks", {"dead": "dead_stacks"})
    (tmp_path / "site" / "dead_stacks.py").write_text(PLUGIN)
    return tmp_path / "site"


BASELINE = "baseline/T0O0W0D0H0/0"
RAISES = f"the stack raises without any fault: {BASELINE} (autopilot at 0.000 s: RuntimeError: no bus)"
STANDS = f"the drone never leaves the ground without any fault: {BASELINE}"


@pytest.mark.release
@pytest.mark.parametrize(
    ("stack", "sentences"),
    [pytest.param("raising", [RAISES, STANDS], marks=pytest.mark.release), ("standing", [STANDS])],
)
def test_a_stack_that_does_nothing_fails_its_gate_flown_and_resumed(
    site: Path, tmp_path: Path, stack: str, sentences: list[str]
):
    study = copied(tmp_path / "study")
    edit_in(study / "sim" / "stack.yaml", "name: reference", f"name: {stack}")
    path = os.pathsep.join([str(site), *filter(None, sys.path)])
    words = ("run", "--mutant", "LATE-human", "--situation", "T0O0W0D0H0", "--jobs", "1", "--quiet")
    for _ in range(2):
        call = [sys.executable, "-m", "scaloft_fi", *words, "--study", str(study)]
        environment = {**os.environ, "PYTHONPATH": path}
        done = subprocess.run(call, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
        assert done.returncode == 4, done.stderr
        assert done.stdout == ""
        assert all(sentence in done.stderr for sentence in sentences)
