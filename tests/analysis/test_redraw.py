from __future__ import annotations

from builders import outcome, pool

from scaloft_fi.analysis.roster import Ratio
from scaloft_fi.analysis.score import REDRAWS, Redraw, redraw
from scaloft_fi.judge.outcome import BASELINE

KEYS = ["T0O0W0D0H0", "T0O0W0D0H1", "T0O0W0D1H0", "T0O0W0D1H1"]


def test_a_drone_that_never_violates_is_never_called_detected() -> None:
    assert redraw(pool(*KEYS, seeds=20), 3, 0.01) == Redraw(3, Ratio(0, REDRAWS), Ratio(0, REDRAWS))


def test_there_are_no_redraws_below_twenty_flights_or_without_ten_to_spare() -> None:
    assert redraw(pool(*KEYS, seeds=19), 1, 0.01) == Redraw()
    assert redraw(pool(*KEYS, seeds=20), 11, 0.01) == Redraw()
    assert redraw([], 1, 0.01) == Redraw()
    uneven = [*pool(KEYS[0], seeds=30), *pool(KEYS[1], seeds=15)]
    assert redraw(uneven, 1, 0.01) == Redraw()
    # a situation without any pool is left out, as it is where no mutant infects
    assert redraw([*pool(KEYS[0], seeds=30), *pool(KEYS[1], seeds=1)], 1, 0.01).safety == Ratio(0, REDRAWS)


def test_seeds_that_violate_everywhere_at_once_are_called_detected_as_often_as_they_are_drawn_alone() -> None:
    """Two seeds of forty violate in all four situations: a redraw of one of them beside ten green ones is detected."""
    flights = [
        outcome(BASELINE, key, seed, violated={"SR1": 9.0} if seed < 2 else {}) for key in KEYS for seed in range(40)
    ]
    found = redraw(flights, 1, 0.01, redraws=1000)
    assert 25 <= found.safety.part <= 75  # 2 of 40, as the other is seldom among the ten
    assert found.operability.part == 0
    assert redraw(flights, 1, 0.01, redraws=1000) == found
