"""The example of a flight control as a program, and a planner of one's own above it: both fly the reference mission."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

import pytest
from printed import run
from processes import ROOT
from studies import edit_in, example

from scaloft_fi.campaign.flights.fly import Flight
from scaloft_fi.campaign.flights.physics import Physics
from scaloft_fi.errors import InputError
from scaloft_fi.firmware.kind import KINDS, POSITION
from scaloft_fi.firmware.lines import Lines, throttles_in
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


def test_a_planner_in_another_process_flies_above_a_program_twice_with_the_same_bits(study: Study, tmp_path: Path):
    example("outside_planner", tmp_path / "study")
    section = (study.folder / "sim" / "stack.yaml").read_text().partition("\nfirmware:")[2]
    stack = tmp_path / "study" / "sim" / "stack.yaml"
    text = stack.read_text().replace("name: outside", "name: outside_firmware", 1)
    stack.write_text(f"{text}\nfirmware:{section}")
    for name in ("stack", "vehicle"):
        edit_in(stack.with_name(f"{name}.yaml"), "spins: [1, 1, -1, -1]", "spins: [-1, -1, 1, 1]")
    above = Study.open(tmp_path / "study")
    names = [seam.name for seam in above.stack.seams]
    assert [names[0], *names[-2:]] == ["pose", "order", "motors"]
    assert (above.stack.deterministic, above.stack.forks) == (True, False)
    first = flown(above)
    assert (first.ending, first.violations, first.stack_error) == ("landed", (), "")
    assert flown(above).digest == first.digest
    edit_in(stack, "  drive: {topic: /cmd_vel", "  motors: {topic: /cmd_vel")
    edit_in(stack, "answer: drive ", "answer: motors ")
    with pytest.raises(InputError, match=r"stack\.seams\.motors: is the name of a seam of the firmware"):
        _ = Study.open(tmp_path / "study").stack


class Mine(Lines):
    """A kind of another author: the flight control of the example, which is not told where it is."""

    seams = tuple(seam for seam in Lines.seams if seam is not POSITION)


def test_a_kind_of_ones_own_is_declared_by_its_class_and_flies(study: Study, tmp_path: Path):
    if "mine" not in KINDS:
        KINDS.declare("mine", Mine)
    shutil.copytree(study.folder, tmp_path / "study")
    edit_in(tmp_path / "study" / "sim" / "stack.yaml", "kind: lines", "kind: mine")
    own = Study.open(tmp_path / "study")
    assert [seam.name for seam in own.stack.seams][-4:] == ["gyro", "accelerometer", "order", "motors"]
    assert own.stack.title == "firmware, mine as built"
    outcome = flown(own)
    assert (outcome.ending, outcome.violations, outcome.stack_error) == ("landed", (), "")


@pytest.mark.parametrize(
    ("sensors", "said"),
    [
        ("barometr", r"sensors\[0\]='barometr' must be a sensor that lines takes: .* did you mean 'barometer'"),
        ("barometer", "names 'barometer', which is no sensor of sim/sensors.yaml"),
    ],
)
def test_a_sensor_that_the_program_or_the_study_does_not_have_is_refused(
    study: Study, tmp_path: Path, sensors: str, said: str
):
    shutil.copytree(study.folder, tmp_path / "study")
    edit_in(tmp_path / "study" / "sim" / "stack.yaml", "sensors: []", f"sensors: [{sensors}]")
    with pytest.raises(InputError, match=said):
        flown(Study.open(tmp_path / "study"))


@pytest.mark.parametrize(
    "line", [b"", b"[]", b"{}", b'{"throttles": [1, 2]}', b'{"throttles": [0, 0, 0, NaN]}', b'{"throttles": "four"}']
)
def test_a_line_without_four_numbers_is_the_programs_fault(line: bytes):
    with pytest.raises(FirmwareError, match="none of throttles"):
        throttles_in(line)


def test_a_line_with_four_numbers_is_read(tmp_path: Path):
    assert throttles_in(b'{"throttles": [0, 0.25, 0.5, 1]}').tolist() == [0.0, 0.25, 0.5, 1.0]
