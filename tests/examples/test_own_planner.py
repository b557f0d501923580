"""A planner of one's own in the reference stack, as its page tells: written by `new --planner`, installed, flown."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest
from printed import run
from processes import call, install_project, printed
from shown_commands import shown_commands

from scaloft_fi.sim.grid import FOUND_FILE

MOST_LINES = 40
NEW, _, _, RUN = (shown for shown in shown_commands() if shown.page == "own_planner.md")
WATCH = """
from scaloft_fi.api import Study
from scaloft_fi.sim.flight import fly
from scaloft_fi.stack.declaration import PlainWire

study = Study.open(".")
log = fly(study.sim, study.grid.situation("T0O1W0D0H0"), 0, PlainWire(), study.stack)
print("flown", log.ending.value, round(max(log.signals["y_m"]), 1), repr(log.stack_error))
"""


@pytest.fixture(scope="module")
def package(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("work") / "my_planner"
    assert run("new", folder, "--planner") == 0
    return folder


@pytest.fixture(scope="module")
def site(package: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("site")
    install_project(folder, package)
    return folder


def test_the_planner_and_its_stack_are_at_most_forty_lines(package: Path):
    assert len((package / "my_planner" / "stack.py").read_text().splitlines()) <= MOST_LINES


def test_its_study_names_its_stack_and_has_no_find_of_the_reference_drone(package: Path):
    assert "name: my_planner " in (package / "study" / "sim" / "stack.yaml").read_text()
    assert not (package / "study" / "sim" / FOUND_FILE).exists()


def test_the_catalogue_of_the_reference_study_serves_it(site: Path, package: Path):
    printed("-m", "scaloft_fi", "mutants", "--check", "--study", "study", site=site, cwd=package)


@pytest.mark.release
@pytest.mark.flight
def test_it_stops_before_the_obstacle_on_the_straight_line(site: Path, package: Path):
    done = call(site, "-c", WATCH, cwd=package / "study")
    flown = re.search(r"flown (\w+) ([\d.]+) ''", done.stdout)
    assert flown, done.stdout + done.stderr
    assert flown[1] == "timed_out"
    assert 3.0 < float(flown[2]) < 4.5


def test_the_page_shows_what_new_prints(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    monkeypatch.chdir(tmp_path)
    assert run(*shlex.split(NEW.command)[1:]) == 0
    assert capsys.readouterr().out == NEW.output


@pytest.mark.release
@pytest.mark.flight
def test_its_tests_pass_and_its_first_run_prints_what_the_page_shows(site: Path, package: Path):
    printed("-m", "pytest", "-q", "-p", "no:cacheprovider", site=site, cwd=package)
    screen = printed("-m", "scaloft_fi", *shlex.split(RUN.command)[1:], site=site, cwd=package / "study")
    assert screen == RUN.output
    assert re.search(r"LATE-human@3s +detected .*SR2", screen)
