from __future__ import annotations

import pytest
from papers import STUDY, flight

from scaloft_fi.analysis.detection import Spending
from scaloft_fi.analysis.score import score_of
from scaloft_fi.judge.outcome import BASELINE, Outcome
from scaloft_fi.judge.status import rulings_of
from scaloft_fi.study import Study
from scaloft_fi.verbs.score import detected_so_far

HUMAN = ("T0O0W0D0H1", "T0O1W0D0H1", "T1O0W0D0H1")


@pytest.fixture(scope="module")
def study() -> Study:
    return Study.open(STUDY)


@pytest.fixture(scope="module")
def outcomes(study: Study) -> list[Outcome]:
    pool = [flight(study, BASELINE, key, seed) for key in HUMAN for seed in range(10)]
    return pool + [flight(study, id_, key, 0) for id_ in ("LATE-human@3s", "MORE-goal@0.6m") for key in HUMAN]


def test_it_counts_by_guideword_what_the_score_detects_of_what_is_stored(study: Study, outcomes: list[Outcome]) -> None:
    scored = score_of(rulings_of(outcomes), study.roster, study.space, Spending())
    assert [mutant.subject.id for mutant in scored.counted if mutant.detected] == ["LATE-human@3s"]
    lines = detected_so_far(study, outcomes, Spending())
    assert lines == ["detected so far: 1 of 2 flown:  MORE 0/1  LATE 1/1"]


def test_a_narrow_terminal_gets_more_lines_and_a_campaign_without_mutants_none(
    study: Study, outcomes: list[Outcome], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "40")
    assert detected_so_far(study, outcomes, Spending()) == ["detected so far: 1 of 2 flown:", "  MORE 0/1  LATE 1/1"]
    assert detected_so_far(study, outcomes[:30], Spending()) == []
