"""The example of another planner in the reference stack: installed, and flown in the reference study."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from processes import ROOT, call, install_project, printed

EXAMPLE = ROOT / "examples" / "own_planner"
WATCH = """
from scaloft_fi.api import Study
from scaloft_fi.sim.flight import fly
from scaloft_fi.stack.declaration import PlainWire

study = Study.open(".")
log = fly(study.sim, study.grid.situation("T0O1W0D0H0"), 0, PlainWire(), study.stack)
print("flown", log.ending.value, round(max(log.signals["y_m"]), 1), repr(log.stack_error))
"""


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("site")
    install_project(folder, EXAMPLE)
    return folder


@pytest.fixture(scope="module")
def study(site: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("planner") / "study"
    printed(EXAMPLE / "copy_study.py", folder, site=site)
    return folder


@pytest.mark.release
def test_the_catalogue_of_the_reference_study_serves_it(site: Path, study: Path):
    printed("-m", "scaloft_fi", "mutants", "--check", "--study", study, site=site, cwd=study)


@pytest.mark.release
@pytest.mark.flight
def test_it_stops_before_the_obstacle_on_the_straight_line(site: Path, study: Path):
    done = call(site, "-c", WATCH, cwd=study)
    flown = re.search(r"flown (\w+) ([\d.]+) ''", done.stdout)
    assert flown, done.stdout + done.stderr
    assert flown[1] == "timed_out"
    assert 3.0 < float(flown[2]) < 4.5
