"""Operators that change a field from take-off to the end."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np

from scaloft_fi.mutants.operator import (
    ALL,
    NUMBERS,
    AnyField,
    Axis,
    Component,
    Degrees,
    Example,
    Factor,
    Number,
    NumericField,
    Range,
    Samples,
    Tap,
    TapContext,
    ValueOfField,
    operator,
)
from scaloft_fi.mutants.sample import Move, Word, altered, on_each
from scaloft_fi.stack.messages import Metering

_FORWARD = Move(0.0, np.array([0.1, 0.5, -0.2]), 1.5)


def _forward(x: float, y: float, z: float) -> Move:
    return _FORWARD._replace(velocity=np.array([x, y, z]))


@operator(
    "scale",
    need=NUMBERS,
    example=Example(Move, {"field": "velocity", "factor": 2.0}, (None, _FORWARD), (None, _forward(0.2, 1.0, -0.4))),
)
def scale(_context: TapContext, *, field: NumericField, factor: Factor) -> Tap:
    """Multiply `field` by `factor`: a wrong gain, a wrong unit."""
    return on_each(lambda sample: altered(sample, field, lambda v: v * factor))


@operator(
    "set",
    example=Example(
        Word,
        {"field": "word", "value": "per_axis"},
        (Word(0.0, "euclidean"), None),
        (Word(0.0, "per_axis"), None),
    ),
)
def set_field(_context: TapContext, *, field: AnyField, value: ValueOfField) -> Tap:
    """Replace `field` by `value`, in the field's own unit: a wrong or forgotten setting."""
    if field == ALL:
        return on_each(lambda sample: altered(sample, field, lambda _v: value))
    return on_each(lambda sample: sample._replace(**{field: value}))


@operator(
    "bias",
    need=NUMBERS,
    example=Example(
        Move,
        {"field": "velocity", "amount": 0.1, "component": "x"},
        (_FORWARD, None),
        (_forward(0.2, 0.5, -0.2), None),
    ),
)
def bias(_context: TapContext, *, field: NumericField, amount: Number, component: Component = "") -> Tap:
    """Add `amount` (in the field's unit) to `field`, or to one component of it: a wrong calibration, a drift."""
    return on_each(lambda sample: altered(sample, field, lambda v: v + amount, component))


@dataclass
class _Noise:
    field: str
    sigma: float
    component: str
    rng: np.random.Generator

    def __call__(self, _t_s: float, sample: Any | None) -> Any | None:
        return sample and altered(sample, self.field, self._noisy, self.component)

    def _noisy(self, value: Any) -> Any:
        return value + self.sigma * self.rng.standard_normal(np.shape(value))


def _all_entries_differ(before: Samples, after: Samples) -> bool:
    return all(
        np.all(b.velocity != a.velocity) and np.all(abs(a.velocity - b.velocity) < 1.0)
        for b, a in zip(before, after, strict=True)
    )


@operator(
    "noise",
    need=NUMBERS,
    example=Example(Move, {"field": "velocity", "sigma": 0.1}, (_FORWARD, _FORWARD), _all_entries_differ),
)
def noise(
    context: TapContext,
    *,
    field: NumericField,
    sigma: Annotated[float, Range(least=0.0, most=1e6)],
    component: Component = "",
) -> Tap:
    """Add independent Gaussian noise of standard deviation `sigma` (in the field's unit) to every number of `field`."""
    return _Noise(field, sigma, component, context.rng)


@operator(
    "negate",
    need=NUMBERS,
    example=Example(Metering, {"field": "error_ev"}, (Metering(0.0, 1.5), None), (Metering(0.0, -1.5), None)),
)
def negate(_context: TapContext, *, field: NumericField, component: Component = "") -> Tap:
    """Turn the sign of `field`, or of one component of it: an inverted loop, a frame taken for its mirror image."""
    return on_each(lambda sample: altered(sample, field, lambda v: -v, component))


@operator(
    "turn",
    need=NUMBERS,
    example=Example(
        Move,
        {"field": "angle_rad", "angle_deg": 180.0},
        (None, _FORWARD._replace(angle_rad=0.5 * math.pi)),
        (None, _FORWARD._replace(angle_rad=-0.5 * math.pi)),
    ),
)
def turn(_context: TapContext, *, field: NumericField, angle_deg: Degrees) -> Tap:
    """Turn the angle `field` [rad] by `angle_deg` [deg], within (-pi, pi].

    A sensor mounted or numbered the wrong way round.
    """
    angle_rad = math.radians(angle_deg)
    return on_each(lambda sample: altered(sample, field, lambda v: math.pi - (math.pi - v - angle_rad) % (2 * math.pi)))


@operator(
    "zero_component",
    need=NUMBERS,
    example=Example(Move, {"field": "velocity", "component": "y"}, (_FORWARD, None), (_forward(0.1, 0.0, -0.2), None)),
)
def zero_component(_context: TapContext, *, field: NumericField, component: Axis) -> Tap:
    """Replace one component (x, y, z) of `field` by 0: one axis is not measured or not executed."""
    return on_each(lambda sample: altered(sample, field, lambda _v: 0.0, component))
