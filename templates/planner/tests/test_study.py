"""The study is whole, it flies this planner, and the stack keeps its contract in it."""

from pathlib import Path

from scaloft_fi.api import Study, check_stack

STUDY = Path(__file__).resolve().parents[1] / "study"


def test_the_study_is_whole_and_flies_this_planner():
    study = Study.open(STUDY)
    study.check()
    assert study.stack.name == "your_plugin"


def test_the_stack_keeps_its_contract():
    assert check_stack(STUDY).failures == ()
