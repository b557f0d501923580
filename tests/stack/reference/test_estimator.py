"""The estimate, its covariance against sums of exact fractions, and its filter against filterpy's."""

import math
from fractions import Fraction

import numpy as np
import pytest
from filterpy.kalman import KalmanFilter
from hypothesis import given, settings
from hypothesis import strategies as st

from scaloft_fi.stack.messages import Fix, Imu
from scaloft_fi.stack.reference import estimator as compiled
from scaloft_fi.stack.reference.estimator import MEASURED, SIZE, Estimator, History, error_filter

seeds = st.integers(0, 2**32 - 1)
REST = (np.zeros(3), np.array([0.0, 0.0, 9.81]))


def product(a, b):
    """The product of two matrices by fused multiply-adds in the order of the terms, each rounded once."""
    out = np.zeros((len(a), b.shape[1]))
    for place in np.ndindex(out.shape):
        for x, y in zip(a[place[0]], b[:, place[1]], strict=True):
            out[place] = float(Fraction(float(x)) * Fraction(float(y)) + Fraction(float(out[place])))
    return out


def matrices(seed):
    rng = np.random.default_rng(seed)
    wide = rng.normal(size=(SIZE, SIZE)) * 10.0 ** rng.uniform(-4, 2, size=(SIZE, SIZE))
    return wide, rng.normal(size=(SIZE, SIZE)), np.diag(rng.uniform(0.01, 1.0, len(MEASURED)))


@settings(max_examples=5)
@given(seeds)
def test_a_step_turns_and_blurs_the_covariance_and_a_fix_takes_its_gain_off_in_josephs_form(seed):
    f, p, noise = matrices(seed)
    blur = np.diag(np.arange(1.0, SIZE + 1.0))
    assert np.array_equal(compiled.carried(f, p, blur), product(product(f, p), f.T) + blur)
    inverse, z = p[:4, :4].copy(), p[5, :4].copy()
    gain, error, left = compiled.corrected(f, noise, inverse, z)
    assert np.array_equal(gain, product(f[:, MEASURED], inverse))
    assert np.allclose(error, gain @ z, rtol=1e-12, atol=1e-12 * np.abs(gain).max())
    kept = np.eye(SIZE)
    kept[:, MEASURED] -= gain
    assert np.array_equal(left, product(product(kept, f), kept.T) + product(product(gain, noise), gain.T))


def test_what_is_off_by_nothing_is_corrected_by_nothing_not_by_less_and_what_is_no_number_spreads():
    f, p, noise = matrices(0)
    p[3, 4] = np.nan
    assert np.isnan(compiled.carried(f, p, np.zeros((SIZE, SIZE)))).all()
    f[:, MEASURED] = 0.0
    assert not np.signbit(compiled.corrected(f, noise, -np.eye(4), np.ones(4))[1]).any()


@given(seeds)
def test_the_transition_carries_velocity_tilt_and_biases_on(seed):
    rng = np.random.default_rng(seed)
    dt_s, (ax, ay, az), r, f = rng.uniform(0.001, 0.2), rng.normal(size=3), rng.normal(size=(3, 3)), np.eye(SIZE)
    compiled.transition(f, dt_s, np.array([ax, ay, az]), r)
    expected = np.eye(SIZE)
    expected[0:3, 3:6] = dt_s * np.eye(3)
    expected[3:6, 6:9] = -np.array([[0, -az, ay], [az, 0, -ax], [-ay, ax, 0]])
    expected[3:6, 12:15] = expected[6:9, 9:12] = -dt_s * r
    assert np.array_equal(f, expected)


@given(st.tuples(*[st.one_of(st.floats(-3, 3), st.just(math.nan))] * 4).map(np.array), st.floats(0.1, 10))
def test_the_gate_is_so_many_standard_deviations_of_each_part_and_what_is_no_number_is_not_plausible(
    config, error, gate_sigma
):
    kf = error_filter(config.estimator)
    kf.P = kf.P * 1e4
    sigma = np.sqrt(np.diag(kf.P)[list(MEASURED)] + np.diag(kf.R))
    assert compiled.plausible(error, kf.P, kf.R, gate_sigma) == bool(np.all(np.abs(error) <= gate_sigma * sigma))


def close(ours, theirs):
    return np.abs(ours - theirs).max() <= 1e-11 * np.abs(theirs).max()


@given(seeds, st.lists(st.booleans(), min_size=1, max_size=60))
def test_the_filter_is_filterpys_but_for_the_rounding(config, seed, fixes):
    rng = np.random.default_rng(seed)
    ours, theirs = error_filter(config.estimator), KalmanFilter(15, 4)
    for name in ("x", "Q", "H", "R", "F"):
        setattr(theirs, name, getattr(ours, name).copy())
    for fix in fixes:
        compiled.transition(ours.F, rng.uniform(0.01, 0.2), rng.normal(size=3), rng.normal(size=(3, 3)))
        theirs.F, theirs.P = ours.F.copy(), ours.P.copy()
        ours.predict()
        theirs.predict()
        if fix:
            z = rng.normal(size=4)
            ours.update(z)
            theirs.update(z)
            assert all(close(getattr(ours, name), getattr(theirs, name)) for name in ("S", "K", "x"))
            ours.x[:] = theirs.x[:] = 0.0
        assert close(ours.P, theirs.P)


def test_a_singular_innovation_is_refused_as_by_numpy(config):
    kf = error_filter(config.estimator)
    kf.P, kf.R = np.zeros((15, 15)), np.zeros((4, 4))
    with pytest.raises(np.linalg.LinAlgError, match="Singular"):
        kf.update(np.zeros(4))


