"""Shrinking: what is not needed goes back to its benign value."""

from __future__ import annotations

from pathlib import Path

import pytest

from scaloft_fi.analysis.seeking import shrunk
from scaloft_fi.sim.grids import load_grid

GRID = load_grid(Path(__file__).parents[2] / "sim", "search")


def shrink(key: str, rule):
    """The shrunk key, and what was asked on the way."""
    asked: list[str] = []

    def shows(situations, every):
        asked.extend(one.key for one in situations)
        return [rule(one) for one in situations]

    return shrunk(GRID.situation(key), GRID, shows).key, asked


def test_what_is_not_needed_is_reset():
    found, asked = shrink("T1O1W1D2H1Cs=0.9Ls=3Ox=0.5Vy=2Ba=0.3", lambda one: one["H"] == 1)
    assert found == "T0O0W0D0H1"
    assert len(asked) < 20


def test_what_is_needed_together_stays_together():
    found, _ = shrink("T1O1W1D0H1Ox=0.5Vy=2", lambda one: one["T"] + one["W"] >= 1 and one["O"] == 1)
    assert found in ("T1O1W0D0H0", "T0O1W1D0H0")


def test_numbers_of_an_axis_go_with_the_value_that_they_need():
    found, asked = shrink("T0O1W0D0H0Ox=0.5Oy=3", lambda _one: True)
    assert found == "T0O0W0D0H0"
    assert all("O0" not in key or "Ox" not in key for key in asked)


def test_numbers_are_halved_towards_the_benign_value_while_the_fault_shows():
    found, _ = shrink("T0O0W0D0H0Cs=1.2", lambda one: dict(one.numbers).get("Cs", 0.5) >= 0.65)
    assert found == "T0O0W0D0H0Cs=0.7"  # by halves to 0.68, rounded to one digit, away from the benign 0.5


def test_a_number_that_stays_is_rounded_where_the_fault_still_shows():
    found, _ = shrink("T0O0W0D0H0Cs=0.66", lambda one: 0.6 < dict(one.numbers).get("Cs", 0.5) < 0.67)
    assert found == "T0O0W0D0H0Cs=0.66"


def test_shrinking_ends_by_trying_each_axis_at_its_benign_value():
    """Ry may go only once Cs has gone down: the rounds before the halving have tried it in vain."""

    def rule(one):
        numbers = dict(one.numbers)
        return numbers.get("Cs", 0.5) <= 0.9 or "Ry" in numbers

    def needs_speed(one):
        return rule(one) and dict(one.numbers).get("Cs", 0.5) >= 0.7

    found, _ = shrink("T0O0W0D0H0Cs=1.2Ry=0.002", needs_speed)
    assert "Ry" not in found


@pytest.mark.parametrize("key", ["T0O0W0D0H0", "T0O0W0D0H1"])
def test_what_cannot_be_shrunk_is_as_it_was(key):
    found, _ = shrink(key, lambda one: one.key == key)
    assert found == key


def test_a_shrunk_situation_shows_the_fault_with_every_seed():
    def shows(situations, every):
        return [not every or one["H"] == 1 for one in situations]

    found = shrunk(GRID.situation("T1O0W0D0H1"), GRID, shows)
    assert (found["T"], found["H"]) == (0, 1)
