import math
from collections import deque

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from scaloft_fi.stack.reference.estimator import History

SPAN_S = 0.6
small = st.floats(-10, 10)
estimates = st.tuples(small, small, small, small)


class Plain:
    """The same as a list of tuples."""

    def __init__(self):
        self.rows = deque()

    def add(self, now_s, position, yaw_rad):
        self.rows.append((now_s, position.copy(), yaw_rad))
        while now_s - self.rows[0][0] > SPAN_S:
            self.rows.popleft()

    def at(self, stamp_s):
        after = self.rows[-1]
        for before in reversed(self.rows):
            if before[0] <= stamp_s:
                span_s = after[0] - before[0]
                share = min(1.0, (stamp_s - before[0]) / span_s) if span_s > 0 else 0.0
                turned = math.remainder(after[2] - before[2], 2 * math.pi)
                return before[1] + share * (after[1] - before[1]), before[2] + share * turned
            after = before
        return after[1], after[2]

    def shift(self, position, yaw_rad):
        self.rows = deque((t, p + position, y + yaw_rad) for t, p, y in self.rows)


@given(st.lists(st.tuples(estimates, estimates, st.floats(-0.2, 1.0)), min_size=1, max_size=200))
def test_it_is_bit_for_bit_a_list_of_past_estimates(steps):
    history, plain = History(SPAN_S), Plain()
    for k, (estimate, correction, age_s) in enumerate(steps):
        for it in (history, plain):
            it.add(k / 20, np.array(estimate[:3]), estimate[3])
        position, yaw_rad = history.at(k / 20 - age_s)
        expected, expected_rad = plain.at(k / 20 - age_s)
        assert np.array_equal(position, expected)
        assert yaw_rad == expected_rad
        for it in (history, plain):
            it.shift(np.array(correction[:3]), correction[3])
        assert len(history) == len(plain.rows)


def test_a_long_past_is_kept_whole():
    history = History(100.0)
    for k in range(1000):
        history.add(k / 20, np.array([float(k), 0.0, 0.0]), 0.0)
    assert len(history) == 1000
    assert history.at(0.0)[0] == pytest.approx([0, 0, 0])
    assert history.at(20.025)[0] == pytest.approx([400.5, 0, 0])
