from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from scaloft_fi.streams import CHUNK, Table, generator, key_words

indices = st.integers(0, 20 * CHUNK)


@given(st.lists(indices, min_size=1, max_size=8))
def test_a_row_does_not_depend_on_the_order_of_asking(order):
    asked = Table(3, "S", 0, "imu")
    rows = {index: asked.row(index).copy() for index in order}
    for index in sorted(rows):
        assert np.array_equal(Table(3, "S", 0, "imu").row(index), rows[index])


def test_streams_with_other_names_differ():
    rows = {
        tuple(Table(2, *parts).row(0))
        for parts in (("S", 0, "imu"), ("S", 1, "imu"), ("S", 0, "fix"), ("R", 0, "imu"), ("S", 0, "imu", 0))
    }
    assert len(rows) == 5


def test_names_are_kept_apart():
    assert key_words("a", "bc") != key_words("ab", "c")


def test_blocks_do_not_overlap():
    first, second = (generator("S", block=block).standard_normal(4000) for block in (0, 1))
    assert not set(first) & set(second)


def test_rows_are_standard_normal():
    rows = np.array([Table(4, "S", 0, "fix").row(index) for index in range(0, 40 * CHUNK, CHUNK // 2)])
    rows = np.concatenate([rows, [Table(4, "S", 3, "fix").row(i) for i in range(500)]])
    assert abs(rows.mean()) < 0.1
    assert 0.9 < rows.std() < 1.1


def test_uniform_rows_lie_between_0_and_1():
    table = Table(5, "S", 0, "chance", uniform=True)
    rows = np.array([table.row(index) for index in range(CHUNK)])
    assert rows.min() >= 0
    assert rows.max() < 1
    assert abs(rows.mean() - 0.5) < 0.02


def test_bits_are_fixed():
    """A change here changes every flight."""
    assert Table(2, "T0O0W0D0H0", 0, "imu").row(7).tobytes().hex() == "d6360f598777d63f550fffbb55cafb3f"
