from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from scaloft_fi.hazop.matrix import Cell, CellStatus, Expected, Fault, Magnitude

LADDER = Magnitude("delay_s", "s", (0.5, 3.0), 3.0)


@pytest.mark.parametrize(
    ("magnitude", "rung", "text", "value"),
    [
        (LADDER, 0.5, "0.5s", 0.5),
        (Magnitude("delay_s", "ms", (5.0,), 5.0, 0.001), 5.0, "5ms", 0.005),
        (Magnitude("amount", "EV", (2.0,), 2.0, -1.0), 2.0, "2EV", -2.0),
        (Magnitude("share", "%", (70.0,), 70.0, 0.01), 70.0, "70%", 0.7),
        (Magnitude("hold_s", "s", (math.inf,), math.inf), math.inf, "infs", math.inf),
        (Magnitude("axis", "", ("x", "yaw"), "yaw"), "yaw", "yaw", "yaw"),
        (Magnitude("index", "", (1.0,), 1.0), 1.0, "1", 1.0),
    ],
)
def test_a_magnitude_has_a_text_for_the_id_and_a_value_for_the_operator(
    magnitude: Magnitude, rung: float | str, text: str, value: float | str
) -> None:
    assert magnitude.text(rung) == text
    assert magnitude.value(rung) == value


@given(st.integers(0, 10_000))
def test_a_share_in_percent_is_the_nearest_decimal_fraction(percent: int) -> None:
    magnitude = Magnitude("share", "%", (1.0,), 1.0, 0.01)
    assert magnitude.value(float(percent)) == percent / 100


def test_the_place_is_not_part_of_what_a_fault_is() -> None:
    assert Fault("person", "drop", place="a:1") == Fault("person", "drop", place="b:2")
    assert Magnitude("delay_s", "s", (1.0,), 1.0, place="a:1") == Magnitude("delay_s", "s", (1.0,), 1.0)


def test_an_expectation_without_magnitudes_speaks_of_all_and_else_of_those_named() -> None:
    every = Fault("failsafe", "delay", {}, LADDER, expected=Expected("never fires"))
    one = Fault("failsafe", "delay", {}, LADDER, expected=Expected("too short", (0.5,)))
    assert every.expects(0.5) == every.expects(3.0) == every.expected
    assert one.expects(0.5) == one.expected
    assert one.expects(3.0) is None


def test_a_fault_that_strikes_once_is_shifted_by_shares_of_its_time() -> None:
    cell = Cell("UNINTENDED", "battery", CellStatus.CREDIBLE)
    fault = Fault("battery", "depleted_pulse", {"at_s": 20.0}, phases=True)
    assert cell.mutant_ids(fault, None) == tuple("UNINTENDED-battery" + tail for tail in ("", "#5s", "#10s", "#15s"))


def test_events_stand_after_the_times_and_those_that_cannot_come_are_left_out() -> None:
    cell, events = Cell("UNINTENDED", "battery", CellStatus.CREDIBLE), {"sight": "", "light": "nothing changes it"}
    fault = Fault("battery", "depleted_pulse", {"at_s": 20.0}, phases=True, events=events)
    assert cell.mutant_ids(fault, None)[3:] == ("UNINTENDED-battery#15s", "UNINTENDED-battery#sight")


def test_a_fault_without_phases_has_one_id_for_each_magnitude() -> None:
    cell = Cell("LATE", "human", CellStatus.CREDIBLE)
    assert [cell.mutant_ids(Fault("person", "delay", {}, LADDER), rung) for rung in LADDER.ladder] == [
        ("LATE-human@0.5s",),
        ("LATE-human@3s",),
    ]
