from __future__ import annotations

import json

from builders import GRID, ROSTER, campaigns, outcome
from hypothesis import given

from scaloft_fi.campaign.progress import violation_line
from scaloft_fi.campaign.runs.run import mission_log, to_json
from scaloft_fi.judge.outcome import Outcome

M = "LATE-human@3s"


def test_the_log_keeps_the_keys_of_the_published_one() -> None:
    struck = outcome(M, "T1O0W0D1H0", violated={"SR1": 20.0}, struck="bar")
    log = mission_log([outcome(), outcome(seed=1), struck], ROSTER, GRID)
    assert (log["total_test_cases"], log["generated_test_cases"]) == (64, 3)
    assert log["safety_violation_ids"] == ["SR1:LATE-human@3s/T1O0W0D1H0/0"]
    assert log["generated_situations"][2] == {
        "type": "corner+dark",
        "parameters": {"T": "1", "O": "0", "W": "0", "D": "1", "H": "0"},
        "situation": "T1O0W0D1H0",
        "seed": 0,
    }
    assert log["generated_situations"][0]["type"] == "none"
    assert log["coverage"] == {"distinct_situations": {"part": 2, "whole": 32}, "draws": 3}
    assert log["violations"] == [
        {
            "id": "SR1:LATE-human@3s/T1O0W0D1H0/0",
            "requirement": "SR1",
            "t_s": 20.0,
            "position": [1.0, 2.0, 1.65],
            "struck": "bar",
            "mutant": M,
            "situation": "T1O0W0D1H0",
            "seed": 0,
        }
    ]


def test_an_operability_violation_is_kept_apart() -> None:
    log = mission_log([outcome(violated={"OP1": 60.0, "SR2-literal": 9.0})], ROSTER, GRID)
    assert log["safety_violation_ids"] == log["violations"] == []
    assert [entry["id"] for entry in log["operability_violations"]] == ["OP1:baseline/T0O0W0D0H0/0"]


def test_what_was_planned_is_told_where_it_is_known() -> None:
    assert mission_log([outcome()], ROSTER, GRID, planned=7)["total_test_cases"] == 7
    assert mission_log([], ROSTER, GRID)["total_test_cases"] == 32


def test_a_warning_line_names_requirement_time_place_body_and_flight() -> None:
    struck = outcome(M, violated={"SR1": 20.0}, struck="bar")
    said = "SR1 violated at 20.00 s at (1.00, 2.00, 1.65) m, struck bar: LATE-human@3s/T0O0W0D0H0/0"
    assert violation_line(struck, struck.violations[0]) == said


@given(campaigns())
def test_ids_are_unique_and_each_names_a_violation(outcomes: list[Outcome]) -> None:
    log = mission_log(outcomes, ROSTER, GRID)
    assert json.loads(to_json(log)) == log
    ids = [entry["id"] for entry in log["violations"] + log["operability_violations"]]
    assert len(set(ids)) == len(ids)
    assert log["safety_violation_ids"] == [entry["id"] for entry in log["violations"]]
    assert len(log["generated_situations"]) == log["generated_test_cases"] <= log["total_test_cases"]
