"""The study is whole, and the stack keeps its contract in it."""

from pathlib import Path

from scaloft_fi.api import Study, check_stack

STUDY = Path(__file__).resolve().parents[1] / "study"


def test_the_study_is_whole():
    Study.open(STUDY).check()


def test_the_stack_keeps_its_contract():
    assert check_stack(STUDY).failures == ()
