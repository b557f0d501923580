"""The limits that are drawn are those of the formulas."""

from __future__ import annotations

import pytest

from scaloft_fi.judge.outcome import TRACK_COLUMNS
from scaloft_fi.judge.requirement import Kind, Requirement
from scaloft_fi.study import Study
from scaloft_fi.verbs.report.analyses import limits


def test_the_reference_study_limits_clearance_speed_and_the_distance_at_which_that_counts(study: Study) -> None:
    found = {
        (limit["requirement"], limit["signal"], limit["sense"], limit["bound"], limit["role"])
        for limit in limits(study.requirements, TRACK_COLUMNS)
    }
    assert ("SR1", "clearance_m", ">", 0.0, "demands") in found
    assert ("SR2", "speed_mps", "<=", 0.25, "demands") in found
    assert ("SR2", "person_sight_m", "<=", 3.0, "when") in found


@pytest.mark.parametrize(
    ("text", "bound"),
    [("always(speed_mps / 0.5 <= 3)", 1.5), ("always(speed_mps>=-2.5)", -2.5), ("always(x_m > 1)", None)],
)
def test_a_limit_is_in_the_unit_of_its_signal(text: str, bound: float | None) -> None:
    found = limits([Requirement("R", Kind.SAFETY, text)], ("speed_mps",))
    assert [limit["bound"] for limit in found] == ([] if bound is None else [bound])
