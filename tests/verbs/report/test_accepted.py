"""Dispositions in the page: every survivor with what was decided of it, and no clock."""

from __future__ import annotations

import shutil
from dataclasses import replace
from datetime import date
from pathlib import Path
from typing import Any

import pytest
from counting import counts_of, exported
from papers import STUDY, campaign, evidence_of

from scaloft_fi.analysis.score import score
from scaloft_fi.study import Study
from scaloft_fi.verbs.report.analyses import Evidence
from scaloft_fi.verbs.report.matrices import accepted

ACCEPTED = """\
MORE-goal:
  {status: accepted, owner: A. Engineer, reason: there is 1 m of room, expires: 2027-01-31}
LATE-human:
  {status: accepted, owner: B. Engineer, reason: old, expires: 2027-01-31}
NO-pose:
  {status: accepted, owner: C. Engineer, reason: not flown, expires: 2027-01-31, situations: [T0O0W0D0H0]}
"""


@pytest.fixture(scope="module")
def accepting(tmp_path_factory: pytest.TempPathFactory) -> Evidence:
    folder = tmp_path_factory.mktemp("accepting")
    for name in ("hazop", "mutants", "sim"):
        shutil.copytree(STUDY / name, folder / name)
    (folder / "hazop" / "dispositions.yaml").write_text(ACCEPTED, encoding="utf-8")
    study = Study.open(folder)
    return evidence_of(study, campaign(study))


def judged(evidence: Evidence) -> dict[str, dict[str, Any]]:
    study = evidence.study
    scored = score(evidence.outcomes, study.roster, study.space)
    told = accepted(scored, study.roster, study.dispositions, evidence.today)
    return {entry["mutant"]: entry for entry in told["judged"]}


def test_every_survivor_of_the_score_is_told_with_its_disposition(accepting: Evidence) -> None:
    counted = counts_of(exported(accepting))
    told = judged(accepting)
    asked = {id_: set(entry["surviving"]) for id_, entry in told.items() if entry["state"] in ("open", "accepted")}
    assert asked.keys() == {"MORE-goal@0.6m", "LESS-goal@0.05m"}
    for id_, keys in asked.items():
        assert keys == {key for key, count in counted[id_].items() if count.tests}
    found = told["MORE-goal@0.6m"]
    said = [found[name] for name in ("state", "owner", "reason", "until", "situations")]
    assert said == ["accepted", "A. Engineer", "there is 1 m of room", "2027-01-31", []]
    assert {id_: entry["state"] for id_, entry in told.items() if id_ not in asked} == {
        "LATE-human@3s": "stale",
        "NO-pose@3s": "untested",
    }


@pytest.mark.parametrize(
    ("today", "state"), [(None, "accepted"), (date(2027, 1, 31), "accepted"), (date(2027, 2, 1), "expired")]
)
def test_only_a_day_that_was_given_makes_one_expire(accepting: Evidence, today: date | None, state: str) -> None:
    told = judged(replace(accepting, today=today))
    assert told["MORE-goal@0.6m"]["state"] == state
    assert told["MORE-goal@0.6m"]["until"] == "2027-01-31"
    assert told["LATE-human@3s"]["state"] == "stale"


def test_a_survival_elsewhere_names_the_situations(accepting: Evidence, tmp_path: Path) -> None:
    shutil.copytree(accepting.study.folder, tmp_path, dirs_exist_ok=True)
    path = tmp_path / "hazop" / "dispositions.yaml"
    text = ACCEPTED.replace("2027-01-31}", "2027-01-31, situations: [T0O0W0D0H0]}", 1)
    path.write_text(text, encoding="utf-8")
    entry = judged(replace(accepting, study=Study.open(tmp_path)))["MORE-goal@0.6m"]
    assert entry["state"] == "uncovered"
    assert set(entry["unnamed"]) == set(entry["surviving"]) - {"T0O0W0D0H0"}


def test_a_study_without_the_file_has_open_survivors_only(evidence: Evidence) -> None:
    assert {entry["state"] for entry in judged(evidence).values()} == {"open"}
