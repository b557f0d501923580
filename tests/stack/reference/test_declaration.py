"""The claims of the reference stack: right where it sees, wrong where it is blind."""

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
MAPS = (*(ObstacleMap(9.0, np.array([[x, 7.7, 1.6]]), 1.0, np.zeros(3)) for x in (-1.9, -3.0)), None)
"""With something at the place of the contact, with something elsewhere, and none."""


def error(stage, sample=None, struck="", **changes):
    signals = {name: np.array([value, value]) for name, value in (CLEAN | changes).items()}
    signals["limit_mps"][0] = 0.5
    return BY_STAGE[stage].error(Instant(signals, sample, (-1.6, 7.7, 1.6), struck))


def test_a_stack_that_believes_what_is_true_has_no_error():
    assert [error(stage) for stage in BY_STAGE] == [0.0, 0.0, 0.0, 0.0]


@pytest.mark.parametrize(
    ("stage", "changes", "wrong_by"),
    [
        ("position estimate", {"est_x_m": 1.3, "est_y_m": 0.6}, 0.5),
        ("velocity estimate", {"est_vz_mps": 0.3}, 0.2),
        ("person detection", {"person_sight_m": 2.0}, 2.5),
        ("person detection", {"person_sight_m": 5.0}, 0.0),
        ("person detection", {"person_sight_m": 2.0, "told_person": 1.0, "told_range_m": 2.8}, 0.8),
        ("person detection", {"told_person": 1.0, "told_range_m": 2.0}, 2.5),
        ("person detection", {"person_sight_m": 2.0, "limit_mps": 0.2}, 0.0),  # out of view, the limit is lowered
    ],
)
def test_what_a_stage_believes_is_off_by_the_difference_that_matters(stage, changes, wrong_by):
    assert error(stage, **changes) == pytest.approx(wrong_by)


def test_the_map_is_wrong_where_it_has_nothing_at_what_is_struck():
    assert [error("obstacle map", told, "bar") for told in MAPS] == [0.0, 1.0, 1.0]
    assert [error("obstacle map", MAPS[1], struck) for struck in ("", "ground")] == [0.0, 0.0]


def test_claims_listen_to_seams_that_exist():
    assert {claim.seam for claim in CLAIMS} - {""} <= {seam.name for seam in SEAMS}
