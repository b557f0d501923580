"""Recent estimates of position and heading by time, for fixes that arrive late."""

from __future__ import annotations

import math

import numpy as np

from scaloft_fi.stack.fields import Array
from scaloft_fi.stack.kernel import jit

_ROWS = 64


class History:
    """Estimates of the last `span_s` seconds, as rows of time [s], position x, y, z [m, world] and heading [rad]."""

    def __init__(self, span_s: float) -> None:
        self._span_s = span_s
        self._rows = np.empty((_ROWS, 5))
        self._first = self._end = 0

    def __len__(self) -> int:
        return self._end - self._first

    def add(self, now_s: float, position: Array, yaw_rad: float) -> None:
        """Add the estimate of `now_s` and drop estimates that are older than the span."""
        if self._end == len(self._rows):
            kept = self._rows[self._first :].copy()
            if 2 * len(kept) > len(self._rows):
                self._rows = np.empty((2 * len(self._rows), 5))
            self._rows[: len(kept)] = kept
            self._first, self._end = 0, len(kept)
        self._first = _add(self._rows, self._first, self._end, now_s, position, yaw_rad, self._span_s)
        self._end += 1

    def at(self, stamp_s: float) -> tuple[Array, float]:
        """Position (3,) and heading at `stamp_s`, interpolated; outside the history those of its last or first row."""
        position = np.empty(3)
        share, yaw_rad, later_rad = _at(self._rows, self._first, self._end, stamp_s, position)
        if share > 0.0:
            yaw_rad += share * math.remainder(later_rad - yaw_rad, 2.0 * math.pi)
        return position, yaw_rad

    def shift(self, position: Array, yaw_rad: float) -> None:
        """Apply a correction to the recent past as well; otherwise late fixes would correct the same error twice."""
        _shift(self._rows, self._first, self._end, position, yaw_rad)


@jit
def _add(rows: Array, first: int, end: int, now_s: float, position: Array, yaw_rad: float, span_s: float) -> int:
    """Write row `end`; returns the number of the first row that is not older than the span."""
    rows[end, 0], rows[end, 4] = now_s, yaw_rad
    for k in range(3):
        rows[end, 1 + k] = position[k]
    while now_s - rows[first, 0] > span_s:
        first += 1
    return first


@jit
def _at(rows: Array, first: int, end: int, stamp_s: float, position: Array) -> tuple[float, float, float]:
    """Interpolate `position` (3,); returns the share of the later one of two rows, and their headings."""
    i = end - 1
    while i > first and not rows[i, 0] <= stamp_s:
        i -= 1
    later = min(i + 1, end - 1)
    span_s = rows[later, 0] - rows[i, 0]
    share = min(1.0, (stamp_s - rows[i, 0]) / span_s) if span_s > 0.0 and rows[i, 0] <= stamp_s else 0.0
    for k in range(1, 4):
        position[k - 1] = rows[i, k] + share * (rows[later, k] - rows[i, k]) if share > 0.0 else rows[i, k]
    return share, rows[i, 4], rows[later, 4]


@jit
def _shift(rows: Array, first: int, end: int, position: Array, yaw_rad: float) -> None:
    """Add to position (3,) and heading of the rows from `first` to before `end`."""
    for i in range(first, end):
        for k in range(3):
            rows[i, 1 + k] += position[k]
        rows[i, 4] += yaw_rad