@given(st.lists(st.tuples(*[st.floats(-10, 10)] * 4), min_size=1, max_size=200), st.floats(-0.5, 2.5))
def test_the_past_is_interpolated_within_its_span_and_shifted_by_corrections(steps, age_s):
    history = History(0.62)
    for k, estimate in enumerate(steps):
        numbers = np.zeros(compiled.NUMBERS)
        numbers[:3] = estimate[:3]
        numbers[8], numbers[9] = math.sin(0.5 * estimate[3]), math.cos(0.5 * estimate[3])
        history.add(k / 20, numbers)
    rows = (history.rows, history.begin, history.end)
    compiled.shifted(*rows, np.array([1.0, 2.0, 3.0]), 0.5)
    place, now_s = (np.array(steps) + np.array([1.0, 2.0, 3.0, 0.5]))[-13:], (len(steps) - 1) / 20
    times, stamp_s = [now_s - k / 20 for k in reversed(range(len(place)))], now_s - age_s
    found = np.empty(4)
    compiled.recalled(*rows, stamp_s, found)
    assert found[:3] == pytest.approx([np.interp(stamp_s, times, place[:, axis]) for axis in range(3)])
    yaw = np.interp(stamp_s, times, np.unwrap(place[:, 3]))
    assert math.remainder(found[3] - yaw, 2 * math.pi) == pytest.approx(0.0, abs=1e-6)


@settings(max_examples=200)
@given(st.one_of(st.floats(-1e6, 1e6), st.integers(-2000, 2000).map(lambda k: k * math.pi), st.just(math.nan)))
def test_an_angle_is_wrapped_as_the_standard_library_does_to_the_bit(angle):
    ours, theirs = compiled.wrapped(angle), math.remainder(angle, 2.0 * math.pi)
    assert (ours == theirs and math.copysign(1.0, ours) == math.copysign(1.0, theirs)) or math.isnan(theirs)


def test_an_infinite_angle_has_no_rest():
    with pytest.raises(ValueError, match="math domain error"):
        compiled.wrapped(math.inf)


@pytest.fixture
def estimator(config):
    return Estimator(config.estimator, np.zeros(3), 0.0)


def run(estimator, seconds, imu=REST, fix=None, start_s=0.0):
    """Feed constant inertial samples at 240 Hz and `fix(t)` at 20 Hz; returns the last pose."""
    pose = None
    for k in range(round(seconds * 240)):
        t = start_s + k / 240
        if k % 12 == 0:
            pose = estimator.tick(t, fix(t) if fix else None)
        estimator.inertial(t, Imu(t, *imu))
    return pose


def test_an_exact_sensor_at_rest_stays_where_it_is(config):
    pose = run(Estimator(config.estimator, np.array([1.0, 2.0, 3.0]), 0.5), 2.0)
    assert pose.position == pytest.approx([1.0, 2.0, 3.0], abs=1e-9)
    assert pose.yaw_rad == pytest.approx(0.5, abs=1e-9)


def test_a_constant_push_without_fixes_integrates_as_half_a_t_squared(config):
    estimator = Estimator(config.estimator, np.zeros(3), math.pi / 2)
    run(estimator, 2.0, (np.zeros(3), np.array([1.0, 0.0, 9.81])))
    t = (2.0 * 240 - 1) / 240
    assert estimator.state[:2] == pytest.approx([0.0, 0.5 * t * t], rel=1e-6, abs=1e-9), "ahead, while facing +y"


def test_a_biased_gyro_is_found_out_by_the_fixes(estimator):
    run(estimator, 40.0, (np.array([0.0, 0.0, 0.03]), REST[1]), lambda t: Fix(t, np.zeros(3), 0.0))
    assert estimator.state[12] == pytest.approx(0.03, abs=0.01)
    assert estimator.rate[2] == pytest.approx(0.0, abs=0.01)
    assert abs(estimator.state[8]) < 0.02, "the heading stays near the fixes' heading"


def test_a_late_fix_is_compared_with_the_estimate_of_its_own_time(config):
    velocity = np.array([1.0, 0.0, 0.0])
    punctual, late = (Estimator(config.estimator, np.zeros(3), 0.0) for _ in range(2))
    for estimator, delay_s in ((punctual, 0.0), (late, 0.3)):
        estimator.state[3:6] = velocity
        run(estimator, 3.0, REST, lambda t, d=delay_s: Fix(t - d, velocity * (t - d), 0.0) if t >= d else None)
    assert late.state[0] == pytest.approx(punctual.state[0], abs=0.01)


@pytest.mark.parametrize("stamp_of", [lambda _t: 0.0, lambda t: t - 0.7, lambda t: t + 5.0])
def test_a_fix_without_a_stamp_too_old_or_from_the_future_is_refused(estimator, stamp_of):
    run(estimator, 1.0, REST, lambda t: Fix(stamp_of(t), np.array([0.05, 0.0, 0.0]), 0.0))
    assert estimator.state[0] == pytest.approx(0.0, abs=1e-9)
    assert estimator.last_fix_s == 0.0


def test_a_jump_of_the_fix_is_refused_at_first_and_taken_over_in_the_end(estimator):
    run(estimator, 2.0, REST, lambda t: Fix(t, np.zeros(3), 0.0))
    run(estimator, 0.5, REST, lambda t: Fix(t, np.array([3.0, 0.0, 0.0]), 0.0), start_s=2.0)
    assert abs(estimator.state[0]) < 0.1
    run(estimator, 1.0, REST, lambda t: Fix(t, np.array([3.0, 0.0, 0.0]), 0.0), start_s=2.5)
    assert estimator.state[0] == pytest.approx(3.0, abs=0.1)
