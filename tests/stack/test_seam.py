from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from scaloft_fi.stack.messages import Fix, Imu
from scaloft_fi.stack.reference.declaration import REFERENCE

NUMBERS = st.sampled_from([0.0, -0.0, 1.0, np.nextafter(1.0, 2.0), np.nan, np.inf, -np.inf])
SHAPES = st.sampled_from([(0,), (3,), (4,), (2, 8), (17,), (5, 5)])
PAIRS = SHAPES.flatmap(lambda shape: st.tuples(arrays(np.float64, shape, elements=NUMBERS), st.booleans(), SHAPES))


@given(PAIRS, st.data())
def test_arrays_differ_where_numpy_says_so_with_nan_equal_to_itself(drawn, data):
    first, copied, other = drawn
    shape = first.shape if data.draw(st.booleans()) else other
    second = first.copy() if copied else data.draw(arrays(np.float64, shape, elements=NUMBERS))
    differs = REFERENCE.by_name["fix"].differ(Fix(0.0, first, 0.0), Fix(0.0, second, 0.0))
    assert differs is not np.array_equal(first, second, equal_nan=True)


def test_one_number_that_differs_is_enough():
    rest = Imu(0.0, np.zeros(3), np.array([0.0, 0.0, 9.81]))
    assert not REFERENCE.by_name["imu"].differ(rest, rest._replace(rate=np.zeros(3)))
    for axis in range(3):
        turned = np.zeros(3)
        turned[axis] = 5e-324
        assert REFERENCE.by_name["imu"].differ(rest, rest._replace(rate=turned))


def test_a_sample_lost_or_made_up_differs_and_none_at_all_does_not():
    fix = Fix(0.0, np.zeros(3), 0.0)
    assert REFERENCE.by_name["fix"].differ(fix, None)
    assert REFERENCE.by_name["fix"].differ(None, fix)
    assert not REFERENCE.by_name["fix"].differ(None, None)
