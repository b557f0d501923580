"""Operators on the speed limit (message `SpeedLimit`).  A reduction is a limit below the cruise limit."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, field
from typing import Annotated, Any

from scaloft_fi.mutants.operator import TOLERANCE_S, Example, Period, Range, Seconds, Tap, TapContext, operator, the
from scaloft_fi.mutants.sample import on_each
from scaloft_fi.stack.reference.messages import SpeedLimit

Speed = Annotated[float, Range(above=0.0, most=100.0)]


def _cruise(context: TapContext) -> float:
    return context.facts.cruise_mps


def _fast(t_s: float = 0.0) -> SpeedLimit:
    return SpeedLimit(t_s, 0.5, "euclidean")


def _slow(t_s: float = 0.0, limit_mps: float = 0.2) -> SpeedLimit:
    return SpeedLimit(t_s, limit_mps, "euclidean")


@operator(
    "drop_reductions",
    need=the(SpeedLimit),
    example=Example(SpeedLimit, {}, (_fast(), _slow(), None), (_fast(), None, None)),
)
def drop_reductions(context: TapContext) -> Tap:
    """Lose every reduction: the cruise limit stays in force."""
    cruise_mps = _cruise(context)
    return on_each(lambda limit: None if limit.limit_mps < cruise_mps else limit)


@operator(
    "slow_limit",
    need=the(SpeedLimit),
    example=Example(SpeedLimit, {"limit_mps": 0.3}, (_fast(), _slow(), None), (_fast(), _slow(limit_mps=0.3), None)),
)
def slow_limit(context: TapContext, *, limit_mps: Speed) -> Tap:
    """Reduce to `limit_mps` [m/s] instead: a wrong constant."""
    cruise_mps = _cruise(context)
    return on_each(lambda limit: limit._replace(limit_mps=limit_mps) if limit.limit_mps < cruise_mps else limit)


@operator(
    "swap_limits",
    need=the(SpeedLimit),
    example=Example(SpeedLimit, {}, (_fast(), _slow(), None), (_slow(), _fast(), None)),
)
def swap_limits(context: TapContext) -> Tap:
    """Publish the slow limit for the cruise limit, and the cruise limit for a reduction: an inverted condition."""
    cruise_mps, slow_mps = _cruise(context), context.facts.slow_mps
    return on_each(lambda limit: limit._replace(limit_mps=cruise_mps if limit.limit_mps < cruise_mps else slow_mps))


@dataclass
class _Republish:
    cruise_mps: float
    after_s: float
    due_s: float = math.inf
    norm: str = ""

    def __call__(self, t_s: float, sample: Any | None) -> Any | None:
        if sample is not None:
            reduces = sample.limit_mps < self.cruise_mps
            self.due_s, self.norm = t_s + self.after_s if reduces else math.inf, sample.norm
            return sample
        if t_s < self.due_s - TOLERANCE_S:
            return None
        self.due_s = math.inf
        return SpeedLimit(t_s, self.cruise_mps, self.norm)


@operator(
    "republish",
    need=the(SpeedLimit),
    example=Example(
        SpeedLimit,
        {"after_s": 0.1},
        (_slow(), _slow(0.05), None, None, None),
        (_slow(), _slow(0.05), None, _fast(0.15), None),
    ),
)
def republish(context: TapContext, *, after_s: Seconds) -> Tap:
    """Publish the cruise limit again, once, `after_s` [s] after the last reduction.

    A timer restores the default speed.
    """
    return _Republish(_cruise(context), after_s)


@dataclass
class _Release:
    cruise_mps: float
    after_s: float
    reduced_s: float = math.inf
    norm: str = ""
    released: bool = False

    def __call__(self, t_s: float, sample: Any | None) -> Any | None:
        reduces = sample is not None and sample.limit_mps < self.cruise_mps
        if sample is not None and reduces:
            self.reduced_s, self.norm = min(self.reduced_s, t_s), sample.norm
        if t_s - self.reduced_s < self.after_s - TOLERANCE_S:
            return sample
        if not self.released:
            self.released = True
            return SpeedLimit(t_s, self.cruise_mps, self.norm)
        return None if reduces else sample


@operator(
    "release",
    need=the(SpeedLimit),
    example=Example(
        SpeedLimit,
        {"after_s": 0.1},
        (_slow(), _slow(0.05), None, _slow(0.15), None),
        (_slow(), _slow(0.05), _fast(0.1), None, None),
    ),
)
def release(context: TapContext, *, after_s: Seconds) -> Tap:
    """Publish the cruise limit `after_s` [s] after the first reduction, and no reduction after that.

    The limit is released before the drone has passed the person.
    """
    return _Release(_cruise(context), after_s)


@dataclass
class _LateRelease:
    cruise_mps: float
    delay_s: float
    reduced: bool = False
    waiting: deque[tuple[float, Any]] = field(default_factory=deque)

    def __call__(self, t_s: float, sample: Any | None) -> Any | None:
        if sample is not None:
            if sample.limit_mps < self.cruise_mps:
                self.reduced = True
                self.waiting.clear()
            if not self.reduced or sample.limit_mps < self.cruise_mps:
                return sample
            self.waiting.append((t_s + self.delay_s - TOLERANCE_S, sample))
        if self.waiting and self.waiting[0][0] <= t_s:
            return self.waiting.popleft()[1]
        return None


@operator(
    "late_release",
    need=the(SpeedLimit),
    example=Example(
        SpeedLimit,
        {"delay_s": 0.1},
        (_fast(), _slow(), _fast(0.1), None, None),
        (_fast(), _slow(), None, None, _fast(0.1)),
    ),
)
def late_release(context: TapContext, *, delay_s: Seconds) -> Tap:
    """Deliver a return to the cruise limit `delay_s` [s] late; a new reduction meanwhile cancels it."""
    return _LateRelease(_cruise(context), delay_s)


@operator(
    "reset_limit",
    need=the(SpeedLimit),
    example=Example(SpeedLimit, {"period_s": 0.1}, (_slow(), None, None, None), (_slow(), None, _fast(0.1), None)),
)
def reset_limit(context: TapContext, *, period_s: Period = 20.0, phase_s: Seconds = 0.0) -> Tap:
    """Publish the cruise limit without cause once each `period_s` [s].

    The publisher restarts and begins with its default.
    """
    windows = context.windows(period_s, phase_s, context.period_s)
    cruise_mps = _cruise(context)
    return lambda t_s, sample: SpeedLimit(t_s, cruise_mps, "euclidean") if windows.open(t_s) else sample
