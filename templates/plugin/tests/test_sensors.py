"""The tracker tells where the vehicle is."""

import numpy as np

from your_plugin.sensors import matrix


def test_a_quaternion_becomes_its_rotation():
    half = np.sqrt(0.5)
    assert np.allclose(matrix(0.0, 0.0, half, half) @ [1.0, 0.0, 0.0], [0.0, 1.0, 0.0])
