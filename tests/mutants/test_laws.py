"""Laws of the operators that shift, lose and reorder samples."""

from __future__ import annotations

from typing import Any

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from scaloft_fi.mutants.operator import TapContext, Windows
from scaloft_fi.mutants.operators import OPERATORS
from scaloft_fi.stack.messages import Person
from scaloft_fi.stack.reference.messages import Route, Target

SENT = st.lists(st.one_of(st.none(), st.integers(0, 10_000)), max_size=60)


def fly(name: str, polls: list[Any], seed: int = 0, **arguments: Any) -> list[Any]:
    operator = OPERATORS[name]
    context = TapContext(0.05, np.random.Generator(np.random.Philox(seed)))
    tap = operator.tap(context, operator.check("target", Target, arguments))
    return [tap(k / 20, sample) for k, sample in enumerate(polls)]


def targets(sent: list[int | None]) -> list[Target | None]:
    return [None if leg is None else Target(leg, (0.0, float(k), 1.65)) for k, leg in enumerate(sent)]


def arrived(samples: list[Any]) -> list[Any]:
    return [sample for sample in samples if sample is not None]


@given(SENT, st.floats(0.0, 2.0))
def test_delay_keeps_every_sample_and_their_order(sent: list[int | None], delay_s: float) -> None:
    polls = targets(sent) + [None] * 61
    assert arrived(fly("delay", polls, delay_s=delay_s)) == arrived(polls)


@given(SENT, st.integers(0, 30))
def test_delay_by_whole_polls_shifts_by_as_many_polls(sent: list[int | None], polls_late: int) -> None:
    polls = targets(sent) + [None] * polls_late
    late = fly("delay", polls, delay_s=polls_late / 20)
    assert late[polls_late:] == polls[: len(polls) - polls_late]


@given(SENT, st.integers(0, 5))
def test_dropping_no_share_is_the_identity_and_dropping_all_leaves_nothing(sent: list[int | None], seed: int) -> None:
    polls = targets(sent)
    assert fly("drop", polls, seed, share=0.0) == polls
    assert arrived(fly("drop", polls, seed, share=1.0)) == []


def test_drop_loses_about_the_share_it_is_told() -> None:
    kept = arrived(fly("drop", targets(list(range(4000))), share=0.25))
    assert 0.72 < len(kept) / 4000 < 0.78


@given(SENT, st.integers(2, 7))
def test_reorder_permutes_all_but_the_last_incomplete_block(sent: list[int | None], count: int) -> None:
    polls = targets(sent) + [None] * count
    whole = len(arrived(polls)) // count * count
    reordered = arrived(fly("reorder", polls, count=count))
    assert sorted(reordered) == sorted(arrived(polls)[:whole])
    assert reordered == [s for k in range(0, whole, count) for s in arrived(polls)[k : k + count][::-1]]


@given(SENT, st.sampled_from([10.0, 5.0, 4.0]))
def test_throttle_passes_at_most_its_rate(sent: list[int | None], rate_hz: float) -> None:
    times_s = [k / 20 for k, sample in enumerate(fly("throttle", targets(sent), rate_hz=rate_hz)) if sample]
    slots = [round(t_s * rate_hz * 1e6) // 1_000_000 for t_s in times_s]
    assert len(slots) == len(set(slots))


@given(st.integers(2, 400), st.integers(0, 400), st.integers(1, 400), st.sampled_from([20, 240]), st.integers(0, 2000))
def test_windows_recur_with_their_period_and_none_is_open_before_the_first(
    period: int, phase: int, length: int, rate_hz: int, k: int
) -> None:
    windows = Windows.periodic(period / rate_hz, phase / rate_hz, min(length, period) / rate_hz)
    since = k - period - phase
    assert windows.open(k / rate_hz) == (since >= 0 and since % period < min(length, period))


@given(st.integers(1, 40), st.integers(0, 40))
def test_outage_is_silent_in_its_windows_and_transparent_outside(burst: int, phase: int) -> None:
    polls = targets(list(range(200)))
    silent = [
        k
        for k, sample in enumerate(fly("outage", polls, burst_s=burst / 20, period_s=2.0, phase_s=phase / 20))
        if sample is None
    ]
    assert silent == [k for k in range(200) if k - 40 - phase >= 0 and (k - 40 - phase) % 40 < burst]


def test_an_endless_freeze_repeats_the_sample_before_it() -> None:
    held = fly("freeze", targets(list(range(20))), hold_s=float("inf"), period_s=0.5)
    assert held[:10] == targets(list(range(20)))[:10]
    assert set(held[10:]) == {held[9]}


def test_seven_in_ten_of_a_narrow_view_is_measured_in_degrees() -> None:
    operator = OPERATORS["narrow"]
    tap = operator.tap(TapContext(0.05, np.random.default_rng(0)), {"share": 0.5})
    inside, outside = Person("person", 0.9, np.radians(14.0), 3.0), Person("person", 0.9, np.radians(-15.5), 3.0)
    boxes = operator.example.before[0]._replace(persons=(inside, outside))
    assert tap(0.0, boxes).persons == (inside,)  # type: ignore[union-attr]


@given(st.floats(0.0, 0.6))
def test_the_inserted_waypoint_keeps_its_clearance_from_the_wall(clearance_m: float) -> None:
    operator = OPERATORS["insert_near_wall"]
    tap = operator.tap(TapContext(0.05, np.random.default_rng(0)), {"clearance_m": clearance_m})
    route = tap(0.0, Route(((0.0, 7.0, 1.65), (0.0, 0.0, 1.65))))
    assert route is not None
    assert abs(1.5 - (route.points[0][0] + 0.235) - clearance_m) < 1e-9
