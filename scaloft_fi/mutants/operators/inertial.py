"""Operators on the samples of an inertial sensor (message `Imu`)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np

from scaloft_fi.mutants.operator import (
    Example,
    Hold,
    Period,
    Range,
    Samples,
    Seconds,
    Tap,
    TapContext,
    Windows,
    operator,
    the,
)
from scaloft_fi.mutants.sample import on_each
from scaloft_fi.stack.declaration import STEP_HZ
from scaloft_fi.stack.messages import Imu

Positive = Annotated[float, Range(above=0.0, most=1e6)]
_REST = Imu(0.0, np.array([0.1, -0.2, 0.3]), np.array([0.5, 0.0, 9.81]))


def _all_axes_shake(before: Samples, after: Samples) -> bool:
    return all(np.all(a.rate != b.rate) and np.all(a.force != b.force) for b, a in zip(before, after, strict=True))


@dataclass
class _Shake:
    rate_radps: float
    force_mps2: float
    rng: np.random.Generator

    def __call__(self, _t_s: float, sample: Any | None) -> Any | None:
        if sample is None:
            return None
        rate, force = self.rng.standard_normal((2, 3))
        return sample._replace(rate=sample.rate + self.rate_radps * rate, force=sample.force + self.force_mps2 * force)


@operator("vibration", need=the(Imu), example=Example(Imu, {"factor": 10.0}, (_REST, _REST), _all_axes_shake))
def vibration(context: TapContext, *, factor: Annotated[float, Range(least=1.0, most=1e6)]) -> Tap:
    """Raise the white noise of both sensors to `factor` times the nominal sigma per sample.

    An unbalanced propeller, a loose mount.
    """
    extra = math.sqrt(factor**2 - 1.0)  # variances add up
    rate_radps = context.facts.gyro_sigma_radps
    force_mps2 = context.facts.accel_sigma_mps2
    return _Shake(extra * rate_radps, extra * force_mps2, context.rng)


@operator(
    "remount",
    need=the(Imu),
    example=Example(Imu, {}, (_REST, None), (Imu(0.0, np.array([-0.1, 0.2, 0.3]), np.array([-0.5, 0.0, 9.81])), None)),
)
def remount(_context: TapContext) -> Tap:
    """Turn the sensor by 180 deg about the body's z axis: mounted the wrong way round, or a wrong rotation setting."""
    signs = np.array([-1.0, -1.0, 1.0])
    return on_each(lambda imu: imu._replace(rate=imu.rate * signs, force=imu.force * signs))


@dataclass
class _Garbage:
    windows: Windows
    rate_radps: float
    force_mps2: float
    rng: np.random.Generator

    def __call__(self, t_s: float, sample: Any | None) -> Any | None:
        if sample is None or not self.windows.open(t_s):
            return sample
        rate, force = self.rng.uniform(-1.0, 1.0, (2, 3))
        return sample._replace(rate=self.rate_radps * rate, force=self.force_mps2 * force)


def _second_is_garbage(before: Samples, after: Samples) -> bool:
    return after[0] is before[0] and bool(np.all(after[1].rate != before[1].rate)) and after[2] is None


@operator(
    "garbage",
    need=the(Imu),
    example=Example(
        Imu, {"hold_s": 1 / 240, "period_s": 1 / 240}, (_REST, _REST, None), _second_is_garbage, rate_hz=STEP_HZ
    ),
)
def garbage(
    context: TapContext,
    *,
    hold_s: Hold,
    period_s: Period = 20.0,
    phase_s: Seconds = 0.0,
    rate_span_radps: Positive = 34.9,
    force_span_mps2: Positive = 157.0,
) -> Tap:
    """Replace both readings by uniform random ones for `hold_s` [s], each `period_s` [s].

    A broken bus (PX4's failure type `garbage`).  The spans are the ranges of a common sensor, 2000 deg/s and 16 g.
    """
    windows = context.windows(period_s, phase_s, max(hold_s, context.period_s))
    return _Garbage(windows, rate_span_radps, force_span_mps2, context.rng)
