"""How far a search came with a mutant."""

from __future__ import annotations

from dataclasses import replace

import pytest
from builders import outcome

from scaloft_fi.analysis.seeking import WORST, Effort, effort_of
from scaloft_fi.judge.outcome import Outcome

KEYS = ("T0O0W0D0H0", "T0O0W0D0H1", "T0O0W0D1H0", "T0O0W0D1H1", "T0O0W1D0H0", "T0O0W1D0H1")


def flown(subject: str, situation: str, rho: float = 0.3, **more: object) -> Outcome:
    one = replace(outcome(subject), situation=situation, **more)
    return replace(one, readings=tuple(replace(reading, rho=rho) for reading in one.readings))


def test_a_fault_stops_at_a_stage_in_each_situation():
    baselines = {key: flown("baseline", key, -0.3 if key == KEYS[5] else 0.3, digest="b") for key in KEYS}
    flights = [
        flown("LATE-human@3s", KEYS[0], carried=0, altered=0, digest="b"),
        flown("LATE-human@3s", KEYS[1], carried=9, altered=0, digest="b"),
        flown("LATE-human@3s", KEYS[2], carried=9, altered=4, digest="b"),
        flown("LATE-human@3s", KEYS[3], 0.06, carried=9, altered=4, digest="m"),
        flown("LATE-human@3s", KEYS[4], -0.15, carried=9, altered=4, digest="m"),
        flown("LATE-human@3s", KEYS[5], -9.0, carried=9, altered=4, digest="m"),  # its baseline holds nothing
    ]
    effort = effort_of(flights, baselines)
    assert (effort.situations, effort.reached, effort.infected, effort.diverged, effort.showed) == (5, 4, 3, 2, 1)
    assert (effort.nearest, effort.requirement, effort.situation) == (pytest.approx(-0.5), "SR1", KEYS[4])
    assert effort_of(flights[:4], baselines).nearest == pytest.approx(0.2)


def test_what_changes_no_sample_comes_nowhere_near_anything():
    flights = [flown("LATE-human@3s", KEYS[0], -1.0, altered=0)]
    effort = effort_of(flights, {KEYS[0]: flown("baseline", KEYS[0])})
    assert (effort.situations, effort.nearest, effort.requirement) == (1, WORST, "")


def test_flights_that_say_nothing_are_left_out():
    invalid = flown("LATE-human@3s", KEYS[0], invalid="the worker died")
    assert effort_of([invalid], {KEYS[0]: flown("baseline", KEYS[0])}) == Effort()
    assert effort_of([flown("LATE-human@3s", KEYS[1])], {}) == Effort()
