"""Whole flights in PyBullet: determinism, and what happens when parts of the stack die."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from scaloft_fi.errors import InputError
from scaloft_fi.mutants.wire import TapError
from scaloft_fi.sim.flight import fly
from scaloft_fi.sim.load import load
from scaloft_fi.sim.log import Ending
from scaloft_fi.stack.declaration import PlainWire
from scaloft_fi.stack.reference.messages import MODES

pytestmark = pytest.mark.flight
SIM = Path(__file__).parents[2] / "sim"


class CutWire(PlainWire):
    """Carries nothing over one seam from a moment on."""

    def __init__(self, seam, from_s):
        self.seam, self.from_s = seam, from_s

    def listens(self, seam):
        return seam == self.seam

    def cross(self, seam, t_s, sample):
        return None if seam == self.seam and t_s >= self.from_s else sample


class BreakingWire(CutWire):
    """Makes the stage behind one seam fail from a moment on."""

    def __init__(self, seam, from_s, error):
        super().__init__(seam, from_s)
        self.error = error

    def cross(self, seam, t_s, sample):
        if seam == self.seam and t_s >= self.from_s:
            raise self.error
        return sample


def flown(config, wire, key="T0O0W0D0H0", seed=0):
    return fly(config, config.grid.situation(key), seed, wire)


@pytest.fixture(scope="module")
def baseline(config):
    return flown(config, PlainWire())


def test_a_flight_is_a_function_of_its_situation_and_seed(config, baseline):
    again, other = flown(config, PlainWire()), flown(config, PlainWire(), seed=1)
    assert (again.digest, again.perceived_digest) == (baseline.digest, baseline.perceived_digest)
    assert other.digest != baseline.digest


def test_the_baseline_flies_its_mission_and_lands_at_home(baseline):
    assert baseline.ending is Ending.LANDED
    assert baseline.stack_error == ""
    assert baseline.signals["waypoints_left"][-1] == 0
    assert baseline.signals["home_m"][-1] < 0.5
    assert baseline.signals["y_m"].max() == pytest.approx(7.0, abs=0.3)


def test_the_stack_believes_about_what_is_true_and_not_exactly(baseline):
    flying = baseline.signals["elapsed_s"] > 5.0
    error = baseline.signals["est_y_m"][flying] - baseline.signals["y_m"][flying]
    assert 0 < np.abs(error).max() < 0.1


def test_with_the_imu_cut_the_drone_falls(config):
    log = flown(config, CutWire("imu", 10.0))
    assert log.ending is Ending.STRUCK
    assert log.struck in ("ground", "wall")
    assert log.duration_s < 13.0
    assert log.signals["vz_mps"].min() < -2.0


def test_without_fixes_the_drone_sinks_level(config):
    log = flown(config, CutWire("fix", 10.0))
    assert MODES.index("level") in log.signals["mode"]


def test_without_commands_the_autopilot_holds_and_then_lands(config):
    log = flown(config, CutWire("velcmd", 10.0))
    assert log.ending is Ending.LANDED
    assert MODES.index("hold") in log.signals["mode"]
    assert log.signals["home_m"][-1] > 0.5


def test_a_companion_that_raises_leaves_the_autopilot_flying(config):
    log = flown(config, BreakingWire("goal", 10.0, ZeroDivisionError("division by zero")))
    assert log.stack_error.startswith("companion at 10.000 s: ZeroDivisionError")
    assert log.ending is Ending.LANDED
    assert MODES.index("hold") in log.signals["mode"]


def test_an_autopilot_that_raises_stops_the_rotors(config):
    log = flown(config, BreakingWire("imu", 10.0, ValueError("no attitude")))
    assert log.stack_error.startswith("autopilot at 10.000 s")
    assert log.ending is Ending.STRUCK
    assert log.struck == "ground"


@pytest.mark.parametrize("error", [TapError("broken tap"), MemoryError()])
def test_a_fault_that_cannot_be_injected_and_a_lack_of_memory_are_the_harness_own(config, error):
    with pytest.raises(type(error)):
        flown(config, BreakingWire("depth", 1.0, error))


def test_a_setting_of_the_stack_that_is_unknown_is_named(tmp_path):
    for file in SIM.glob("*.yaml"):
        (tmp_path / file.name).write_text(file.read_text().replace("goal_radius_m:", "gaol_radius_m:"))
    config = load(tmp_path)
    with pytest.raises(
        InputError, match=r"stack.yaml:\d+: unknown key 'gaol_radius_m' in mission; did you mean 'goal_radius_m'"
    ):
        flown(config, PlainWire())
