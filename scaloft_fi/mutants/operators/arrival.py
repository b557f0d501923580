"""Operators that lose, delay, hold or reorder samples, and the identity."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, field
from functools import partial
from typing import Annotated, Any

from scaloft_fi.mutants.operator import (
    ANYTHING,
    TOLERANCE_S,
    Hold,
    Period,
    Range,
    Seconds,
    Share,
    Tap,
    TapContext,
    Windows,
    on,
)
from scaloft_fi.mutants.sample import Drawn, Reading, restamped
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
    return Drawn(context.rng, lambda rng, sample: None if rng.random() < share else sample)


@on_reading("outage", {"burst_s": 0.05, "period_s": 0.1}, (_A, _A, _A, _B, _B, _C), (_A, _A, None, _B, None, _C))
def outage(context: TapContext, *, burst_s: Hold, period_s: Period = 20.0, phase_s: Seconds = 0.0) -> Tap:
    """Lose every sample for `burst_s` [s], each `period_s` [s]: a driver that restarts, a loose plug."""
    windows = context.windows(period_s, phase_s, burst_s)
    return lambda t_s, sample: None if windows.open(t_s) else sample


@dataclass
class _Throttle:
    rate_hz: float
    slot: int = -1

    def __call__(self, t_s: float, sample: Any | None) -> Any | None:
        slot = math.floor((t_s + TOLERANCE_S) * self.rate_hz)
        if sample is None or slot == self.slot:
            return None
        self.slot = slot
        return sample


@on_reading("throttle", {"rate_hz": 10.0}, (_A, _B, _C, _A, _B), (_A, None, _C, None, _B))
def throttle(_context: TapContext, *, rate_hz: Annotated[float, Range(above=0.0, most=1e4)]) -> Tap:
    """Pass the first sample of each 1/`rate_hz` [s] and lose the others: a sender that runs too slowly."""
    return _Throttle(rate_hz)


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


@dataclass
class _Delay:
    delay_s: float
    keep_first: bool
    waiting: deque[tuple[float, Any]] = field(default_factory=deque)
    begun: bool = False

    def __call__(self, t_s: float, sample: Any | None) -> Any | None:
        if sample is not None:
            first, self.begun = not self.begun, True
            if first and self.keep_first:
                return sample
            self.waiting.append((t_s + self.delay_s - TOLERANCE_S, sample))
        if self.waiting and self.waiting[0][0] <= t_s:
            return self.waiting.popleft()[1]
        return None


@on_reading("delay", {"delay_s": 0.1}, (_A, _B, None, None, _C), (None, None, _A, _B, None))
def delay(_context: TapContext, *, delay_s: Seconds, keep_first: bool = False) -> Tap:
    """Deliver each sample at the first poll `delay_s` [s] or more after it was sent, with its original time stamp.

    A queue in a slow transport, a slow computation.  With `keep_first` the first sample passes at once, as a setting
    that is made before take-off does.
    """
    return _Delay(delay_s, keep_first)


@dataclass
class _Freeze:
    windows: Windows
    held: Any | None = None

    def __call__(self, t_s: float, sample: Any | None) -> Any | None:
        if sample is None:
            return None
        if self.held is None or not self.windows.open(t_s):
            self.held = sample
        return restamped(self.held, sample)


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
    return _Freeze(context.windows(period_s, phase_s, hold_s))


@dataclass
class _Reorder:
    count: int
    block: list[Any] = field(default_factory=list)
    ready: list[Any] = field(default_factory=list)

    def __call__(self, _t_s: float, sample: Any | None) -> Any | None:
        if sample is not None:
            self.block.append(sample)
            if len(self.block) == self.count:
                self.ready[:0] = self.block
                self.block = []
        return self.ready.pop() if self.ready else None


@on_reading("reorder", {"count": 2}, (_A, _B, _C, _D, None), (None, _B, _A, _D, _C))
def reorder(_context: TapContext, *, count: Annotated[int, Range(least=2, most=1000)]) -> Tap:
    """Deliver every block of `count` samples in reverse order, with the original time stamps.

    A transport without sequence.
    """
    return _Reorder(count)
