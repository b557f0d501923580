"""What the page of the testbed measures at the seams."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from experiments.testbed import delay, second_script, touched
from scaloft_fi.outside.border import Goal
from scaloft_fi.stack.messages import Bumper, Detections, Person
from scaloft_fi.stack.reference.messages import SpeedLimit

pytestmark = pytest.mark.release
"""A page of the past is recomputed before a release."""


def crossing(seam: str, t_s: float, sent: Any, delivered: Any = None) -> SimpleNamespace:
    return SimpleNamespace(seam=seam, t_s=t_s, wall_s=t_s / 2, sent=sent, delivered=delivered)


def flight(*crossings: SimpleNamespace) -> Any:
    return SimpleNamespace(crossings=crossings)


def test_the_delay_is_from_the_detectors_first_person_to_the_first_slow_order():
    seen, late = Detections(1.0, (Person("person", 0.9, 0.0, 3.0),)), Detections(4.0, ())
    cruise, slow = SpeedLimit(0.0, 0.5, "euclidean"), SpeedLimit(4.1, 0.2, "euclidean")
    one = flight(
        crossing("speed", 0.5, cruise, cruise),
        crossing("person", 0.8, late, late),
        crossing("person", 1.0, seen),
        crossing("person", 4.0, None, seen),
        crossing("speed", 4.0, slow, slow),
        crossing("speed", 5.0, slow, slow),
    )
    assert delay(one) == 3.0
    assert delay(flight(crossing("person", 1.0, seen, seen))) is None


def test_the_second_script_begins_after_the_longest_pause_of_goals():
    goal = Goal((0.0, 7.0, 1.65))
    times = [1.0, 1.05, 1.1, 3.7, 3.75, 4.5]
    assert second_script(flight(*(crossing("destination", t_s, goal, goal) for t_s in times))) == 3.7
    assert second_script(flight(*(crossing("destination", t_s, goal, goal) for t_s in times[:3]))) is None


def test_a_contact_counts_once_while_it_lasts():
    times = [20.0, 20.05, 20.1, 40.0, 40.05]
    told = [crossing("contact", t_s, None, Bumper(t_s, hull=True, gear=False)) for t_s in times]
    assert touched(flight(crossing("contact", 1.0, None, Bumper(1.0, hull=False, gear=True)), *told)) == [20.0, 40.0]
