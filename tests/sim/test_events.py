from __future__ import annotations

import numpy as np
import pytest

from scaloft_fi.mutants.wire import SeamCount
from scaloft_fi.sim.events import events_of
from scaloft_fi.stack.declaration import Belief, Mark

ELAPSED_S = np.arange(6) * 0.05


def events(mark, values, **facts):
    belief = Belief("hunch", "", "a hunch", mark=mark)
    rest = {"counts": {}, "struck": "", "struck_at_s": 0.0, "error": ""} | facts
    return [(e.t_s, e.kind, e.text) for e in events_of(ELAPSED_S, [belief], {"hunch": np.array(values)}, **rest)]


@pytest.mark.parametrize(
    ("mark", "values", "marked"),
    [
        (None, [0, 1, 0, 1, 0, 1], []),
        (Mark("seen", "sees"), [0, 1, 1, 0, 1, 0], [0.05, 0.2]),
        (Mark("seen", "sees"), [1, 1, 1, 0, 1, 0], [0.0, 0.2]),
        (Mark("seen", "sees", first=True), [0, 1, 0, 0, 1, 0], [0.05]),
        (Mark("seen", "sees"), [0.5, 0.5, 0.51, 0, 0, 0], [0.1]),
    ],
)
def test_a_marked_belief_marks_each_rise_or_the_first(mark, values, marked):
    assert [t_s for t_s, _, _ in events(mark, values)] == pytest.approx(marked)


def test_a_belief_with_named_values_marks_each_change_with_the_name():
    mark = Mark("mode", "now {}", values=("idle", "climb", "land"))
    assert events(mark, [0, 1, 1, 2, 2, 0]) == [
        (pytest.approx(0.05), "mode", "now climb"),
        (pytest.approx(0.15), "mode", "now land"),
        (pytest.approx(0.25), "mode", "now idle"),
    ]


def test_infection_contact_and_error_stand_in_the_order_of_time():
    facts = {
        "counts": {"imu": SeamCount(9, 2, 0.12), "depth": SeamCount(3, 1, 0.02), "fix": SeamCount(4, 0, None)},
        "struck": "wall",
        "struck_at_s": 0.07,
        "error": "ValueError at 0.200 s: odd",
    }
    assert [(t_s, kind) for t_s, kind, _ in events(Mark("seen", "sees"), [0, 1, 1, 1, 1, 1], **facts)] == [
        (0.02, "infection"),
        (pytest.approx(0.05), "seen"),
        (0.07, "contact"),
        (0.2, "error"),
    ]
