"""Operators that lose samples, and the identity."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np

from scaloft_fi.mutants.operator import (
    TOLERANCE_S,
    Example,
    Hold,
    Period,
    Range,
    Seconds,
    Share,
    Tap,
    TapContext,
    operator,
)
from scaloft_fi.mutants.sample import Reading
from scaloft_fi.stack.messages import Detections as Boxes
from scaloft_fi.stack.messages import Person

_A, _B, _C = (Reading(0.0, float(i)) for i in range(3))


@operator("identity", example=Example(Reading, {}, (_A, None, _B), (_A, None, _B)))
def identity(_context: TapContext) -> Tap:
    """Deliver every sample unchanged: the operator of PLACEBO, which must equal the baseline."""
    return lambda _t_s, sample: sample


@dataclass
class _Drop:
    share: float
    rng: np.random.Generator

    def __call__(self, _t_s: float, sample: Any | None) -> Any | None:
        if sample is None:
            return None
        return None if self.rng.random() < self.share else sample


@operator("drop", example=Example(Reading, {"share": 1.0}, (Reading(0.0, 1.0), None), (None, None)))
def drop(context: TapContext, *, share: Share = 1.0) -> Tap:
    """Lose each sample with probability `share` (0..1), independently: an overloaded or unplugged link."""
    return _Drop(share, context.rng)


@operator(
    "outage",
    example=Example(
        Reading, {"burst_s": 0.05, "period_s": 0.1}, (_A, _A, _A, _B, _B, _C), (_A, _A, None, _B, None, _C)
    ),
)
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


@operator("throttle", example=Example(Reading, {"rate_hz": 10.0}, (_A, _B, _C, _A, _B), (_A, None, _C, None, _B)))
def throttle(_context: TapContext, *, rate_hz: Annotated[float, Range(above=0.0, most=1e4)]) -> Tap:
    """Pass the first sample of each 1/`rate_hz` [s] and lose the others: a sender that runs too slowly."""
    return _Throttle(rate_hz)


@operator(
    "deaf",
    example=Example(
        Boxes,
        {"first_s": 0.1},
        tuple(Boxes(i / 20, (Person("person", 0.9, 0.0, 3.0),)) for i in range(3)),
        (None, None, Boxes(0.1, (Person("person", 0.9, 0.0, 3.0),))),
    ),
)
def deaf(_context: TapContext, *, first_s: Seconds) -> Tap:
    """Lose every sample of the first `first_s` [s]: the receiver subscribes after the sender has begun."""
    return lambda t_s, sample: None if t_s < first_s - TOLERANCE_S else sample
