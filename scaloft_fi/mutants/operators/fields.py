"""Operators that change a field: from take-off to the end, in recurring windows, or from one moment on."""

from __future__ import annotations

import math
from functools import partial
from typing import Annotated, Any

import numpy as np

from scaloft_fi.mutants.operator import (
    ALL,
    ANYTHING,
    NUMBERS,
    AnyField,
    Axis,
    Component,
    Degrees,
    Factor,
    Hold,
    Number,
    NumericField,
    Period,
    Range,
    Samples,
    Seconds,
    Tap,
    TapContext,
    ValueOfField,
    Windows,
    on,
)
from scaloft_fi.mutants.sample import Move, Word, altered, drawn, on_each, within
from scaloft_fi.stack.declaration import STEP_HZ
from scaloft_fi.stack.messages import Exposure, Imu, Metering, Stamps

on_numeric = partial(on, need=NUMBERS)

_FORWARD = Move(0.0, np.array([0.1, 0.5, -0.2]), 1.5)


def _forward(x: float, y: float, z: float) -> Move:
    return _FORWARD._replace(velocity=np.array([x, y, z]))


@on_numeric(Move, "scale", {"field": "velocity", "factor": 2.0}, (None, _FORWARD), (None, _forward(0.2, 1.0, -0.4)))
def scale(_context: TapContext, *, field: NumericField, factor: Factor) -> Tap:
    """Multiply `field` by `factor`: a wrong gain, a wrong unit."""
    return on_each(lambda sample: altered(sample, field, lambda v: v * factor))


@on(
    Word,
    "set",
    {"field": "word", "value": "per_axis"},
    (Word(0.0, "euclidean"), None),
    (Word(0.0, "per_axis"), None),
    need=ANYTHING,
)
def set_field(_context: TapContext, *, field: AnyField, value: ValueOfField) -> Tap:
    """Replace `field` by `value`, in the field's own unit: a wrong or forgotten setting."""
    if field == ALL:
        return on_each(lambda sample: altered(sample, field, lambda _v: value))
    return on_each(lambda sample: sample._replace(**{field: value}))


@on_numeric(
    Move,
    "bias",
    {"field": "velocity", "amount": 0.1, "component": "x"},
    (_FORWARD, None),
    (_forward(0.2, 0.5, -0.2), None),
)
def bias(_context: TapContext, *, field: NumericField, amount: Number, component: Component = "") -> Tap:
    """Add `amount` (in the field's unit) to `field`, or to one component of it: a wrong calibration, a drift."""
    return on_each(lambda sample: altered(sample, field, lambda v: v + amount, component))


def _all_entries_differ(before: Samples, after: Samples) -> bool:
    return all(
        np.all(b.velocity != a.velocity) and np.all(abs(a.velocity - b.velocity) < 1.0)
        for b, a in zip(before, after, strict=True)
    )


@on_numeric(Move, "noise", {"field": "velocity", "sigma": 0.1}, (_FORWARD, _FORWARD), _all_entries_differ)
def noise(
    context: TapContext,
    *,
    field: NumericField,
    sigma: Annotated[float, Range(least=0.0, most=1e6)],
    component: Component = "",
) -> Tap:
    """Add independent Gaussian noise of standard deviation `sigma` (in the field's unit) to every number of `field`."""

    def noisy(rng: np.random.Generator, sample: Any) -> Any:
        return altered(sample, field, lambda v: v + sigma * rng.standard_normal(np.shape(v)), component)

    return drawn(context.rng, noisy)


@on_numeric(Metering, "negate", {"field": "error_ev"}, (Metering(0.0, 1.5), None), (Metering(0.0, -1.5), None))
def negate(_context: TapContext, *, field: NumericField, component: Component = "") -> Tap:
    """Turn the sign of `field`, or of one component of it: an inverted loop, a frame taken for its mirror image."""
    return on_each(lambda sample: altered(sample, field, lambda v: -v, component))


@on_numeric(
    Move,
    "turn",
    {"field": "angle_rad", "angle_deg": 180.0},
    (None, _FORWARD._replace(angle_rad=0.5 * math.pi)),
    (None, _FORWARD._replace(angle_rad=-0.5 * math.pi)),
)
def turn(_context: TapContext, *, field: NumericField, angle_deg: Degrees) -> Tap:
    """Turn the angle `field` [rad] by `angle_deg` [deg], within (-pi, pi].

    A sensor mounted or numbered the wrong way round.
    """
    angle_rad = math.radians(angle_deg)
    return on_each(lambda sample: altered(sample, field, lambda v: math.pi - (math.pi - v - angle_rad) % (2 * math.pi)))


@on_numeric(
    Move, "zero_component", {"field": "velocity", "component": "y"}, (_FORWARD, None), (_forward(0.1, 0.0, -0.2), None)
)
def zero_component(_context: TapContext, *, field: NumericField, component: Axis) -> Tap:
    """Replace one component (x, y, z) of `field` by 0: one axis is not measured or not executed."""
    return on_each(lambda sample: altered(sample, field, lambda _v: 0.0, component))


_EXPOSURE = Exposure(1.0, 2.0, 0.0)
_REST = Imu(0.0, np.array([0.1, -0.2, 0.3]), np.array([0.0, 0.0, 9.81]))


@on_numeric(
    Exposure,
    "pulse",
    {"field": "ev", "amount": 4.0, "hold_s": 0.05, "period_s": 0.1},
    (_EXPOSURE,) * 4,
    (_EXPOSURE, _EXPOSURE, _EXPOSURE._replace(ev=5.0), _EXPOSURE),
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


@on_numeric(
    Imu,
    "blank",
    {"field": "rate", "hold_s": 1 / 240, "period_s": 1 / 120},
    (_REST,) * 3,
    (_REST, _REST, _REST._replace(rate=np.zeros(3))),
    rate_hz=STEP_HZ,
)
def blank(
    context: TapContext, *, field: NumericField, hold_s: Hold, period_s: Period = 20.0, phase_s: Seconds = 0.0
) -> Tap:
    """Let `field` read 0 for `hold_s` [s], each `period_s` [s]: a sensor without power (PX4's failure type `off`)."""
    windows = context.windows(period_s, phase_s, max(hold_s, context.period_s))
    return within(windows, lambda sample: altered(sample, field, lambda v: v * 0.0))


@on_numeric(
    Stamps,
    "jump",
    {"field": "all", "amount": -1.0, "at_s": 0.05},
    (Stamps(10.0, 10.0, 9.9), Stamps(10.1, 10.1, 10.0)),
    (Stamps(10.0, 10.0, 9.9), Stamps(9.1, 9.1, 9.0)),
)
def jump(
    _context: TapContext, *, field: NumericField, amount: Number, at_s: Seconds = 20.0, component: Component = ""
) -> Tap:
    """Add `amount` (in the field's unit) to `field` from `at_s` [s] on: a wrong relocalisation, a clock that is set."""
    return within(Windows.since(at_s), lambda sample: altered(sample, field, lambda v: v + amount, component))
