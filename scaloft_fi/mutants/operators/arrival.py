"""Operators that lose, delay, hold or reorder samples, and the identity."""

from __future__ import annotations

import math
from collections import deque
from functools import partial
from typing import Annotated, Any

from scaloft_fi.mutants.operator import ANYTHING, TOLERANCE_S, Hold, Period, Range, Seconds, Share, Tap, TapContext, on
from scaloft_fi.mutants.sample import Reading, Remembering, drawn, restamped
from scaloft_fi.stack.messages import Detections, Person

on_reading = partial(on, Reading, need=ANYTHING)

_A, _B, _C, _D = (Reading(0.0, float(i)) for i in range(4))


@on_reading("identity", {}, (_A, None, _B), (_A, None, _B))
def identity(_context: TapContext) -> Tap:
    """Deliver every sample unchanged: the operator of PLACEBO, which must equal the baseline."""
    return lambda _t_s, sample: sample


@on_reading("drop", {"share": 1.0}, (Reading(0.0, 1.0), None), (None, None))
def drop(context: TapContext, *, share: Share = 1.0) -> Tap:
    """Lose each sample with probability `share` (0..1), independently: an overloaded or unplugged link."""
    return drawn(context.rng, lambda rng, sample: None if rng.random() < share else sample)


@on_reading("outage", {"burst_s": 0.05, "period_s": 0.1}, (_A, _A, _A, _B, _B, _C), (_A, _A, None, _B, None, _C))
def outage(context: TapContext, *, burst_s: Hold, period_s: Period = 20.0, phase_s: Seconds = 0.0) -> Tap:
    """Lose every sample for `burst_s` [s], each `period_s` [s]: a driver that restarts, a loose plug."""
    windows = context.windows(period_s, phase_s, burst_s)
    return lambda t_s, sample: None if windows.open(t_s) else sample


@on_reading("throttle", {"rate_hz": 10.0}, (_A, _B, _C, _A, _B), (_A, None, _C, None, _B))
def throttle(_context: TapContext, *, rate_hz: Annotated[float, Range(above=0.0, most=1e4)]) -> Tap:
    """Pass the first sample of each 1/`rate_hz` [s] and lose the others: a sender that runs too slowly."""

    def step(own: Any, t_s: float, sample: Any | None) -> Any | None:
        slot = math.floor((t_s + TOLERANCE_S) * rate_hz)
        if sample is None or slot == own.slot:
            return None
        own.slot = slot
        return sample

    return Remembering(step, slot=-1)


@on(
    Detections,
    "deaf",
    {"first_s": 0.1},
    tuple(Detections(i / 20, (Person("person", 0.9, 0.0, 3.0),)) for i in range(3)),
    (None, None, Detections(0.1, (Person("person", 0.9, 0.0, 3.0),))),
    need=ANYTHING,
)
def deaf(_context: TapContext, *, first_s: Seconds) -> Tap:
    """Lose every sample of the first `first_s` [s]: the receiver subscribes after the sender has begun."""
    return lambda t_s, sample: None if t_s < first_s - TOLERANCE_S else sample


@on_reading("delay", {"delay_s": 0.1}, (_A, _B, None, None, _C), (None, None, _A, _B, None))
def delay(_context: TapContext, *, delay_s: Seconds, keep_first: bool = False) -> Tap:
    """Deliver each sample at the first poll `delay_s` [s] or more after it was sent, with its original time stamp.

    A queue in a slow transport, a slow computation.  With `keep_first` the first sample passes at once, as a setting
    that is made before take-off does.
    """

    def step(own: Any, t_s: float, sample: Any | None) -> Any | None:
        if sample is not None:
            first, own.begun = not own.begun, True
            if first and keep_first:
                return sample
            own.waiting.append((t_s + delay_s - TOLERANCE_S, sample))
        if own.waiting and own.waiting[0][0] <= t_s:
            return own.waiting.popleft()[1]
        return None

    return Remembering(step, waiting=deque(), begun=False)


@on_reading(
    "freeze",
    {"hold_s": 0.1, "period_s": 0.15},
    (*(Reading(i / 20, 0.1 * i) for i in range(6)),),
    (*(Reading(i / 20, 0.1 * j) for i, j in enumerate((0, 1, 2, 2, 2, 5))),),
)
def freeze(context: TapContext, *, hold_s: Hold, period_s: Period = 20.0, phase_s: Seconds = 0.0) -> Tap:
    """Repeat the last sample before the window with fresh time stamps for `hold_s` [s], each `period_s` [s].

    A sensor that is stuck behind a driver that goes on publishing (PX4's failure type `stuck`): no staleness check sees
    it.  An infinite `hold_s` lasts to the end.
    """

    def step(own: Any, t_s: float, sample: Any | None) -> Any | None:
        if sample is None:
            return None
        if own.held is None or not own.windows.open(t_s):
            own.held = sample
        return restamped(own.held, sample)

    return Remembering(step, windows=context.windows(period_s, phase_s, hold_s), held=None)


@on_reading("reorder", {"count": 2}, (_A, _B, _C, _D, None), (None, _B, _A, _D, _C))
def reorder(_context: TapContext, *, count: Annotated[int, Range(least=2, most=1000)]) -> Tap:
    """Deliver every block of `count` samples in reverse order, with the original time stamps.

    A transport without sequence.
    """

    def step(own: Any, _t_s: float, sample: Any | None) -> Any | None:
        if sample is not None:
            own.block.append(sample)
            if len(own.block) == count:
                own.ready[:0] = own.block
                own.block = []
        return own.ready.pop() if own.ready else None

    return Remembering(step, block=[], ready=[])
