"""The stored trajectory of a flight, decimated to 5 Hz: position, speed, clearances."""

from __future__ import annotations

import zlib
from array import array
from collections.abc import Callable, Mapping, Sequence

from scaloft_fi.judge.stl import Signals

TRACK: Mapping[str, Callable[[Sequence[float]], float]] = {
    "elapsed_s": lambda values: values[-1],
    "x_m": lambda values: values[-1],
    "y_m": lambda values: values[-1],
    "z_m": lambda values: values[-1],
    "speed_mps": max,
    "clearance_m": min,
    "person_sight_m": min,
}
"""The stored signals; each with the function that reduces the samples since the last stored one to one value."""
TRACK_COLUMNS = tuple(TRACK)
TRACK_EVERY = 4
"""Every fourth sample of 20 Hz is stored: 5 Hz."""


def pack_track(signals: Signals) -> bytes:
    """Pack the trajectory at 5 Hz as single floats; it always includes the first and the last sample.

    Args:
        signals: (T,) samples at 20 Hz of at least the signals in `TRACK_COLUMNS`.
    """
    columns = [list(map(float, signals[name])) for name in TRACK_COLUMNS]
    length = len(columns[0])
    kept = sorted({*range(0, length, TRACK_EVERY), length - 1})
    spans = list(zip([-1, *kept], kept, strict=False))
    rows = (stands(column[last + 1 : now + 1]) for last, now in spans for column, stands in _pairs(columns))
    return zlib.compress(array("f", rows).tobytes(), 6)


def _pairs(columns: list[list[float]]) -> list[tuple[list[float], Callable[[Sequence[float]], float]]]:
    return list(zip(columns, TRACK.values(), strict=True))


def unpack_track(track: bytes) -> list[tuple[float, ...]]:
    """Unpack the rows of `TRACK_COLUMNS`; an empty track has no rows."""
    if not track:
        return []
    values = array("f")
    values.frombytes(zlib.decompress(track))
    width = len(TRACK_COLUMNS)
    return [tuple(values[i : i + width]) for i in range(0, len(values), width)]
