import math

import numpy as np
import pytest

from scaloft_fi.stack.messages import Fix, Imu
from scaloft_fi.stack.reference.estimator import Estimator, EstimatorConfig

CONFIG = EstimatorConfig(
    rate_noise=0.005,
    force_noise=0.05,
    rate_bias_walk=0.0005,
    force_bias_walk=0.005,
    fix_sigma_m=0.02,
    fix_yaw_sigma_rad=0.02,
    gate_sigma=8.0,
    reset_after_s=1.0,
    stale_after_s=0.5,
    history_s=0.6,
)
REST = (np.zeros(3), np.array([0.0, 0.0, 9.81]))


def run(estimator, seconds, imu=REST, fix=None, start_s=0.0):
    """Feed constant inertial samples at 240 Hz and `fix(t)` at 20 Hz; returns the last pose."""
    pose = None
    for k in range(round(seconds * 240)):
        t = start_s + k / 240
        if k % 12 == 0:
            pose = estimator.tick(t, fix(t) if fix else None)
        estimator.inertial(t, Imu(t, *imu))
    return pose


def test_an_exact_sensor_at_rest_stays_where_it_is():
    estimator = Estimator(CONFIG, np.array([1.0, 2.0, 3.0]), 0.5)
    pose = run(estimator, 2.0)
    assert pose.position == pytest.approx([1.0, 2.0, 3.0], abs=1e-9)
    assert pose.yaw_rad == pytest.approx(0.5, abs=1e-9)


def test_a_constant_push_without_fixes_integrates_as_half_a_t_squared():
    estimator = Estimator(CONFIG, np.zeros(3), math.pi / 2)
    run(estimator, 2.0, (np.zeros(3), np.array([1.0, 0.0, 9.81])))
    t = (2.0 * 240 - 1) / 240
    assert estimator.state[1] == pytest.approx(0.5 * t * t, rel=1e-6), "a push ahead while facing +y moves along +y"
    assert estimator.state[0] == pytest.approx(0.0, abs=1e-9)


def test_a_biased_gyro_is_found_out_by_the_fixes():
    estimator = Estimator(CONFIG, np.zeros(3), 0.0)
    bias = np.array([0.0, 0.0, 0.03])
    run(estimator, 40.0, (bias, REST[1]), lambda t: Fix(t, np.zeros(3), 0.0))
    assert estimator.state[12] == pytest.approx(0.03, abs=0.01)
    assert abs(estimator.state[8]) < 0.02, "the heading stays near the fixes' heading"


def test_a_late_fix_is_compared_with_the_estimate_of_its_own_time():
    velocity = np.array([1.0, 0.0, 0.0])
    punctual, late = (Estimator(CONFIG, np.zeros(3), 0.0) for _ in range(2))
    for estimator, delay_s in ((punctual, 0.0), (late, 0.3)):
        estimator.state[3:6] = velocity
        run(estimator, 3.0, REST, lambda t, d=delay_s: Fix(t - d, velocity * (t - d), 0.0) if t >= d else None)
    assert late.state[0] == pytest.approx(punctual.state[0], abs=0.01)


@pytest.mark.parametrize(
    ("stamp_of", "why"),
    [(lambda _t: 0.0, "no stamp"), (lambda t: t - 0.7, "too old"), (lambda t: t + 5.0, "from the future")],
)
def test_a_fix_with_an_impossible_stamp_is_refused(stamp_of, why):
    estimator = Estimator(CONFIG, np.zeros(3), 0.0)
    run(estimator, 1.0, REST, lambda t: Fix(stamp_of(t), np.array([0.05, 0.0, 0.0]), 0.0))
    assert estimator.state[0] == pytest.approx(0.0, abs=1e-9), why
    assert estimator.last_fix_s == 0.0


def test_a_jump_of_the_fix_is_refused_at_first_and_taken_over_in_the_end():
    estimator = Estimator(CONFIG, np.zeros(3), 0.0)
    run(estimator, 2.0, REST, lambda t: Fix(t, np.zeros(3), 0.0))
    far = np.array([3.0, 0.0, 0.0])
    run(estimator, 0.5, REST, lambda t: Fix(t, far, 0.0), start_s=2.0)
    assert abs(estimator.state[0]) < 0.1
    run(estimator, 1.0, REST, lambda t: Fix(t, far, 0.0), start_s=2.5)
    assert estimator.state[0] == pytest.approx(3.0, abs=0.1)
