"""What the reference study must show: the baselines as calibrated, PLACEBO, and faults that infect.

Flights but PLACEBO's are the published ones, of which another test flies some again, every baseline with seed 0 among
them.
"""

from __future__ import annotations

import json
import subprocess
import sys
from collections import Counter
from pathlib import Path

import published_flights
import pytest

from scaloft_fi.mutants.catalogue import defaults, expected_of
from scaloft_fi.study import Study

ROOT = Path(__file__).parents[3]
pytestmark = pytest.mark.flight


def rows_of(folder, *words):
    """Run a campaign and export it."""
    for verb in (("run", "--quiet", *words), ("export",)):
        call = [sys.executable, "-m", "scaloft_fi", *verb, "--campaign", str(folder)]
        done = subprocess.run(call, cwd=ROOT, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


@pytest.fixture(scope="module")
def published():
    return [row for row in published_flights.rows() if row["seed"] == 0]


@pytest.fixture(scope="module")
def default_rows(published):
    return [row for row in published if row["situation"] == "T1O1W0D0H0"]


def baselines(rows, axis_values):
    return [
        row for row in rows if row["mutant"] == "baseline" and all(value in row["situation"] for value in axis_values)
    ]


@pytest.mark.release
def test_placebo_is_the_baseline_bit_for_bit_in_every_situation(tmp_path):
    rows = rows_of(tmp_path / "c", "--mutant", "PLACEBO")
    digests = {(row["mutant"], row["situation"]): row["digest"] for row in rows if row["seed"] == 0}
    keys = {situation for mutant, situation in digests if mutant == "PLACEBO"}
    assert len(keys) == 32
    for key in keys:
        assert digests["PLACEBO", key] == digests["baseline", key]


def test_in_light_the_baselines_hold_sr1_and_sr2_and_finish(published):
    light = baselines(published, ["D0"])
    assert len(light) == 16
    assert sum(row["violated"] != [] for row in light) <= 1, "all but a rare flight"


def test_in_the_dark_turning_missions_strike_the_bar_and_straight_ones_do_not(published):
    turning, straight = baselines(published, ["D1", "T1"]), baselines(published, ["D1", "T0"])
    assert sum("SR1" in row["violated"] for row in turning) >= 6
    first = [row["struck"] for row in turning if row["violated"] == ["SR1"]]  # of others the row names SR2's moment
    assert first
    assert set(first) == {"bar"}
    assert all("SR1" not in row["violated"] for row in straight)


def test_in_the_dark_a_person_makes_every_baseline_red_by_sr2(published):
    assert all("SR2" in row["violated"] for row in baselines(published, ["D1", "H1"]))


def test_most_default_mutants_infect_and_fly_differently(default_rows):
    study = Study.open(ROOT)
    names = {mutant.id for mutant in defaults(study.matrix)}
    flown = {row["mutant"]: row for row in default_rows if row["mutant"] in names}
    assert set(flown) == names
    statuses = Counter(row["status"] for row in flown.values())
    infected = len(flown) - statuses["not_reached"] - statuses["not_infected"] - statuses["invalid"]
    assert statuses["invalid"] == 0
    assert infected > 0.8 * len(flown)
    assert len({row["digest"] for row in flown.values()}) > 0.6 * len(flown)


def test_what_is_expected_not_to_infect_does_not(default_rows):
    study = Study.open(ROOT)
    by_id = {mutant.id: mutant for mutant in study.catalogue}
    expected = [
        row for row in default_rows if row["mutant"] in by_id and expected_of(study.matrix, by_id[row["mutant"]])
    ]
    assert expected
    assert {row["status"] for row in expected} <= {"not_infected", "not_reached"}


def test_every_control_is_seen_or_waits_for_a_situation_that_shows_it(default_rows):
    """One situation is not the grid: what shows nothing here has to elsewhere; a full run holds that gate."""
    study = Study.open(ROOT)
    controls = [row for row in default_rows if row["mutant"].split("@")[0] in study.roster.controls]
    assert len(controls) == 11
    assert sum(row["status"] == "revealed" or "OP1" in row["violated"] for row in controls) >= 8
