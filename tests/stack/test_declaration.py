"""Declarations, and when two samples of a seam differ."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from tiny_stack import SOUND, hop

from scaloft_fi.stack.messages import Fix, Imu
from scaloft_fi.stack.reference.declaration import REFERENCE


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
