"""The reference study in PyBullet: a campaign, its replays, PLACEBO in every situation."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import published_flights
import pytest
from ranges import with_range

from scaloft_fi.mutants.catalogue import source_of
from scaloft_fi.study import Study

ROOT = Path(__file__).parents[3]
pytestmark = pytest.mark.flight

MUTANTS = ("--mutant", "LATE-human", "--mutant", "UNINTENDED-collision@20s")
WORDS = (*MUTANTS, "--situation", "T0O0W0D0H1", "--baseline-seeds", "2", "--quiet")


def _call(*words: str | Path) -> subprocess.CompletedProcess[str]:
    call = [sys.executable, "-m", "scaloft_fi", *map(str, words)]
    done = subprocess.run(call, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done


@pytest.fixture(scope="module")
def campaign(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("one") / "c"
    _call("run", *WORDS, "--jobs", "1", "--campaign", folder)
    return folder


def _rows(campaign: Path) -> dict[str, dict[str, Any]]:
    """The flights with the mutants' own seed, without the pool's others."""
    return {row["mutant"]: row for row in json.loads(_call("export", "--campaign", campaign).stdout) if not row["seed"]}


def test_placebo_is_the_baseline_bit_for_bit(campaign: Path) -> None:
    rows = _rows(campaign)
    assert rows["PLACEBO"]["digest"] == rows["baseline"]["digest"]
    assert rows["PLACEBO"]["status"] == "not_infected"
    assert rows["LATE-human@3s"]["digest"] != rows["baseline"]["digest"]


def test_the_person_reported_late_is_revealed_by_sr2(campaign: Path) -> None:
    rows = _rows(campaign)
    assert rows["baseline"]["status"] == "held"
    assert rows["LATE-human@3s"]["status"] == "revealed"
    assert "SR2" in rows["LATE-human@3s"]["violated"]


def test_a_replay_is_bit_for_bit_the_campaigns_flight_and_draws_it(campaign: Path, tmp_path: Path) -> None:
    picture = tmp_path / "map.png"
    done = _call("replay", "LATE-human@3s/T0O0W0D0H1/0", "--campaign", campaign, "--output", picture)
    assert "bit for bit" in done.stdout
    assert picture.read_bytes().startswith(b"\x89PNG")


def test_a_replay_of_a_drawn_number_is_bit_for_bit_the_campaigns_flight(tmp_path: Path) -> None:
    study = tmp_path / "study"
    for name in ("hazop", "mutants", "sim"):
        shutil.copytree(ROOT / name, study / name)
    where = ("--study", with_range(study), "--campaign", tmp_path / "c")
    corner = ("--situation", "T0O0W0D1H0C1", "--situation", "T0O0W0D1H0C3", "--choose", "random:2")
    _call("run", "--mutant", "PLACEBO", *corner, "--baseline-seeds", "1", "--jobs", "1", "--quiet", *where)
    rows = [row for row in json.loads(_call("export", *where).stdout) if row["mutant"] == "baseline"]
    slow, fast = (row["situation"] for row in rows)
    assert slow.startswith("T0O0W0D1H0C1=")
    assert fast.startswith("T0O0W0D1H0C3=")
    assert rows[0]["duration_s"] > rows[1]["duration_s"] + 1
    done = _call("replay", f"baseline/{fast}/0", *where)
    assert "bit for bit" in done.stdout
    assert f"{float(fast.split('=')[1]):g} m/s" in done.stdout


@pytest.mark.release
def test_placebo_is_the_baseline_bit_for_bit_in_every_situation(tmp_path: Path) -> None:
    _call("run", "--quiet", "--mutant", "PLACEBO", "--campaign", tmp_path / "c")
    rows = json.loads(_call("export", "--campaign", tmp_path / "c").stdout)
    digests = {(row["mutant"], row["situation"]): row["digest"] for row in rows if row["seed"] == 0}
    keys = {situation for mutant, situation in digests if mutant == "PLACEBO"}
    assert len(keys) == 32
    for key in keys:
        assert digests["PLACEBO", key] == digests["baseline", key]


def test_what_is_expected_not_to_infect_did_not_in_the_published_flights() -> None:
    study = Study.open(ROOT)
    sources = {mutant.id: source_of(study.matrix, mutant) for mutant in study.catalogue}
    names = {mutant for mutant, (fault, rung) in sources.items() if fault.expects(rung)}
    statuses = {row["status"] for row in published_flights.rows() if row["mutant"] in names}
    assert statuses
    assert statuses <= {"not_infected", "not_reached"}
