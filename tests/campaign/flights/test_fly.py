from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from scaloft_fi.campaign.flights.fly import facts
from scaloft_fi.campaign.flights.share import as_baseline
from scaloft_fi.judge.outcome import Outcome, Subject
from scaloft_fi.mutants.operator import Facts
from scaloft_fi.mutants.wire import SeamCount
from scaloft_fi.sim.load import load
from scaloft_fi.sim.mine import Mine

SIM = Path(__file__).parents[3] / "sim"


def of(**overrides: Any) -> Facts:
    config = load(SIM, {path.replace("__", "."): value for path, value in overrides.items()})
    return facts(config.scenario(config.grid.situation("T0O0W0D0H1")), config.stack.parameters)


def test_the_facts_are_of_the_study() -> None:
    config = load(SIM)
    scenario = config.scenario(config.grid.situation("T0O0W0D0H1"))
    found = facts(scenario, config.stack.parameters)
    assert (found.duration_s, found.sighting_s) == (scenario.nominal_s, scenario.sighting_s)
    assert found.settings == config.stack.parameters


def test_the_facts_follow_vehicle_sensors_and_mission() -> None:
    found = of(
        sensors__depth__fov_deg=75.0,
        sensors__imu__rate_sigma_radps=0.5,
        world__mission__cruise_mps=0.7,
        world__mission__slow_mps=0.1,
    )
    assert found.gyro_sigma_radps == 0.5
    assert found.view_rad == pytest.approx(math.radians(75.0))
    assert (found.cruise_mps, found.slow_mps) == (0.7, 0.1)


def test_the_wall_is_on_the_right_of_the_first_leg() -> None:
    there = of()
    assert there.wall_m == pytest.approx((1.5, 3.5), abs=0.01)
    assert there.inward == pytest.approx((-1.0, 0.0), abs=0.01)
    assert there.bearing_rad == pytest.approx(math.pi / 2, abs=0.01)


def test_the_half_width_is_half_the_width_of_the_hull() -> None:
    config = load(SIM)
    scenario = config.scenario(config.grid.situation("T0O0W0D0H0"))
    wide = replace(scenario, vehicle=replace(config.vehicle, hull_m=(0.5, 0.9, 0.1)))
    assert facts(wide, {}).half_width_m == 0.45


def test_without_a_wall_the_first_leg_gives_the_direction(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Mine, "wall_towards", lambda *_: None)
    found = of()
    assert found.wall_m is None
    assert found.inward == (0.0, 0.0)
    assert found.bearing_rad == pytest.approx(math.pi / 2)


def test_what_never_differs_has_its_baselines_outcome_but_for_what_it_carried() -> None:
    baseline = Outcome(Subject("baseline"), "D0", 1, ending="landed", digest="d", realised=(("D", True),), track=b"t")
    subject = Subject("LATE-human@3s", "LATE", "human", "3s")
    assert as_baseline(baseline, subject, {"person": SeamCount(7, 0, None)}) == Outcome(
        subject, "D0", 1, ending="landed", carried=7, digest="d", track=b"t"
    )
