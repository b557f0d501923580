"""Kinds of fields, and the depth camera."""

import copy
import math
from typing import Annotated, NamedTuple

import numpy as np
import pytest

from scaloft_fi.stack import messages
from scaloft_fi.stack.messages import Array, DepthCamera, Image, Point, Stamp, Vector, field_type


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
