"""Sample the series of a record at 20 Hz.

The last value is held: a value between two messages was never measured, and a flag or a distance to the nearest body
jumps, so that a line between two values would tell of states that were not.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from scaloft_fi.errors import InputError
from scaloft_fi.outside.records.record_map import Entry, Keep, Moment
from scaloft_fi.outside.records.source import Series
from scaloft_fi.sim.signals import SAMPLE_HZ
from scaloft_fi.stack.messages import Array

LONGEST_S = 3 * 3600.0
"""Longest flight of a record [s]."""
NEAR_S = 1e-6
"""Times that differ by less than this are equal [s]: records round them."""


def instants(path: Path, start_s: float, end_s: float) -> Array:
    """The times of the samples since the start, (T,) [s]; the last one is not before the end.

    Raises:
        InputError: the flight has no duration, or is too long.
    """
    duration_s = end_s - start_s
    if not 0.0 < duration_s <= LONGEST_S:
        told = f"the flight from {start_s:.3f} s to {end_s:.3f} s"
        raise InputError(f"{path}: {told} must last more than 0 s and at most {LONGEST_S:,.0f} s")
    count = math.ceil((duration_s - NEAR_S) * SAMPLE_HZ) + 1
    return np.arange(max(count, 2)) / SAMPLE_HZ


def sampled(path: Path, name: str, entry: Entry, series: Series | None, start_s: float, at_s: Array) -> Array:
    """A signal at the times `at_s` (T,) since `start_s` [s].

    Raises:
        InputError: it has no value at the start and no `unknown`.
    """
    if series is None:
        return np.full(len(at_s), entry.constant)
    values = (
        entry.factor * series.values + entry.offset if (entry.factor, entry.offset) != (1.0, 0.0) else series.values
    )
    until = np.searchsorted(series.times_s, start_s + at_s + NEAR_S, side="right")
    if until[0] == 0 and entry.unknown is None:
        first = f"its first message is at {series.times_s[0]:.3f} s" if len(values) else "it has no message"
        why = f"the flight starts at {start_s:.3f} s and {first}"
        raise InputError(
            f"{path}: signal {name!r} is not known at the start: {why}; give unknown: VALUE, or a later start"
        )
    held = np.concatenate([[entry.unknown or 0.0], values])[until]
    if entry.keep is Keep.LAST or not len(values):
        return held
    worst = np.minimum if entry.keep is Keep.LEAST else np.maximum
    for place in np.flatnonzero(np.diff(until, prepend=until[0])):
        held[place] = worst.reduce(values[until[place - 1] : until[place]])
    return held


def moment_s(path: Path, name: str, moment: Moment, series: Series) -> float:
    """When a moment comes [s].

    Raises:
        InputError: it never comes.
    """
    reached = np.flatnonzero(series.values >= moment.least)
    if not len(reached):
        raise InputError(f"{path}: the {name} of the flight never comes: no message is at least {moment.least:g}")
    return float(series.times_s[reached[0]])
