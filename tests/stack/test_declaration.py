"""Declarations, kinds of fields, the depth camera, when two samples differ, and the claims of the reference stack."""

import copy
import math
from typing import Annotated, NamedTuple

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from tiny_stack import SOUND, hop

from scaloft_fi.stack import messages
from scaloft_fi.stack.declaration import Instant
from scaloft_fi.stack.messages import Array, DepthCamera, Fix, Image, Imu, Point, Stamp, Vector, field_type
from scaloft_fi.stack.reference.declaration import CLAIMS, REFERENCE, SEAMS
from scaloft_fi.stack.reference.messages import ObstacleMap


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"seams": (*SOUND.seams, SOUND.seams[0])}, "stack 'hop' declares seam 'gyro' twice"),
        ({"beliefs": (*SOUND.beliefs, SOUND.beliefs[1])}, "stack 'hop' declares belief 'doubt' twice"),
        ({"canaries": ("rotors", "propeller")}, "stack 'hop' has no seam 'propeller' for a canary"),
    ],
)
def test_a_declaration_that_contradicts_itself_is_refused(changes, sentence):
    with pytest.raises(ValueError, match=f"^{sentence}$"):
        hop(**changes)


def test_caps_are_of_the_beliefs_that_declare_a_greatest_value():
    assert SOUND.caps == {"doubt": 1.0}
    assert SOUND.belief_names == ("clock_s", "doubt")


NUMBERS = st.sampled_from([0.0, -0.0, 1.0, np.nextafter(1.0, 2.0), np.nan, np.inf, -np.inf])
SHAPES = st.sampled_from([(0,), (3,), (4,), (2, 8), (17,), (5, 5)])
ARRAYS = SHAPES.flatmap(lambda shape: arrays(np.float64, shape, elements=NUMBERS))


@given(ARRAYS, st.one_of(st.none(), ARRAYS))
def test_arrays_differ_where_numpy_says_so_with_nan_equal_to_itself(first, other):
    second = first.copy() if other is None else other
    differs = REFERENCE.by_name["fix"].differ(Fix(0.0, first, 0.0), Fix(0.0, second, 0.0))
    assert differs is not np.array_equal(first, second, equal_nan=True)


def test_one_number_that_differs_is_enough_and_a_sample_lost_or_made_up_differs():
    seam, rest = REFERENCE.by_name["imu"], Imu(0.0, np.zeros(3), np.array([0.0, 0.0, 9.81]))
    assert not seam.differ(rest, rest._replace(rate=np.zeros(3)))
    assert all(seam.differ(rest, rest._replace(rate=5e-324 * np.eye(3)[axis])) for axis in range(3))
    assert [seam.differ(*pair) for pair in ((rest, None), (None, rest), (None, None))] == [True, True, False]


class Everything(NamedTuple):
    stamp_s: Stamp
    level: float
    count: int
    place: Point
    bare: Array
    push: Vector
    picture: Image
    pair: tuple[float, float]
    mixed: tuple[float, str]
    noted: Annotated[float, "a remark of the author"]
    flag: bool
    label: str


@pytest.mark.parametrize(
    ("of", "names"),
    [
        (messages.stamp_fields, "stamp_s"),
        (messages.vector_fields, "place push"),
        (messages.image_fields, "picture"),
        (messages.number_fields, "stamp_s level count place bare push picture pair noted"),
    ],
)
def test_the_kind_of_a_field_follows_from_its_annotation(of, names):
    assert of(Everything) == tuple(names.split())


def test_the_type_of_a_field_is_without_its_kind():
    assert field_type(Everything, "stamp_s") is float
    assert field_type(Everything, "place") == Point


def test_a_pinhole_camera_looks_ahead_sees_left_on_its_left_and_its_slopes_give_the_rays_back(camera):
    rays = camera.rays
    assert rays.shape == (48, 64, 3)
    assert np.all(rays[:, :, 0] == 1.0)
    assert rays[0, 0, 1] > 0 > rays[0, -1, 1]
    assert rays[0, 0, 2] > 0 > rays[-1, 0, 2]
    assert math.atan(rays[0, 0, 1] + abs(camera.column[1]) / 2) == pytest.approx(1.02974 / 2)
    assert camera.column[0] + 5 * camera.column[1] == pytest.approx(rays[2, 5, 1])
    assert camera.row[0] + 2 * camera.row[1] == pytest.approx(rays[2, 5, 2])


def test_rays_of_another_kind_of_camera_are_refused_and_copies_of_a_stack_share_a_camera(camera):
    assert copy.deepcopy(camera) is camera
    rays = camera.rays.copy()
    rays[3, 3, 1] += 0.01
    with pytest.raises(ValueError, match="pinhole"):
        DepthCamera(rays, 0.0)


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
