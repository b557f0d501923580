"""Operators that change a field in recurring windows, or from one moment on."""

from __future__ import annotations

import numpy as np

from scaloft_fi.mutants.operator import (
    NUMBERS,
    Component,
    Example,
    Hold,
    Number,
    NumericField,
    Period,
    Seconds,
    Tap,
    TapContext,
    Windows,
    operator,
)
from scaloft_fi.mutants.sample import altered, within
from scaloft_fi.stack.declaration import STEP_HZ
from scaloft_fi.stack.messages import Exposure, Imu, Stamps

_EXPOSURE = Exposure(1.0, 2.0, 0.0)
_REST = Imu(0.0, np.array([0.1, -0.2, 0.3]), np.array([0.0, 0.0, 9.81]))


@operator(
    "pulse",
    need=NUMBERS,
    example=Example(
        Exposure,
        {"field": "ev", "amount": 4.0, "hold_s": 0.05, "period_s": 0.1},
        (_EXPOSURE,) * 4,
        (_EXPOSURE, _EXPOSURE, _EXPOSURE._replace(ev=5.0), _EXPOSURE),
    ),
)
def pulse(
    context: TapContext,
    *,
    field: NumericField,
    amount: Number,
    hold_s: Hold = 0.0,
    period_s: Period = 20.0,
    phase_s: Seconds = 0.0,
    component: Component = "",
) -> Tap:
    """Add `amount` (in the field's unit) to `field` for `hold_s` [s], each `period_s` [s]: a shock, a flicker.

    A `hold_s` of 0 changes one sample.
    """
    windows = context.windows(period_s, phase_s, max(hold_s, context.period_s))
    return within(windows, lambda sample: altered(sample, field, lambda v: v + amount, component))


@operator(
    "blank",
    need=NUMBERS,
    example=Example(
        Imu,
        {"field": "rate", "hold_s": 1 / 240, "period_s": 1 / 120},
        (_REST,) * 3,
        (_REST, _REST, _REST._replace(rate=np.zeros(3))),
        rate_hz=STEP_HZ,
    ),
)
def blank(
    context: TapContext,
    *,
    field: NumericField,
    hold_s: Hold,
    period_s: Period = 20.0,
    phase_s: Seconds = 0.0,
) -> Tap:
    """Let `field` read 0 for `hold_s` [s], each `period_s` [s]: a sensor without power (PX4's failure type `off`)."""
    windows = context.windows(period_s, phase_s, max(hold_s, context.period_s))
    return within(windows, lambda sample: altered(sample, field, lambda v: v * 0.0))


@operator(
    "jump",
    need=NUMBERS,
    example=Example(
        Stamps,
        {"field": "all", "amount": -1.0, "at_s": 0.05},
        (Stamps(10.0, 10.0, 9.9), Stamps(10.1, 10.1, 10.0)),
        (Stamps(10.0, 10.0, 9.9), Stamps(9.1, 9.1, 9.0)),
    ),
)
def jump(
    _context: TapContext,
    *,
    field: NumericField,
    amount: Number,
    at_s: Seconds = 20.0,
    component: Component = "",
) -> Tap:
    """Add `amount` (in the field's unit) to `field` from `at_s` [s] on: a wrong relocalisation, a clock that is set."""
    return within(Windows.since(at_s), lambda sample: altered(sample, field, lambda v: v + amount, component))
