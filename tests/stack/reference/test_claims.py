"""The claims of the reference stack: right where it sees, wrong where it is blind."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from scaloft_fi.stack.declaration import Instant
from scaloft_fi.stack.reference.declaration import CLAIMS, SEAMS
from scaloft_fi.stack.reference.messages import ObstacleMap

BY_STAGE = {claim.stage: claim for claim in CLAIMS}
CLEAN = {
    **dict.fromkeys(("est_x_m", "est_y_m", "est_z_m", "x_m", "y_m", "z_m"), 1.0),
    **dict.fromkeys(("est_vx_mps", "est_vy_mps", "est_vz_mps", "vx_mps", "vy_mps", "vz_mps"), 0.5),
    "told_person": 0.0,
    "told_range_m": 100.0,
    "person_sight_m": 100.0,
    "limit_mps": 0.5,
}
"""Nobody is there, and the stack believes what is true."""


def error(stage: str, sample: Any = None, struck: str = "", cruise: float = 0.5, **changes: float) -> float:
    signals = {name: np.array([value, value]) for name, value in (CLEAN | changes).items()}
    signals["limit_mps"][0] = cruise
    return BY_STAGE[stage].error(Instant(signals, sample, (-1.6, 7.7, 1.6), struck))


def test_a_stack_that_believes_what_is_true_has_no_error():
    assert [error(stage) for stage in BY_STAGE] == [0.0, 0.0, 0.0, 0.0]


def test_the_estimate_is_off_by_the_length_of_the_difference():
    assert error("position estimate", est_x_m=1.3, est_y_m=0.6) == pytest.approx(0.5)
    assert error("velocity estimate", est_vz_mps=0.3) == pytest.approx(0.2)


def test_a_person_who_is_not_reported_is_missed_by_what_they_are_nearer_than_the_range_that_matters():
    assert error("person detection", person_sight_m=2.0) == 2.5
    assert error("person detection", person_sight_m=5.0) == 0.0
    assert error("person detection", person_sight_m=2.0, told_person=1.0, told_range_m=2.8) == pytest.approx(0.8)
    assert error("person detection", told_person=1.0, told_range_m=2.0) == 2.5


def test_a_person_out_of_view_is_not_missed_once_the_limit_is_lowered():
    assert error("person detection", person_sight_m=2.0, limit_mps=0.2) == 0.0


def test_the_map_is_wrong_where_it_has_nothing_at_what_is_struck():
    near, far = (ObstacleMap(9.0, np.array([[x, 7.7, 1.6]]), 1.0, np.zeros(3)) for x in (-1.9, -3.0))
    assert error("obstacle map", near, "bar") == 0.0
    assert error("obstacle map", far, "bar") == 1.0
    assert error("obstacle map", None, "bar") == 1.0
    assert error("obstacle map", far, "") == error("obstacle map", far, "ground") == 0.0


def test_claims_listen_to_seams_that_exist():
    assert {claim.seam for claim in CLAIMS} - {""} <= {seam.name for seam in SEAMS}
