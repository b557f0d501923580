"""Flights of stacks in other processes: sound ones, and ones that die, hang and talk nonsense."""

from __future__ import annotations

import importlib.util
from collections.abc import Callable
from pathlib import Path

import pytest
from processes import marked

from scaloft_fi.campaign.flight import Batch, Flight
from scaloft_fi.campaign.flights.fly import Worker, fly_log, judged
from scaloft_fi.campaign.flights.physics import Physics
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.mutants.catalogue import realise
from scaloft_fi.mutants.mutant import PLACEBO
from scaloft_fi.outside.border import BorderError
from scaloft_fi.study import Study

ROOT = Path(__file__).parents[2]
EXAMPLE = ROOT / "examples" / "outside_planner"
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
def make_study() -> Callable[..., None]:
    spec = importlib.util.spec_from_file_location("make_outside_study", EXAMPLE / "make_study.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    made: Callable[..., None] = module.make_study
    return made


@pytest.fixture(scope="module")
def planner(make_study: Callable[..., None], tmp_path_factory: pytest.TempPathFactory) -> Study:
    folder = tmp_path_factory.mktemp("outside") / "study"
    make_study(folder, "lines", ROOT)
    return Study.open(folder)


@pytest.fixture
def faulty(make_study: Callable[..., None], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[str], Study]:
    """The study with a stack that has the fault."""

    def made(fault: str, program: str = RISES) -> Study:
        folder = tmp_path / "study"
        make_study(folder, "lines", ROOT)
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


@pytest.mark.flight
def test_a_planner_outside_flies_bit_for_bit_as_the_same_planner_inside(
    make_study: Callable[..., None], outside: dict[str, Outcome], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.syspath_prepend(str(EXAMPLE))
    import inside  # noqa: F401 - it declares the stack

    make_study(tmp_path / "study", "inside", ROOT)
    within = Study.open(tmp_path / "study")
    assert within.stack.name == "planner_inside"
    for subject in ("", "LATE-human@3s"):
        own = outside[subject]
        assert (own.ending, own.stack_error) == ("landed", "")
        assert own.digest == flown(within, subject).digest
        assert (own.altered > 0) == (subject == "LATE-human@3s")


@pytest.mark.flight
def test_placebo_outside_flies_as_the_baseline_and_a_late_person_is_shown(outside: dict[str, Outcome]) -> None:
    baseline, late, placebo = outside.values()
    assert placebo.digest == baseline.digest
    assert placebo.carried > 0
    assert [violation.requirement for violation in baseline.violations] == []
    assert "SR2" in [violation.requirement for violation in late.violations]


@pytest.mark.flight
@pytest.mark.parametrize(
    ("fault", "sentence"),
    [
        ("print('no route'); sys.exit(3)", "faulty.py ended with code 3; its last lines: ready / no route"),
        ("import os; os.kill(os.getpid(), 11)", "faulty.py was ended by SIGSEGV; its last lines: ready"),
        ("time.sleep(60)", "no answer on /cmd_vel for 5 ticks in a row, for 0.02 s each; its last lines: ready"),
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
) -> None:
    outcome = flown(faulty(fault))
    assert outcome.invalid == ""
    assert sentence in outcome.stack_error
    assert outcome.stack_error.startswith(("companion at 3.", "outside at 3."))
    assert outcome.ending in ("landed", "struck", "timed_out")


@pytest.mark.flight
def test_a_stack_that_is_killed_is_the_harness_and_is_flown_again(faulty: Callable[[str], Study]) -> None:
    study = faulty("import os; os.kill(os.getpid(), 9)")
    with pytest.raises(BorderError, match=r"^faulty\.py was ended by SIGKILL; its last lines: ready"):
        flown(study)


@pytest.mark.flight
def test_a_flood_changes_no_flight(faulty: Callable[[str], Study]) -> None:
    outcome = flown(faulty("[border.send('/cmd_vel', order) for _ in range(50)]"))
    assert outcome.stack_error == ""


@pytest.mark.flight
@pytest.mark.parametrize(
    ("program", "sentence"),
    [
        ("raise SystemExit('no licence')", "ended with code 1; its last lines: no licence"),
        ("import time; time.sleep(60)", "not within 2 s: no process has connected that publishes /cmd_vel, /land"),
    ],
)
def test_a_stack_that_never_comes_up_is_the_harness(faulty: Callable[..., Study], program: str, sentence: str) -> None:
    study = faulty("", program)
    with pytest.raises(BorderError, match="the stages outside never came up") as refused:
        flown(study)
    assert sentence in str(refused.value)
