from __future__ import annotations

from pathlib import Path

import pytest

from scaloft_fi.judge.bounds import ANY, TRUTH, cap_of, ranges_of, within_rock, without
from scaloft_fi.sim.grids import load_grid
from scaloft_fi.sim.happenings import HAPPENINGS
from scaloft_fi.sim.log import SIGNALS, TRUTH_NAMES, clearance_name
from scaloft_fi.stack.reference.messages import BELIEFS

WORLD = load_grid(Path(__file__).parents[2] / "sim").world()


def test_every_range_is_of_a_signal_and_agrees_with_its_cap() -> None:
    assert TRUTH.keys() <= {*TRUTH_NAMES, *SIGNALS, *HAPPENINGS["dust"].signals}
    for name, spans in TRUTH.items():
        cap = cap_of(name)
        assert cap is None or spans[0][1] == cap.most_m, name


def test_bodies_beliefs_and_marks_have_their_ranges() -> None:
    ranges = ranges_of(WORLD, BELIEFS, [clearance_name("bar"), "mode", "nothing_known", "clearance_m"])
    assert ranges[clearance_name("bar")] == ranges["clearance_m"] == ((-float("inf"), 1.0),)
    assert ranges["mode"][0][0] == 0.0
    assert ranges["nothing_known"] == ANY


def test_the_rock_bounds_the_position_and_a_study_has_its_person() -> None:
    rock = within_rock(WORLD)
    assert -6.1 < rock["x_m"][0][0] < -5.4
    assert rock["z_m"] == (pytest.approx((0.0, 2.7)),)
    assert without(WORLD) == {}
