"""Stacks in other processes: settings, and flights of sound ones and of ones that die, hang and talk nonsense."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

import pytest
from options import cases
from processes import ROOT, marked
from studies import edit_in, example

import scaloft_fi.outside.stack  # noqa: F401 - it declares an operator
from scaloft_fi.campaign.flights.fly import Batch, Flight, Worker, fly_log, judged
from scaloft_fi.campaign.flights.physics import Physics
from scaloft_fi.errors import InputError
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.mutants.catalogue import realise
from scaloft_fi.mutants.mutant import PLACEBO
from scaloft_fi.mutants.operators import OPERATORS
from scaloft_fi.outside.border import BORDERS, BorderError
from scaloft_fi.outside.exchange import Exchange, OutsideError
from scaloft_fi.study import Study


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return example("outside_planner", tmp_path / "study")


def test_seams_and_beliefs_follow_from_the_settings(folder: Path):
    stack = Study.open(folder).stack
    assert [seam.name for seam in stack.seams] == [
        "pose", "camera", "depth", "person", "drive", "land", "imu", "fix", "thrust",
    ]  # fmt: skip
    assert stack.by_name["person"].edge == "our drone -> /persons"
    assert stack.by_name["drive"].edge == "/cmd_vel -> our drone"
    assert stack.by_name["drive"].unit("velocity") == "m/s"
    assert stack.canaries == ("drive", "pose")
    assert (stack.deterministic, stack.forks) == (True, False)
    assert "est_x_m" in stack.belief_names


@cases("old", "new", "sentence")
def test_settings_that_do_not_fit_are_refused_with_their_place(folder: Path, old: str, new: str, sentence: str):
    path = folder / "sim" / "stack.yaml"
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))
    with pytest.raises(InputError) as refused:
        _ = Study.open(folder).stack
    assert sentence in str(refused.value)
    assert str(refused.value).startswith(f"{path}:")


def test_a_border_of_a_package_that_is_not_installed_is_told_with_the_command_that_installs_it(
    folder: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.delitem(BORDERS._entries, "ros1", raising=False)  # tests of the package add it
    path = folder / "sim" / "stack.yaml"
    path.write_text(path.read_text().replace("border: lines", "border: ros1"))
    with pytest.raises(
        InputError, match=r"border='ros1' is of a package .*: scaloft-fi example ros1 && pip install \./ros1"
    ) as refused:
        _ = Study.open(folder).stack
    assert str(refused.value).startswith(f"{path}:")


def test_settings_of_the_part_below_are_checked_before_a_flight(folder: Path):
    edit_in(folder / "sim" / "stack.yaml", "mass_kg: 1.5", "mass_kg: -1.5")
    with pytest.raises(InputError, match=r"mass_kg=-1.5 must be >= 1e-06"):
        Study.open(folder).check()


def test_another_program_in_the_study_means_other_flights(folder: Path):
    (folder / "sim" / "planner.py").write_text("a = 1\n")
    before = Study.open(folder).inputs
    (folder / "sim" / "planner.py").write_text("a = 2\n")
    after = Study.open(folder).inputs
    assert before["sim"] != after["sim"]
    assert before["code"] == after["code"]


def test_the_code_of_a_border_and_of_the_reader_of_a_record_enters_the_keys(folder: Path, tmp_path: Path):
    assert "scaloft_fi.outside.lines" in Study.open(folder).flying_modules
    commanded = example("own_simulator", tmp_path / "commanded")
    with (commanded / "sim" / "flyer.yaml").open("a") as file:
        file.write("clock: {topic: /clock, border: ros2}\n")
    modules = Study.open(commanded).flying_modules
    assert modules[-2:] == ("scaloft_fi.outside.ros2", "scaloft_fi.outside.readers")


def test_an_archive_counts_without_the_program_of_its_command(tmp_path: Path):
    study = Study.open(example("own_simulator", tmp_path / "commanded"))
    (study.folder / "fly.py").unlink()
    with pytest.raises(InputError, match=r"fly\.py"):
        _ = study.inputs
    assert replace(study, archived_name="commanded").inputs["sim"]


def test_a_false_contact_comes_with_each_period_and_leaves_a_true_one():
    operator = OPERATORS["false_contact"]
    example = operator.example
    context = example.context()
    tap = operator.tap(context, operator.check("contact", example.message, example.arguments))
    arrived = tuple(tap(k * context.period_s, sample) for k, sample in enumerate(example.before))
    assert arrived == example.after
    assert tap(0.15, example.before[0]._replace(hull=True)).hull
    assert tap(0.2, None) is None


KEY = "T0O0W0D0H1"
RISES = """
import sys, time
from scaloft_fi.outside.client import connect

