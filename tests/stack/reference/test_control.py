import math

import numpy as np
import pytest

from scaloft_fi.stack.messages import Fix, Imu
from scaloft_fi.stack.reference.estimator import Estimator, EstimatorConfig, rotation
from scaloft_fi.stack.reference.flight_control import (
    HOLD_MODE,
    LAND_MODE,
    MEMORY_SIZE,
    VELOCITY_MODE,
    ControlConfig,
    FailsafeConfig,
    FlightControl,
    control,
)
from scaloft_fi.stack.reference.messages import VelocityCommand

CONFIG = ControlConfig(
    mass_kg=1.5,
    inertia=(0.029, 0.029, 0.055),
    rotors=((0.1, -0.1), (-0.1, 0.1), (0.1, 0.1), (-0.1, -0.1)),
    spins=(1.0, 1.0, -1.0, -1.0),
    moment_m=0.06,
    max_thrust_n=10.35,
    position_p=(0.95, 1.0),
    velocity_p=(1.8, 4.0),
    velocity_i=(0.4, 2.0),
    attitude_p=(6.5, 2.8),
    rate_p=(20.0, 8.0),
    accel_mps2=1.5,
    tilt_accel_mps2=5.0,
    yaw_rate_radps=0.785,
    hold_mps=(0.5, 0.7),
    land_mps=0.5,
)
ESTIMATOR = EstimatorConfig(0.005, 0.05, 0.0005, 0.005, 0.02, 0.02, 8.0, 1.0, 0.5, 0.6)
FAILSAFE = FailsafeConfig(command_hold_s=0.5, command_land_s=15.0, fix_level_s=5.0, imu_stop_s=0.5)


def order(state, mode=HOLD_MODE, velocity=(0.0, 0.0, -0.5), hold=(0.0, 0.0, 0.0), yaw=0.0, steps=1):
    """Thrusts after `steps` steps with a frozen vehicle."""
    r, memory, thrust = np.eye(3), np.zeros(MEMORY_SIZE), np.zeros(4)
    rotation(state[6:10], r)
    for _ in range(steps):
        control(
            state, r, np.zeros(3), mode, np.array(velocity), np.array(hold), yaw, 1.5, 1 / 240,
            CONFIG.gains(), CONFIG.allocation(), memory, thrust,
        )  # fmt: skip
    return thrust


def level(x=0.0, y=0.0, z=0.0):
    state = np.zeros(16)
    state[:3], state[9] = (x, y, z), 1.0
    return state


def test_level_and_in_place_each_rotor_carries_a_quarter_of_the_weight():
    assert order(level()) == pytest.approx(np.full(4, 1.5 * 9.81 / 4))


def test_the_allocation_gives_back_thrust_and_torques():
    x, y = np.array(CONFIG.rotors).T
    effect = np.vstack([np.ones(4), y, -x, 0.06 * np.array(CONFIG.spins)])
    assert effect @ CONFIG.allocation() == pytest.approx(np.eye(4), abs=1e-12)


def test_below_its_place_it_pushes_harder_and_in_a_landing_less():
    weight = 1.5 * 9.81
    assert order(level(z=-1.0), steps=60).sum() > weight
    assert order(level(), mode=LAND_MODE, steps=60).sum() < weight


def test_to_go_ahead_it_pitches_the_nose_down():
    thrust = order(level(), mode=VELOCITY_MODE, velocity=(0.5, 0.0, 0.0), steps=30)
    x = np.array(CONFIG.rotors)[:, 0]
    assert thrust[x < 0].sum() > thrust[x > 0].sum(), "the rear rotors lift"


def test_to_turn_left_the_rotors_that_push_left_speed_up():
    thrust = order(level(), yaw=1.0, steps=30)
    spins = np.array(CONFIG.spins)
    assert thrust[spins > 0].sum() > thrust[spins < 0].sum()


def test_no_thrust_leaves_its_range_however_wild_the_state():
    rng = np.random.default_rng(1)
    for _ in range(200):
        state = rng.normal(0, 10, 16)
        state[6:10] /= np.linalg.norm(state[6:10])
        thrust = order(state, yaw=float(rng.normal(0, 3)))
        assert np.all((thrust >= 0) & (thrust <= 10.35))


def flying():
    estimator = Estimator(ESTIMATOR, np.array([0.0, 0.0, 1.65]), 0.0)
    control = FlightControl(CONFIG, FAILSAFE, estimator, 0.0)
    control.take_off(1.65)
    control.command(0.0, VelocityCommand(0.0, np.zeros(3), 0.0), 1.5)
    return estimator, control


def pass_time(estimator, control, start_s, seconds, fixes=True, imu=True, commands=False):
    for k in range(round(seconds * 240)):
        t = start_s + k / 240
        if k % 12 == 0:
            estimator.tick(t, Fix(t, np.array([0.0, 0.0, 1.65]), 0.0) if fixes else None)
            control.watch(t)
            if commands:
                control.command(t, VelocityCommand(t, np.zeros(3), 0.0), 1.5)
        thrust = control.step(t, Imu(t, np.zeros(3), np.array([0.0, 0.0, 9.81])) if imu else None, 1 / 240)
    return thrust


def test_without_commands_it_holds_and_at_last_lands():
    estimator, control = flying()
    pass_time(estimator, control, 0.0, 1.0)
    assert control.mode == "hold"
    pass_time(estimator, control, 1.0, 15.0)
    assert control.mode == "land"


def test_commands_keep_it_offboard_and_end_a_hold():
    estimator, control = flying()
    pass_time(estimator, control, 0.0, 1.0)
    pass_time(estimator, control, 1.0, 1.0, commands=True)
    assert control.mode == "offboard"


def test_without_fixes_it_sinks_level():
    estimator, control = flying()
    pass_time(estimator, control, 0.0, 1.0, commands=True)
    pass_time(estimator, control, 1.0, 5.2, fixes=False, commands=True)
    assert control.mode == "level"


def test_without_inertial_samples_the_rotors_stop():
    estimator, control = flying()
    pass_time(estimator, control, 0.0, 1.0, commands=True)
    thrust = pass_time(estimator, control, 1.0, 0.6, imu=False, commands=True)
    assert control.mode == "stopped"
    assert not thrust.rotors.any()


def test_an_estimate_that_diverges_stops_the_rotors():
    estimator, control = flying()
    estimator.state[3] = math.nan
    assert not control.step(0.1, Imu(0.1, np.zeros(3), np.array([0.0, 0.0, 9.81])), 1 / 240).rotors.any()
    assert control.mode == "stopped"
