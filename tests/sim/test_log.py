from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from scaloft_fi.sim.log import NEVER_S, Ending, FlightLog, Recorder


def flight(x=(0.0, 1.0), told=(0.0, 0.0), **changes):
    signals = {"elapsed_s": np.array([0.0, 0.05]), "x_m": np.array(x), "told_person": np.array(told)}
    values = {
        "ending": Ending.LANDED,
        "struck": "",
        "struck_at_s": NEVER_S,
        "stack_error": "",
        "counts": {},
        "t_max_s": 80,
        "beliefs": ("told_person",),
    }
    return FlightLog(signals=signals, **{**values, **changes})


def test_equal_flights_have_equal_digests():
    assert flight().digest == flight().digest
    assert flight().perceived_digest == flight().perceived_digest


@pytest.mark.parametrize(
    "other",
    [
        flight(x=(0.0, np.nextafter(1.0, 2.0))),
        flight(x=(-0.0, 1.0)),
        flight(ending=Ending.STRUCK),
        flight(struck="bar"),
    ],
)
def test_the_digest_sees_every_bit_of_the_truth(other):
    assert other.digest != flight().digest
    assert other.perceived_digest == flight().perceived_digest


def test_what_the_stack_believed_has_a_digest_of_its_own():
    other = flight(told=(0.0, 1.0))
    assert other.digest == flight().digest
    assert other.perceived_digest != flight().perceived_digest


def test_the_digest_does_not_depend_on_the_order_of_signals():
    log = flight()
    turned = FlightLog(
        signals=dict(reversed(log.signals.items())),
        ending=log.ending,
        struck="",
        struck_at_s=math.nan,
        stack_error="",
        counts={},
        t_max_s=80,
        beliefs=log.beliefs,
    )
    assert turned.digest == log.digest


@given(st.integers(1, 700))
def test_a_recorder_keeps_every_row(rows):
    recorder = Recorder(["a", "b"])
    for i in range(rows):
        recorder.add([i, -i])
    assert len(recorder) == rows
    signals = recorder.signals()
    assert np.array_equal(signals["a"], np.arange(rows))
    assert np.array_equal(signals["b"], -np.arange(rows))


def test_recorded_signals_cannot_be_written():
    recorder = Recorder(["a"])
    recorder.add([1.0])
    with pytest.raises(ValueError, match="read-only"):
        recorder.signals()["a"][0] = 2


def test_a_time_is_found_at_or_before():
    assert [flight().at(t) for t in (-1, 0, 0.049, 0.05, 9)] == [0, 0, 0, 1, 1]


def test_the_duration_is_the_last_samples_time():
    assert flight().duration_s == 0.05


def test_every_ending_has_a_sentence():
    assert all(ending.sentence for ending in Ending)
