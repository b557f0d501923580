"""Trajectories for the page: whole numbers, without what is the baseline's, as differences in two planes of bytes.

A track is rows, one value a column.  Each value is divided by its column's quantum and rounded.  The rows at the start
that equal the baseline's are only counted.  Of the rest each column is written by itself, value minus the value of the
row before, modulo 2^16, zigzag coded (0, -1, 1, -2 ... -> 0, 1, 2, 3 ...): first all low bytes, then all high bytes,
which are nearly always zero.  Deflate then makes less than two bytes of a row of seven columns.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from scaloft_fi.judge.outcome import TRACK
from scaloft_fi.sim.log import FAR_M

Whole = NDArray[np.int32]
"""A track as whole numbers, (T, columns)."""

TIME, TIME_QUANTUM = "elapsed_s", 0.05
"""The log runs at 20 Hz, so 0.05 s is exact."""
QUANTUM = 0.01
"""One centimetre, one centimetre per second: half a pixel of the page's map."""
PLACES = ("x_m", "y_m", "z_m")
"""Columns in which a large value is a place; in every other length `FAR_M` says that there was nothing to measure."""
FAR = 2**15 - 1
"""Stands for what was not there to be measured."""
WORD = 2**16


def quantum(column: str, coarse: int = 1) -> float:
    """The step of a column, in the column's unit; `coarse` widens every step but that of time."""
    return TIME_QUANTUM if column == TIME else QUANTUM * coarse


def thinned(rows: Sequence[tuple[float, ...]], every: int) -> list[tuple[float, ...]]:
    """One row for each `every` rows, and always the first and the last; it keeps their worst values, as `TRACK` says.

    >>> thinned([(0.0, 0, 0, 0, 0.1, 5, 9), (0.2, 1, 0, 0, 0.7, 4, 9), (0.4, 2, 0, 0, 0.2, 6, 9)], 2)[1]
    (0.4, 2, 0, 0, 0.7, 4, 9)
    """
    if every == 1 or not rows:
        return list(rows)
    kept = sorted({*range(0, len(rows), every), len(rows) - 1})
    spans = zip([-1, *kept], kept, strict=False)
    return [
        tuple(
            stands(column)
            for stands, column in zip(TRACK.values(), zip(*rows[last + 1 : now + 1], strict=True), strict=True)
        )
        for last, now in spans
    ]


def quantised(rows: Sequence[tuple[float, ...]], columns: Sequence[str], coarse: int = 1) -> Whole:
    """Rows as whole numbers of each column's quantum, smaller than `FAR`; what was not there to be measured is `FAR`.

    >>> quantised([(0.2, 1.006, 100.0)], ("elapsed_s", "x_m", "person_sight_m")).tolist()
    [[4, 101, 32767]]
    """
    values = np.asarray(rows, dtype=float).reshape(len(rows), len(columns))
    steps = np.array([quantum(column, coarse) for column in columns])
    most = np.array([FAR_M if column.endswith("_m") and column not in PLACES else math.inf for column in columns])
    whole = np.clip(np.rint(values / steps), 1 - FAR, FAR - 1)
    return np.where(values < most, whole, FAR).astype(np.int32)


def shared(rows: Whole, baseline: Whole) -> int:
    """How many rows at the start are the baseline's."""
    length = min(len(rows), len(baseline))
    differ = np.flatnonzero((rows[:length] != baseline[:length]).any(axis=1))
    return int(differ[0]) if len(differ) else length


def coded(rows: Whole, same: int = 0) -> bytes:
    """The rows after the first `same` as two planes of bytes, column by column."""
    before = rows[same - 1 : same] if same else np.zeros((1, rows.shape[1]), dtype=np.int32)
    words = zigzag(np.diff(rows[same:], axis=0, prepend=before)).T.ravel()
    return (words & 255).astype(np.uint8).tobytes() + (words >> 8).astype(np.uint8).tobytes()


def zigzag(differences: Whole) -> Whole:
    """Differences modulo 2^16 as numbers that are small when the difference is.

    >>> zigzag(np.array([0, -1, 1, -2, 65535])).tolist()
    [0, 1, 2, 3, 1]
    """
    signed = (differences + WORD // 2) % WORD - WORD // 2
    return (signed << 1 ^ signed >> 15) % WORD
