"""Whole flights in PyBullet: determinism, and what happens when parts of the stack die."""

from __future__ import annotations

import signal

import numpy as np
import pytest

from scaloft_fi.mutants.operator import TapError
from scaloft_fi.sim.flight import fly
from scaloft_fi.sim.log import Ending
from scaloft_fi.stack.declaration import PlainWire
from scaloft_fi.stack.reference.messages import MODES
from scaloft_fi.stack.reference.planner import LocalPlan, Planner

pytestmark = pytest.mark.flight


class CutWire(PlainWire):
    """From a moment on carries nothing over one seam, or makes the stage behind it fail."""

    def __init__(self, seam, from_s, error=None):
        self.seam, self.from_s, self.error = seam, from_s, error

    def listens(self, seam):
        return seam == self.seam

    def cross(self, seam, t_s, sample):
        if seam != self.seam or t_s < self.from_s:
            return sample
        if self.error is not None:
            raise self.error
        return None


@pytest.fixture(scope="module")
def flown(config):
    return lambda wire, seed=0: fly(config, config.grid.situation("T0O0W0D0H0"), seed, wire)


@pytest.fixture(scope="module")
def baseline(flown):
    return flown(PlainWire())


def test_a_flight_is_a_function_of_its_situation_and_seed(flown, baseline):
    again, other = flown(PlainWire()), flown(PlainWire(), seed=1)
    assert (again.digest, again.perceived_digest) == (baseline.digest, baseline.perceived_digest)
    assert other.digest != baseline.digest


def test_the_baseline_flies_its_mission_lands_at_home_and_believes_about_what_is_true_and_not_exactly(baseline):
    signals = baseline.signals
    assert (baseline.ending, baseline.stack_error, signals["waypoints_left"][-1]) == (Ending.LANDED, "", 0)
    assert signals["home_m"][-1] < 0.5
    assert signals["y_m"].max() == pytest.approx(7.0, abs=0.3)
    flying = signals["elapsed_s"] > 5.0
    assert 0 < np.abs(signals["est_y_m"][flying] - signals["y_m"][flying]).max() < 0.1


def test_with_the_imu_cut_the_drone_falls(flown):
    log = flown(CutWire("imu", 10.0))
    assert log.ending is Ending.STRUCK
    assert log.struck in ("ground", "wall")
    assert log.duration_s < 13.0
    assert log.signals["vz_mps"].min() < -2.0


def test_without_fixes_the_drone_sinks_level(flown):
    assert MODES.index("level") in flown(CutWire("fix", 10.0)).signals["mode"]


def test_without_commands_the_autopilot_holds_and_then_lands(flown):
    log = flown(CutWire("velcmd", 10.0))
    assert log.ending is Ending.LANDED
    assert MODES.index("hold") in log.signals["mode"]
    assert log.signals["home_m"][-1] > 0.5


def test_a_companion_that_raises_leaves_the_autopilot_flying(flown):
    log = flown(CutWire("goal", 10.0, ZeroDivisionError("division by zero")))
    assert log.stack_error.startswith("companion at 10.000 s: ZeroDivisionError")
    assert log.ending is Ending.LANDED
    assert MODES.index("hold") in log.signals["mode"]


@pytest.mark.parametrize("plan", [None, LocalPlan(np.array([0.0, np.nan, 0.0]), 1.0, blocked=False, expanded=0)])
def test_a_planner_that_gives_no_finite_direction_is_an_error_of_the_companion(flown, monkeypatch, plan):
    monkeypatch.setattr(Planner, "plan", lambda *_: plan)
    assert flown(PlainWire()).stack_error.startswith("companion at 3.700 s: ValueError: the planner returns ")


@pytest.mark.parametrize("error", [KeyboardInterrupt, SystemExit])
def test_an_interrupt_where_ctrl_c_is_ignored_and_an_exit_are_errors_of_the_stack(flown, monkeypatch, error):
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        log = flown(CutWire("goal", 10.0, error("enough")))
    finally:
        signal.signal(signal.SIGINT, before)
    assert log.stack_error == f"companion at 10.000 s: {error.__name__}: enough"
    assert log.ending is Ending.LANDED


def test_ctrl_c_of_a_user_ends_a_flight(flown):
    with pytest.raises(KeyboardInterrupt):
        flown(CutWire("goal", 1.0, KeyboardInterrupt()))


def test_an_autopilot_that_raises_stops_the_rotors(flown):
    log = flown(CutWire("imu", 10.0, ValueError("no attitude")))
    assert log.stack_error.startswith("autopilot at 10.000 s")
    assert (log.ending, log.struck) == (Ending.STRUCK, "ground")


@pytest.mark.parametrize("error", [TapError("broken tap"), MemoryError()])
def test_a_fault_that_cannot_be_injected_and_a_lack_of_memory_are_the_harness_own(flown, error):
    with pytest.raises(type(error)):
        flown(CutWire("depth", 1.0, error))
