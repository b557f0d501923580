"""Taps without memory, changed copies of samples (a sample is never written into), and small messages for examples."""

from __future__ import annotations

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np

from scaloft_fi.mutants.operator import ALL, Tap, Windows
from scaloft_fi.stack.messages import Stamp, Vector, image_fields, number_fields, stamp_fields


class Reading(NamedTuple):
    """A number with its time."""

    stamp_s: Stamp
    value: float


class Move(NamedTuple):
    """A vector and an angle [rad] with their time."""

    stamp_s: Stamp
    velocity: Vector
    angle_rad: float


class Word(NamedTuple):
    """A text with its time."""

    stamp_s: Stamp
    word: str


AXES = "xyz"


def on_each(change: Callable[[Any], Any]) -> Tap:
    """A tap without memory that applies `change` to every sample."""
    return lambda _t_s, sample: None if sample is None else change(sample)


def within(windows: Windows, change: Callable[[Any], Any]) -> Tap:
    """A tap without memory that applies `change` to the samples inside the windows."""
    return lambda t_s, sample: change(sample) if sample is not None and windows.open(t_s) else sample


class Remembering:
    """A tap with a memory: `step` is handed it, time [s] and sample at each poll, and returns what arrives."""

    def __init__(self, step: Callable[[Any, float, Any | None], Any | None], **memory: Any) -> None:
        self.step, self.own = step, SimpleNamespace(**memory)

    def __call__(self, t_s: float, sample: Any | None) -> Any | None:
        """Return what arrives."""
        return self.step(self.own, t_s, sample)


def drawn(
    rng: np.random.Generator, change: Callable[[np.random.Generator, Any], Any], windows: Windows | None = None
) -> Tap:
    """A tap that applies `change`, with random numbers of its own, to every sample, or to those inside `windows`."""

    def step(own: Any, t_s: float, sample: Any | None) -> Any | None:
        inside = sample is not None and (own.windows is None or own.windows.open(t_s))
        return change(own.rng, sample) if inside else sample

    return Remembering(step, rng=rng, windows=windows)


def at_each(windows: Windows, change: Callable[[Any], Any]) -> Tap:
    """A tap that applies `change` to the first sample after each window opens, and to no other."""

    def step(own: Any, t_s: float, sample: Any | None) -> Any | None:
        number = own.windows.number(t_s)
        if sample is None or number is None or number <= own.last:
            return sample
        own.last = number
        return change(sample)

    return Remembering(step, windows=windows, last=-1)


def altered(sample: Any, field: str, change: Callable[[Any], Any], component: str = "") -> Any:
    """`sample` with `change` applied to the numbers of `field`, or to one `component` (x, y, z) of it.

    `change` takes a float or an array and returns a new one.
    """
    names = number_fields(type(sample)) if field == ALL else (field,)
    return sample._replace(**{name: _changed(getattr(sample, name), change, component) for name in names})


def _changed(value: Any, change: Callable[[Any], Any], component: str) -> Any:
    if isinstance(value, tuple):
        chosen = AXES.index(component) if component else None
        return tuple(float(change(v)) if chosen in (None, i) else v for i, v in enumerate(value))
    if isinstance(value, np.ndarray):
        if not component:
            return change(value)
        fresh = value.copy()
        fresh[AXES.index(component)] = change(value[AXES.index(component)])
        return fresh
    return float(change(value))


def restamped(sample: Any, stamp_of: Any) -> Any:
    """`sample` with the time stamp of `stamp_of`, if its message has one."""
    return sample._replace(stamp_s=stamp_of.stamp_s) if hasattr(sample, "stamp_s") else sample


def reclocked(sample: Any, change: Callable[[float], float]) -> Any:
    """`sample` with `change` applied to each of its time stamps [s]."""
    return sample._replace(**{name: float(change(getattr(sample, name))) for name in stamp_fields(type(sample))})


def redrawn(sample: Any, change: Callable[[Any], Any]) -> Any:
    """`sample` with `change` applied to each of its images (H, W); `change` returns a new image."""
    return sample._replace(**{name: change(getattr(sample, name)) for name in image_fields(type(sample))})
