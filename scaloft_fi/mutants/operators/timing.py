"""Operators that change when, and in which order, samples arrive."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field
from typing import Annotated, Any

from scaloft_fi.mutants.operator import (
    TOLERANCE_S,
    Example,
    Hold,
    Period,
    Range,
    Seconds,
    Tap,
    TapContext,
    Windows,
    operator,
)
from scaloft_fi.mutants.sample import Reading, restamped

_A, _B, _C, _D = (Reading(0.0, float(i)) for i in range(4))


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


@operator("delay", example=Example(Reading, {"delay_s": 0.1}, (_A, _B, None, None, _C), (None, None, _A, _B, None)))
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


@operator(
    "freeze",
    example=Example(
        Reading,
        {"hold_s": 0.1, "period_s": 0.15},
        (*(Reading(i / 20, 0.1 * i) for i in range(6)),),
        (*(Reading(i / 20, 0.1 * j) for i, j in enumerate((0, 1, 2, 2, 2, 5))),),
    ),
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


@operator("reorder", example=Example(Reading, {"count": 2}, (_A, _B, _C, _D, None), (None, _B, _A, _D, _C)))
def reorder(_context: TapContext, *, count: Annotated[int, Range(least=2, most=1000)]) -> Tap:
    """Deliver every block of `count` samples in reverse order, with the original time stamps.

    A transport without sequence.
    """
    return _Reorder(count)
