"""The estimator's recent past: where it believed to be and when, for fixes that come late."""

from __future__ import annotations

import math

import numpy as np

from scaloft_fi.stack.kernel import jit
from scaloft_fi.stack.messages import Array

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
        """Remember the estimate of `now_s`, and forget what is older than the span."""
        if self._end == len(self._rows):
            kept = self._rows[self._first :].copy()
            if 2 * len(kept) > len(self._rows):
                self._rows = np.empty((2 * len(self._rows), 5))
            self._rows[: len(kept)] = kept
            self._first, self._end = 0, len(kept)
        self._rows[self._end] = (now_s, *position.tolist(), yaw_rad)
        self._end += 1
        while now_s - self._rows[self._first, 0] > self._span_s:
            self._first += 1

    def at(self, stamp_s: float) -> tuple[Array, float]:
        """Position (3,) and heading at `stamp_s`, interpolated; the newest (or oldest) ones outside the history."""
        i = self._end - 1
        while i > self._first and not self._rows[i, 0] <= stamp_s:
            i -= 1
        begin_s, *position, yaw_rad = self._rows[i].tolist()
        if not begin_s <= stamp_s:
            return np.array(position), yaw_rad
        end_s, *later, later_rad = self._rows[min(i + 1, self._end - 1)].tolist()
        span_s = end_s - begin_s
        share = min(1.0, (stamp_s - begin_s) / span_s) if span_s > 0.0 else 0.0
        turned = math.remainder(later_rad - yaw_rad, 2.0 * math.pi)
        return np.array([p + share * (q - p) for p, q in zip(position, later, strict=True)]), yaw_rad + share * turned

    def shift(self, position: Array, yaw_rad: float) -> None:
        """A correction applies to the recent past as well, or late fixes would correct the same error twice."""
        _shift(self._rows, self._first, self._end, position, yaw_rad)


@jit
def _shift(rows: Array, first: int, end: int, position: Array, yaw_rad: float) -> None:
    """Add to position (3,) and heading of the rows from `first` to before `end`."""
    for i in range(first, end):
        for k in range(3):
            rows[i, 1 + k] += position[k]
        rows[i, 4] += yaw_rad
