import numpy as np
import pytest
from filterpy.kalman import KalmanFilter
from hypothesis import given
from hypothesis import strategies as st

from scaloft_fi.stack.reference.estimator import error_filter, plausible, transition

triples = st.tuples(*[st.floats(-5, 5)] * 3).map(np.array)


@given(st.floats(0.001, 0.2), triples, st.integers(0, 2**32 - 1))
def test_the_transition_carries_velocity_tilt_and_biases_on(dt_s, force, seed):
    r = np.random.default_rng(seed).normal(size=(3, 3))
    f = np.eye(15)
    transition(f, dt_s, force, r)
    expected = np.eye(15)
    expected[0:3, 3:6] = dt_s * np.eye(3)
    ax, ay, az = force
    expected[3:6, 6:9] = -np.array([[0, -az, ay], [az, 0, -ax], [-ay, ax, 0]])
    expected[3:6, 12:15] = expected[6:9, 9:12] = -dt_s * r
    assert np.array_equal(f, expected)


@given(st.tuples(*[st.floats(-3, 3)] * 4).map(np.array), st.floats(0.1, 10))
def test_the_gate_is_so_many_standard_deviations_of_each_part(error, gate_sigma):
    kf = error_filter(0.02, 0.001, 0.0001, 0.002, 0.01, 0.02)
    kf.P = kf.P * 1e4
    sigma = np.sqrt(np.diag(kf.P)[[0, 1, 2, 8]] + np.diag(kf.R))
    assert plausible(error, kf.P, kf.R, gate_sigma) == bool(np.all(np.abs(error) <= gate_sigma * sigma))


def test_what_is_no_number_is_not_plausible():
    kf = error_filter(0.02, 0.001, 0.0001, 0.002, 0.01, 0.02)
    assert not plausible(np.array([0.0, np.nan, 0.0, 0.0]), kf.P, kf.R, 8.0)


@given(st.integers(0, 2**32 - 1), st.lists(st.booleans(), min_size=1, max_size=60))
def test_the_filter_is_filterpys_but_for_the_rounding(seed, fixes):
    rng = np.random.default_rng(seed)
    ours, theirs = error_filter(0.02, 0.001, 0.0001, 0.002, 0.01, 0.02), KalmanFilter(15, 4)
    for name in ("x", "Q", "H", "R", "F"):
        setattr(theirs, name, getattr(ours, name).copy())
    for fix in fixes:
        transition(ours.F, rng.uniform(0.01, 0.2), rng.normal(size=3), rng.normal(size=(3, 3)))
        theirs.F, theirs.P = ours.F.copy(), ours.P.copy()
        ours.predict()
        theirs.predict()
        if fix:
            z = rng.normal(size=4)
            ours.update(z)
            theirs.update(z)
            for name in ("S", "K", "x"):
                assert _close(getattr(ours, name), getattr(theirs, name))
            ours.x[:] = theirs.x[:] = 0.0
        assert _close(ours.P, theirs.P)


def _close(ours, theirs):
    return np.abs(ours - theirs).max() <= 1e-11 * np.abs(theirs).max()


def test_a_singular_innovation_is_refused_as_by_numpy():
    kf = error_filter(0.02, 0.001, 0.0001, 0.002, 0.01, 0.02)
    kf.P, kf.R = np.zeros((15, 15)), np.zeros((4, 4))
    with pytest.raises(np.linalg.LinAlgError, match="Singular"):
        kf.update(np.zeros(4))
