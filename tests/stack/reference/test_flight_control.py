import math

import numpy as np
import pytest

from scaloft_fi.stack.messages import Fix, Imu
from scaloft_fi.stack.reference import estimator as estimating
from scaloft_fi.stack.reference import flight_control as controlling
from scaloft_fi.stack.reference.estimator import Estimator
from scaloft_fi.stack.reference.flight_control import HOLD_MODE, LAND_MODE, VELOCITY_MODE, FlightControl
from scaloft_fi.stack.reference.messages import VelocityCommand

REST = np.array([0.0, 0.0, 9.81])


@pytest.fixture
def order(config):
    """Thrusts after some steps with a frozen vehicle."""

    def make(state=None, mode=HOLD_MODE, velocity=(0.0, 0.0, -0.5), yaw=0.0, steps=1):
        estimate, numbers = np.zeros(estimating.NUMBERS), np.zeros(controlling.NUMBERS)
        own, turn, *_ = estimating.parts_of(estimate)
        own[:] = level() if state is None else state
        estimating.rotation(own[6:10], turn)
        velocity_sp, _, _, gains, allocation, orders, thrust = controlling.parts_of(numbers)
        velocity_sp[:], gains[:], allocation[:] = velocity, config.control.gains(), config.control.allocation()
        orders[:] = mode, yaw, 1.5
        for _ in range(steps):
            controlling.control(estimate, numbers)
        return thrust

    return make


def level(z=0.0):
    state = np.zeros(16)
    state[2], state[9] = z, 1.0
    return state


def test_level_and_in_place_each_rotor_carries_a_quarter_of_the_weight(order):
    assert order() == pytest.approx(np.full(4, 1.5 * 9.81 / 4))


def test_the_allocation_gives_back_thrust_and_torques(config):
    x, y = np.array(config.control.rotors).T
    effect = np.vstack([np.ones(4), y, -x, 0.06 * np.array(config.control.spins)])
    assert effect @ config.control.allocation() == pytest.approx(np.eye(4), abs=1e-12)


def test_it_pushes_where_it_is_to_go(order, config):
    weight, (x, _), spins = 1.5 * 9.81, np.array(config.control.rotors).T, np.array(config.control.spins)
    assert order(level(z=-1.0), steps=60).sum() > weight
    assert order(mode=LAND_MODE, steps=60).sum() < weight
    ahead, left = order(mode=VELOCITY_MODE, velocity=(0.5, 0.0, 0.0), steps=30), order(yaw=1.0, steps=30)
    assert ahead[x < 0].sum() > ahead[x > 0].sum(), "the rear rotors lift"
    assert left[spins > 0].sum() > left[spins < 0].sum()


def test_no_thrust_leaves_its_range_however_wild_the_state(order):
    rng = np.random.default_rng(1)
    for _ in range(200):
        state = rng.normal(0, 10, 16)
        state[6:10] /= np.linalg.norm(state[6:10])
        thrust = order(state, yaw=float(rng.normal(0, 3)))
        assert np.all((thrust >= 0) & (thrust <= 10.35))


@pytest.fixture
def flying(config):
    control = FlightControl(config.control, config.failsafe, Estimator(config.estimator, np.array([0, 0, 1.65]), 0), 0)
    control.take_off(1.65)
    control.command(0.0, VelocityCommand(0.0, np.zeros(3), 0.0), 1.5)
    pass_time(control, 0.0, 1.0, commands=True)
    return control


def pass_time(control, start_s, seconds, fixes=True, imu=True, commands=False):
    for k in range(round(seconds * 240)):
        t = start_s + k / 240
        if k % 12 == 0:
            control.estimator.tick(t, Fix(t, np.array([0.0, 0.0, 1.65]), 0.0) if fixes else None)
            control.watch(t)
            if commands:
                control.command(t, VelocityCommand(t, np.zeros(3), 0.0), 1.5)
        thrust = control.step(t, Imu(t, np.zeros(3), REST) if imu else None)
    return thrust


def test_without_commands_it_holds_and_at_last_lands_and_a_command_ends_a_hold(flying):
    pass_time(flying, 1.0, 1.0)
    assert flying.mode == "hold"
    pass_time(flying, 2.0, 1.0, commands=True)
    assert flying.mode == "offboard"
    pass_time(flying, 3.0, 15.5)
    assert flying.mode == "land"


def test_without_fixes_it_sinks_level(flying):
    pass_time(flying, 1.0, 5.2, fixes=False, commands=True)
    assert flying.mode == "level"


def test_without_inertial_samples_the_rotors_stop(flying):
    thrust = pass_time(flying, 1.0, 0.6, imu=False, commands=True)
    assert flying.mode == "stopped"
    assert not thrust.rotors.any()


def test_an_estimate_that_diverges_stops_the_rotors(flying):
    flying.estimator.state[3] = math.nan
    assert not flying.step(1.0, Imu(1.0, np.zeros(3), REST)).rotors.any()
    assert flying.mode == "stopped"
