import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from scaloft_fi.stack.reference.estimator import STATE_SIZE, correct, propagate, turn

seeds = st.integers(0, 2**32 - 1)


def some_state(draw):
    state = draw.normal(size=STATE_SIZE)
    state[6:10] /= np.linalg.norm(state[6:10])
    return state


@given(seeds)
def test_a_correction_adds_up_and_turns_the_attitude_in_the_world(seed):
    draw = np.random.default_rng(seed)
    state, error = some_state(draw), 0.1 * draw.normal(size=15)
    expected = state.copy()
    expected[:6] += error[:6]
    turn(expected[6:10], *error[6:9], True)
    expected[10:] += error[9:]
    correct(state, error)
    assert np.array_equal(state, expected)


@given(seeds)
def test_the_body_rate_is_the_measured_one_without_its_bias(seed):
    draw = np.random.default_rng(seed)
    state, rate, body_rate = some_state(draw), draw.normal(size=3), np.empty(3)
    propagate(state, rate, draw.normal(size=3), 1 / 240, np.empty((3, 3)), np.zeros(3), body_rate)
    assert np.array_equal(body_rate, rate - state[10:13])
