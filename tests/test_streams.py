from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from scaloft_fi.streams import CHUNK, Table

indices = st.integers(0, 20 * CHUNK)


@given(st.lists(indices, min_size=1, max_size=8))
def test_a_row_does_not_depend_on_the_order_of_asking(order):
    asked = Table(3, "S", 0, "imu")
    rows = {index: asked.row(index).copy() for index in order}
    for index in sorted(rows):
        assert np.array_equal(Table(3, "S", 0, "imu").row(index), rows[index])


def test_bits_are_fixed():
    """A change here changes every flight."""
    assert Table(2, "T0O0W0D0H0", 0, "imu").row(7).tobytes().hex() == "d6360f598777d63f550fffbb55cafb3f"
