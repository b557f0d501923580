"""The example of a flight control as a program, and a planner of one's own above it: both fly the reference mission."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
from printed import run
from processes import ROOT

from scaloft_fi.campaign.flights.fly import Flight
from scaloft_fi.campaign.flights.physics import Physics
from scaloft_fi.firmware.lines import throttles_in
from scaloft_fi.firmware.program import FirmwareError
from scaloft_fi.firmware.stack import above_firmware
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.mutants.catalogue import realise
from scaloft_fi.sim.stacks import STACKS, declare_stack
from scaloft_fi.stack.reference.planner import LocalPlan, Planner
from scaloft_fi.stack.reference.stack import ReferenceStack
from scaloft_fi.study import Study

EXAMPLE = ROOT / "examples" / "own_autopilot" / "autopilot.py"


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> Study:
    folder = tmp_path_factory.mktemp("autopilot") / "study"
    program = folder.with_name("autopilot")
    program.write_text(f'#!/bin/sh\nexec "{sys.executable}" "{EXAMPLE}" "$@"\n')
    program.chmod(0o755)
    assert run("new", folder, "--firmware", "lines", "--program", program) == 0
    return Study.open(folder)


def flown(study: Study, mutant: str = "") -> Outcome:
    subject = realise(study.matrix, mutant) if mutant else None
    return Physics()(study, Flight(subject, study.grid.situation("T0O0W0D0H0"), 0))


def test_the_example_flies_the_reference_mission_twice_with_the_same_bits(study: Study):
    first = flown(study)
    assert (first.ending, first.violations, first.stack_error) == ("landed", (), "")
    assert flown(study).digest == first.digest


@pytest.mark.release
def test_faults_at_its_seams_reach_it(study: Study):
    assert flown(study, "REVERSE-gyro").violations
    assert flown(study, "LESS-motors").digest != flown(study).digest


class Idle(Planner):
    """It stays where it is."""

    def plan(self, obstacles, target, pose):
        return LocalPlan(0.0 * pose.position, 1.0, True, 0)


class IdleStack(ReferenceStack):
    planner_kind = Idle


def test_a_planner_of_ones_own_flies_above_a_program(study: Study):
    if "idle" not in STACKS:
        declare_stack(above_firmware("idle", IdleStack))
    path = study.folder / "sim" / "stack.yaml"
    text = path.read_text()
    try:
        path.write_text(text.replace("name: firmware", "name: idle", 1))
        other = Study.open(study.folder)
        assert other.stack.title == "idle, lines as built"
        assert __name__ in other.flying_modules
        assert flown(other).ending == "timed_out"
    finally:
        path.write_text(text)


@pytest.mark.parametrize(
    "line", [b"", b"[]", b"{}", b'{"throttles": [1, 2]}', b'{"throttles": [0, 0, 0, NaN]}', b'{"throttles": "four"}']
)
def test_a_line_without_four_numbers_is_the_programs_fault(line: bytes):
    with pytest.raises(FirmwareError, match="none of throttles"):
        throttles_in(line)


def test_a_line_with_four_numbers_is_read(tmp_path: Path):
    assert throttles_in(b'{"throttles": [0, 0.25, 0.5, 1]}').tolist() == [0.0, 0.25, 0.5, 1.0]
