"""The tilt is the angle of the body's z axis."""

import math

import numpy as np
import pytest

from your_plugin.signals import tilt


@pytest.mark.parametrize("angle_deg", [0.0, 30.0, 180.0])
def test_the_tilt_of_a_roll_is_its_angle(angle_deg):
    state, half = np.zeros(13), math.radians(angle_deg) / 2
    state[3], state[6] = math.sin(half), math.cos(half)
    assert tilt(None)(state) == pytest.approx(angle_deg, abs=1e-5)
