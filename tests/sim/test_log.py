"""The log of a flight, its digests, its signals, and those that a study asks for."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from scaloft_fi.document import load
from scaloft_fi.errors import InputError
from scaloft_fi.sim import log as logs
from scaloft_fi.sim.log import (
    SIGNALS,
    Ending,
    FlightLog,
    Recorder,
    Side,
    SignalError,
    signal,
    signal_names,
    truth_signals,
)
from scaloft_fi.sim.world import read_world
from scaloft_fi.stack.reference.messages import BELIEFS
from tests.sim.conftest import SIM

OURS = {name: SIGNALS[name] for name in ("mass_kg", "takeoff_charge")}
"""Those of the package."""


def flight(x=(0.0, 1.0), told=(0.0, 0.0), ending=Ending.LANDED, struck=""):
    signals = {"elapsed_s": np.array([0.0, 0.05]), "x_m": np.array(x), "told_person": np.array(told)}
    return FlightLog(signals, ending, struck, math.nan, "", {}, 80, beliefs=("told_person",))


@pytest.mark.parametrize(
    ("other", "same_truth", "same_beliefs"),
    [
        (flight(), True, True),
        (flight(x=(0.0, np.nextafter(1.0, 2.0))), False, True),
        (flight(x=(-0.0, 1.0)), False, True),
        (flight(ending=Ending.STRUCK), False, True),
        (flight(struck="bar"), False, True),
        (flight(told=(0.0, 1.0)), True, False),
        (replace(flight(), signals=dict(reversed(flight().signals.items()))), True, True),
        (replace(flight(), signals={**flight().signals, "height_m": np.zeros(2)}), False, True),
    ],
)
def test_the_digest_sees_every_bit_of_the_truth_and_what_was_believed_has_one_of_its_own(
    other, same_truth, same_beliefs
):
    assert (other.digest == flight().digest) is same_truth
    assert (other.perceived_digest == flight().perceived_digest) is same_beliefs


@given(st.integers(1, 700))
def test_a_recorder_keeps_every_row_and_they_cannot_be_written(rows):
    recorder = Recorder(["a", "b"])
    for i in range(rows):
        recorder.add([i, -i])
    signals = recorder.signals()
    assert len(recorder) == rows
    assert np.array_equal(signals["a"], np.arange(rows))
    assert np.array_equal(signals["b"], -np.arange(rows))
    with pytest.raises(ValueError, match="read-only"):
        signals["a"][0] = 2


def test_a_time_is_found_at_or_before_and_every_ending_has_a_sentence():
    assert [flight().at(t) for t in (-1, 0, 0.049, 0.05, 9)] == [0, 0, 0, 1, 1]
    assert flight().duration_s == 0.05
    assert [ending.sentence.split()[0] for ending in Ending] == ["touched", "struck", "was"]


def test_names_of_truth_and_belief_are_unique_and_carry_their_unit(config):
    truth, beliefs = truth_signals(config.world.surfaces), logs.belief_signals(BELIEFS)
    names = signal_names(config.world.surfaces, BELIEFS)
    assert len(set(names)) == len(names) == len(truth) + len(beliefs)
    assert names[: len(truth)][-5:] == tuple(f"clearance_{name}_m" for name in config.world.surfaces)
    suffixes = {"s": "_s", "m": "_m", "m/s": "_mps", "rad": "_rad"}
    assert all(one.meaning and (not one.unit or one.name.endswith(suffixes[one.unit])) for one in truth)
    assert [{one.side for one in those} for those in (truth, beliefs)] == [{Side.TRUTH}, {Side.PERCEIVED}]


@pytest.fixture
def declared(monkeypatch):
    monkeypatch.setattr(SIGNALS, "_entries", {})
    signal("height_m", "m", "height over the floor", most=10.0)(lambda _scenario: lambda state: float(state[2]))


def world_with(tmp_path, line):
    (tmp_path / "world.yaml").write_text(f"{line}\n{(SIM / 'world.yaml').read_text()}")
    return read_world(load(tmp_path / "world.yaml"))


def test_a_signal_is_recorded_where_the_world_asks_for_it_and_nowhere_else(declared, tmp_path):
    assert world_with(tmp_path, "signals: [height_m]").signals == ("height_m",)
    assert world_with(tmp_path, "").signals == ()
    assert "height_m" in signal_names(["wall"], (), ["height_m"])
    assert "height_m" not in [one.name for one in truth_signals(["wall"])]
    assert SIGNALS["height_m"].make(None)(np.array([0.0, 0.0, 1.5] + [0.0] * 10)) == 1.5


@pytest.mark.parametrize("value", [1, 1.5, np.float32(1.5), np.bool_(True), -0.0])
def test_a_measure_that_is_a_number_keeps_its_bits(declared, value):
    made = replace(SIGNALS["height_m"], make=lambda _scenario: lambda _state: value)
    assert np.float64(made.measure(None)(np.zeros(13))).tobytes() == np.float64(value).tobytes()


@pytest.mark.parametrize("value", ["1.0", None])
def test_a_measure_that_is_no_number_is_refused_with_its_signal_and_module(declared, value):
    made = replace(SIGNALS["height_m"], make=lambda _scenario: lambda _state: value)
    with pytest.raises(SignalError, match=f"^signal height_m is {value!r}, which is no number$") as refused:
        made.measure(None)(np.zeros(13))
    assert refused.value.declared_in == __name__


@pytest.mark.parametrize("value", [10.5, math.inf, -math.inf, math.nan])
def test_a_sample_beyond_what_its_signal_declares_is_refused_with_its_time(declared, value):
    SIGNALS["height_m"].hold(np.array([-3.0, 0.0, 10.0]))
    sentence = f"signal height_m is {value:g} at 0.10 s, and declares a finite number of at most 10 m"
    with pytest.raises(SignalError, match=f"^{sentence}$"):
        SIGNALS["height_m"].hold(np.array([-3.0, 0.0, value, 50.0]))


def test_mass_and_charge_are_those_of_the_scenario(scenario):
    heavy = scenario("T0O0W0D0H0")
    heavy = replace(heavy, vehicle=replace(heavy.vehicle, mass_kg=2.25))
    assert OURS["mass_kg"].make(heavy)(np.zeros(13)) == 2.25
    assert OURS["takeoff_charge"].make(heavy)(np.zeros(13)) == heavy.sensors.battery.charge


@pytest.mark.parametrize(
    ("line", "sentence"),
    [
        ("signals: [heigth_m]", "did you mean 'height_m'"),
        ("signals: [height_m, height_m]", "signal 'height_m' is recorded already"),
    ],
)
def test_a_name_that_nobody_declared_or_that_comes_twice_is_refused(declared, tmp_path, line, sentence):
    with pytest.raises(InputError, match=rf"world.yaml:1.*{sentence}"):
        world_with(tmp_path, line)
