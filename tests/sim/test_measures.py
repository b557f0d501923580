"""Signals that a study asks for."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from scaloft_fi.document import load
from scaloft_fi.errors import InputError
from scaloft_fi.sim.log import SIGNALS, FlightLog, signal, signal_names, truth_signals
from scaloft_fi.sim.world import read_world
from scaloft_fi.study import Study
from tests.sim.conftest import SIM

OURS = {name: SIGNALS[name] for name in ("mass_kg", "takeoff_charge")}
"""Those of the package."""


@pytest.fixture(autouse=True)
def declared(monkeypatch):
    monkeypatch.setattr(SIGNALS, "_entries", {})
    signal("height_m", "m", "height over the floor", most=10.0)(lambda _scenario: lambda state: float(state[2]))


def world_with(tmp_path, line):
    text = (SIM / "world.yaml").read_text(encoding="utf-8")
    (tmp_path / "world.yaml").write_text(f"{line}\n{text}", encoding="utf-8")
    return read_world(load(tmp_path / "world.yaml"))


def test_a_signal_is_recorded_where_the_world_asks_for_it_and_nowhere_else(tmp_path):
    assert world_with(tmp_path, "signals: [height_m]").signals == ("height_m",)
    assert world_with(tmp_path, "").signals == ()
    assert "height_m" in signal_names(["wall"], (), ["height_m"])
    assert "height_m" not in [one.name for one in truth_signals(["wall"])]


def test_mass_and_charge_are_those_of_the_scenario():
    study = Study.open(SIM.parent)
    heavy = study.scenario(study.grid.situations[0])
    heavy = replace(heavy, vehicle=replace(heavy.vehicle, mass_kg=2.25))
    state = np.zeros(13)
    assert OURS["mass_kg"].make(heavy)(state) == 2.25
    assert OURS["takeoff_charge"].make(heavy)(state) == heavy.sensors.battery.charge


def test_its_measure_is_made_from_the_scenario_and_reads_the_true_state():
    measure = SIGNALS["height_m"].make(None)
    assert measure(np.array([0.0, 0.0, 1.5] + [0.0] * 10)) == 1.5


@pytest.mark.parametrize(
    ("line", "sentence"),
    [
        ("signals: [heigth_m]", "did you mean 'height_m'"),
        ("signals: [height_m, height_m]", "signal 'height_m' is recorded already"),
    ],
)
def test_a_name_that_nobody_declared_or_that_comes_twice_is_refused(tmp_path, line, sentence):
    with pytest.raises(InputError) as caught:
        world_with(tmp_path, line)
    assert sentence in str(caught.value)
    assert "world.yaml:1" in str(caught.value)


def test_a_declared_signal_enters_the_digest():
    def log(height_m):
        return FlightLog(
            signals={"elapsed_s": np.array([0.0]), "height_m": np.array([height_m])},
            ending="landed",
            struck="",
            struck_at_s=0.0,
            stack_error="",
            counts={},
            t_max_s=1.0,
        )

    assert log(1.0).digest != log(2.0).digest
