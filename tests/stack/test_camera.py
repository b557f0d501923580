import copy
import math

import numpy as np
import pytest

from scaloft_fi.stack.messages import DepthCamera


def test_a_pinhole_camera_looks_ahead_and_sees_left_on_its_left():
    camera = DepthCamera.pinhole(64, 48, 1.02974, ahead_m=0.1)
    assert camera.rays.shape == (48, 64, 3)
    assert np.all(camera.rays[:, :, 0] == 1.0)
    assert camera.rays[0, 0, 1] > 0 > camera.rays[0, -1, 1]
    assert camera.rays[0, 0, 2] > 0 > camera.rays[-1, 0, 2]
    edge = camera.rays[0, 0, 1] + abs(camera.column[1]) / 2
    assert math.atan(edge) == pytest.approx(1.02974 / 2)


def test_slopes_give_the_rays_back():
    camera = DepthCamera.pinhole(8, 6, 1.0, ahead_m=0.0)
    assert camera.column[0] + 5 * camera.column[1] == pytest.approx(camera.rays[2, 5, 1])
    assert camera.row[0] + 2 * camera.row[1] == pytest.approx(camera.rays[2, 5, 2])


def test_rays_of_another_kind_of_camera_are_refused():
    rays = DepthCamera.pinhole(8, 6, 1.0, ahead_m=0.0).rays.copy()
    rays[3, 3, 1] += 0.01
    with pytest.raises(ValueError, match="pinhole"):
        DepthCamera(rays, 0.0)


def test_a_camera_is_shared_by_copies_of_a_stack():
    camera = DepthCamera.pinhole(8, 6, 1.0, ahead_m=0.0)
    assert copy.deepcopy(camera) is camera
