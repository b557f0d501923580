"""Operators on images.  A pixel of 0 means that the sensor saw nothing there."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from scaloft_fi.mutants.operator import (
    IMAGE,
    Example,
    Hold,
    Metres,
    Period,
    Samples,
    Seconds,
    Share,
    Tap,
    TapContext,
    operator,
)
from scaloft_fi.mutants.sample import on_each, redrawn, within
from scaloft_fi.stack.messages import Array, DepthFrame

_ROW = DepthFrame(0.0, np.array([[1.0, 2.0, 3.0, 0.0]] * 4))


def _rows(*rows: tuple[float, ...]) -> DepthFrame:
    return DepthFrame(0.0, np.array(rows))


@dataclass
class _RangeNoise:
    share: float
    rng: np.random.Generator

    def __call__(self, _t_s: float, sample: Any | None) -> Any | None:
        return None if sample is None else redrawn(sample, self._noisy)

    def _noisy(self, image: Array) -> Array:
        factor = 1.0 + self.share * self.rng.standard_normal(image.shape)
        noisy: Array = image * np.maximum(factor, 0.0)
        return noisy


def _seen_pixels_differ(before: Samples, after: Samples) -> bool:
    return all(np.array_equal(a.depth != b.depth, b.depth > 0.0) for b, a in zip(before, after, strict=True))


@operator("range_noise", need=IMAGE, example=Example(DepthFrame, {"share": 0.05}, (_ROW, _ROW), _seen_pixels_differ))
def range_noise(context: TapContext, *, share: Share) -> Tap:
    """Add Gaussian noise of standard deviation `share` (0..1) of the range to every pixel that sees something.

    Dust, flying pixels.
    """
    return _RangeNoise(share, context.rng)


@operator(
    "lose_columns",
    need=IMAGE,
    example=Example(DepthFrame, {"share": 0.5}, (_ROW, None), (_rows(*[(1.0, 0.0, 0.0, 0.0)] * 4), None)),
)
def lose_columns(_context: TapContext, *, share: Share, side: Literal["left", "centre", "right"] = "centre") -> Tap:
    """Let a block of `share` (0..1) of the image's columns, at `side`, see nothing: dirt on the lens, a lost stripe."""

    def blinded(image: Array) -> Array:
        width = image.shape[1]
        lost = round(share * width)
        first = {"left": 0, "centre": (width - lost) // 2, "right": width - lost}[side]
        seen = image.copy()
        seen[:, first : first + lost] = 0.0
        return seen

    return on_each(lambda sample: redrawn(sample, blinded))


@operator(
    "mirror", need=IMAGE, example=Example(DepthFrame, {}, (_ROW, None), (_rows(*[(0.0, 3.0, 2.0, 1.0)] * 4), None))
)
def mirror(_context: TapContext) -> Tap:
    """Swap left and right of the image: columns published in reverse order (seen in PX4 pull request 22418)."""
    return on_each(lambda sample: redrawn(sample, lambda image: np.ascontiguousarray(image[:, ::-1])))


@operator(
    "phantom_blob",
    need=IMAGE,
    example=Example(
        DepthFrame,
        {"range_m": 1.5, "hold_s": 0.05, "period_s": 0.05, "share": 0.5},
        (_ROW, _ROW, None),
        (_ROW, _rows((1.0, 2.0, 3.0, 0.0), (1.0, 1.5, 1.5, 0.0), (1.0, 1.5, 1.5, 0.0), (1.0, 2.0, 3.0, 0.0)), None),
    ),
)
def phantom_blob(
    context: TapContext,
    *,
    range_m: Metres = 1.0,
    hold_s: Hold = 1.0,
    period_s: Period = 20.0,
    phase_s: Seconds = 0.0,
    share: Share = 0.3,
) -> Tap:
    """Show an object `range_m` [m] ahead over `share` (0..1) of width and height, for `hold_s` [s] each `period_s` [s].

    Dust, a drop.
    """
    windows = context.windows(period_s, phase_s, max(hold_s, context.period_s))

    def blotted(image: Array) -> Array:
        seen = image.copy()
        (top, high), (left, wide) = (((n - round(share * n)) // 2, round(share * n)) for n in seen.shape)
        blot = seen[top : top + high, left : left + wide]
        blot[(blot == 0.0) | (blot > range_m)] = range_m
        return seen

    return within(windows, lambda sample: redrawn(sample, blotted))