print("ready", flush=True)
border = connect(publishes=["/cmd_vel", "/land"])
for message in border:
    if "clock" not in message:
        continue
    order, now_s = {"velocity": [0.0, 0.0, 0.3], "turn_radps": 0.0}, message["clock"]
    if now_s >= 3.0:
        FAULT
    border.send("/cmd_vel", order)
"""
"""A stack that climbs, and from 3 s on does something else."""


@pytest.fixture(scope="module")
def planner(tmp_path_factory: pytest.TempPathFactory) -> Study:
    folder = tmp_path_factory.mktemp("outside") / "study"
    example("outside_planner", folder)
    return Study.open(folder)


@pytest.fixture
def faulty(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[str], Study]:
    """The study with a stack that has the fault."""

    def made(fault: str, program: str = RISES) -> Study:
        folder = tmp_path / f"study{len(list(tmp_path.glob('study*')))}"
        example("outside_planner", folder)
        (folder / "sim" / "faulty.py").write_text(program.replace("FAULT", fault))
        settings = folder / "sim" / "stack.yaml"
        text = settings.read_text().replace("over_lines.py", "faulty.py")
        text = text.replace("answer_s: 0.5", "answer_s: 0.02\nsilent_ticks: 5").replace("ready_s: 20.0", "ready_s: 2.0")
        settings.write_text(text)
        monkeypatch.setenv("MARK", str(tmp_path))
        return Study.open(folder)

    yield made
    assert marked(str(tmp_path)) == []


def flown(study: Study, subject: str = "") -> Outcome:
    mutant = PLACEBO if subject == PLACEBO.id else realise(study.matrix, subject) if subject else None
    flight = Flight(mutant, study.grid.situation(KEY), 0)
    return judged(study, flight, fly_log(study, flight))


@pytest.fixture(scope="module")
def outside(planner: Study) -> dict[str, Outcome]:
    """A flight of each subject; that of the baseline as a run flies it, in a process of its own."""
    flights: list[Outcome] = []
    Worker(planner, Physics())(Batch((Flight(None, planner.grid.situation(KEY), 0),)), flights.append)
    return {"": flights[0]} | {subject: flown(planner, subject) for subject in ("LATE-human@3s", PLACEBO.id)}


@pytest.mark.release
@pytest.mark.flight
def test_a_planner_outside_flies_bit_for_bit_as_the_same_planner_inside(
    outside: dict[str, Outcome], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.syspath_prepend(str(ROOT / "examples" / "outside_planner" / "sim"))
    import inside  # noqa: F401 - it declares the stack

    example("outside_planner", tmp_path / "study", ("name: outside", "name: planner_inside"))
    within = Study.open(tmp_path / "study")
    assert within.stack.name == "planner_inside"
    for subject in ("", "LATE-human@3s"):
        own = outside[subject]
        assert (own.ending, own.stack_error) == ("landed", "")
        assert own.digest == flown(within, subject).digest
        assert (own.altered > 0) == (subject == "LATE-human@3s")


@pytest.mark.release
@pytest.mark.flight
def test_placebo_outside_flies_as_the_baseline_and_a_late_person_is_shown(outside: dict[str, Outcome]):
    baseline, late, placebo = outside.values()
    assert placebo.digest == baseline.digest
    assert placebo.carried > 0
    assert [violation.requirement for violation in baseline.violations] == []
    assert "SR2" in [violation.requirement for violation in late.violations]


@pytest.mark.flight
def test_a_deterministic_stack_that_computes_for_longer_than_a_tick_waits_flies_as_a_fast_one(
    faulty: Callable[[str], Study],
):
    fast = "order['velocity'][2] = 3.5 - now_s"
    slow = f"""{fast}
        until = time.perf_counter() + 0.05 * (now_s < 3.5)
        while time.perf_counter() < until: pass"""
    assert flown(faulty(slow)).digest == flown(faulty(fast)).digest


class OfALoadedMachine:
    """Processes, and their border at once, which answer at the wait after they were last seen to compute.

    Args:
        looks: how often they are seen to compute.
        given_s: processor time that they are given with each look [s].
    """

    def __init__(self, looks: int, given_s: float, lacks: str = "") -> None:
        self.looks, self.given_s, self.spent_s, self.lacks = looks, given_s, 0.0, lacks

    def lacking(self) -> str:
        return self.lacks

    def wait(self, seam: str, within_s: float) -> bool:
        return self.looks < 0

    def computing(self) -> bool:
        self.looks, self.spent_s = self.looks - 1, self.spent_s + self.given_s
        return self.looks >= 0

    def computed_s(self) -> float:
        return self.spent_s

    def ended(self, within_s: float) -> str:
        return ""

    def last_lines(self) -> str:
        return ""


@pytest.mark.parametrize(("looks", "given_s"), [(0, 0.01), (400, 0.0), (4, 0.02)])
def test_an_answer_is_heard_however_late_a_loaded_machine_lets_it_come(planner: Study, looks: int, given_s: float):
    assert awaited(planner, OfALoadedMachine(looks, given_s)) == 0


def test_a_stack_that_computes_without_end_hangs(planner: Study):
    with pytest.raises(OutsideError, match=r"no answer on /cmd_vel for 0\.1 s of one tick, in which a process"):
        awaited(planner, OfALoadedMachine(400, 0.01))


def test_a_stack_that_has_closed_its_socket_is_told_as_such(planner: Study):
    with pytest.raises(OutsideError, match=r"no answer on /cmd_vel for 5 ticks in a row: one closed its socket"):
        awaited(planner, OfALoadedMachine(0, 0.0, "one closed its socket"), silent=4, deterministic=False)


def awaited(planner: Study, loaded: OfALoadedMachine, silent: int = 0, *, deterministic: bool = True) -> int:
    """Wait for one answer, after some ticks without one; return the ticks in a row without one."""
    config = replace(planner.sim.stack.settings(planner.stack), answer_s=0.02, silent_ticks=5)
    config = replace(config, deterministic=deterministic)
    exchange = Exchange(config, cast(Any, None), cast(Any, loaded), cast(Any, loaded), cast(Any, None), "", silent)
    exchange._await_answer()
    return exchange._silent


@pytest.mark.flight
@pytest.mark.parametrize(
    ("fault", "sentence"),
    [
        ("print('no route'); sys.exit(3)", "faulty.py ended with code 3; its last lines: ready / no route"),
        ("import os; os.kill(os.getpid(), 11)", "faulty.py was ended by SIGSEGV; its last lines: ready"),
        # on a slow machine its messages stay unread for so long that it is cut off, and told so
        pytest.param("time.sleep(60)", "no answer on /cmd_vel for 5 ticks in a row", marks=pytest.mark.release),
        ("order['turn_radps'] = float('nan')", "NaN is no number of JSON"),
        ("order['velocity'] = 'fast'", "/cmd_vel: data.velocity must be a list of 3 numbers"),
        (
            "border._write({'topic': '/cmd_vel', 'stamp_s': now_s + 9, 'data': order}); continue",
            "is later than the clock",
        ),
    ],
)
def test_what_goes_wrong_outside_is_the_drones_with_a_sentence_and_its_last_words(
    faulty: Callable[[str], Study], fault: str, sentence: str
):
    outcome = flown(faulty(fault))
    assert outcome.invalid == ""
    assert sentence in outcome.stack_error
    assert outcome.stack_error.startswith(("companion at 3.", "outside at 3."))
    assert outcome.ending in ("landed", "struck", "timed_out")


@pytest.mark.flight
def test_a_stack_that_is_killed_is_the_harness_and_is_flown_again(faulty: Callable[[str], Study]):
    study = faulty("import os; os.kill(os.getpid(), 9)")
    with pytest.raises(BorderError, match=r"^faulty\.py was ended by SIGKILL; its last lines: ready"):
        flown(study)


@pytest.mark.flight
def test_a_flood_changes_no_flight(faulty: Callable[[str], Study]):
    outcome = flown(faulty("[border.send('/cmd_vel', order) for _ in range(50)]"))
    assert outcome.stack_error == ""


@pytest.mark.flight
@cases("program", "sentence")
def test_a_stack_that_never_comes_up_is_the_harness(faulty: Callable[..., Study], program: str, sentence: str):
    study = faulty("", program)
    with pytest.raises(BorderError, match="the stages outside never came up") as refused:
        flown(study)
    assert sentence in str(refused.value)
    assert refused.value.exit_code == 4
