"""Windows that open at the occurrences of an event."""

from __future__ import annotations

import copy
import math

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from scaloft_fi.mutants.operator import Occurrences, TapContext, Windows

OCCURS = st.sets(st.integers(0, 400), max_size=30).map(sorted)
RATES = st.sampled_from([20, 240])


def opened(windows: Windows, event: Occurrences, occurs: list[int], rate_hz: int) -> dict[int, int]:
    """By poll at which a window is open its number; the event occurs at ticks (20 Hz), before the tick's polls."""
    found, per_tick = {}, rate_hz // 20
    for tick in range(450):
        if tick in occurs:
            event.occur(tick / 20)
        for poll in range(tick * per_tick, (tick + 1) * per_tick):
            number = windows.number(poll / rate_hz)
            if number is not None:
                found[poll] = number
    return found


@given(OCCURS, st.integers(1, 60), st.integers(1, 100), RATES)
def test_windows_open_at_occurrences_keep_their_length_and_do_not_overlap(
    occurs: list[int], length: int, apart: int, rate_hz: int
) -> None:
    event, per_tick, length = Occurrences(), rate_hz // 20, min(length, apart)
    windows = Windows(event.openings(apart / 20), length / 20)
    starts: list[int] = []
    for tick in occurs:
        if not starts or tick - starts[-1] >= apart:
            starts.append(tick)
    expected = {
        poll: number for number, s in enumerate(starts) for poll in range(s * per_tick, (s + length) * per_tick)
    }
    assert opened(windows, event, occurs, rate_hz) == {
        poll: number for poll, number in expected.items() if poll < 450 * per_tick
    }


@given(OCCURS, st.integers(1, 60))
def test_a_fault_that_happens_once_strikes_at_the_first_occurrence_only(occurs: list[int], length: int) -> None:
    event = Occurrences()
    windows = TapContext(0.05, np.random.default_rng(0), event=event).window(at_s=3.0, length_s=length / 20)
    polls = range(occurs[0], min(occurs[0] + length, 450)) if occurs else ()
    assert opened(windows, event, occurs, 20) == dict.fromkeys(polls, 0)


def test_without_an_event_a_context_opens_windows_at_times() -> None:
    context = TapContext(0.05, np.random.default_rng(0))
    assert context.windows(20.0, 5.0, 2.0) == Windows.periodic(20.0, 5.0, 2.0)
    assert [context.window(3.0, math.inf).number(t_s) for t_s in (2.95, 3.0, 1000.0)] == [None, 0, 0]


def test_a_copy_of_windows_learns_of_nothing_that_happens_to_the_original() -> None:
    event = Occurrences()
    windows = Windows(event.openings(0.0), 1.0)
    branch = copy.deepcopy(windows)
    event.occur(2.0)
    assert windows.open(2.0)
    assert not branch.open(2.0)
