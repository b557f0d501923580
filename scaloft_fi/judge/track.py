"""The stored trajectory of a flight, decimated to 5 Hz: position, speed, clearances."""

from __future__ import annotations

import math
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
MOST_ROWS = 24 * 3600 * 5
"""Greatest number of rows of a track that is unpacked: a day."""
_ROW_BYTES = 4 * len(TRACK_COLUMNS)


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
    """Unpack the rows of `TRACK_COLUMNS`; an empty track has no rows.

    Raises:
        ValueError: the track is damaged, or has more than `MOST_ROWS` rows.
    """
    values, width = track_values(track), len(TRACK_COLUMNS)
    return [tuple(values[i : i + width]) for i in range(0, len(values), width)]


def track_values(track: bytes, most_rows: int = MOST_ROWS) -> array[float]:
    """Unpack the values of a track, row by row; an empty track has none.

    Args:
        track: a packed track, from anywhere.
        most_rows: greatest number of rows; no more memory is used, however many the track has.

    Raises:
        ValueError: the track is damaged, has more rows, or has a number that is not finite.
    """
    values = array("f")
    if not track:
        return values
    unpacking = zlib.decompressobj()
    try:
        content = unpacking.decompress(track, most_rows * _ROW_BYTES + 1)
    except zlib.error as error:
        raise ValueError("damaged") from error
    if len(content) > most_rows * _ROW_BYTES:
        raise ValueError(f"longer than {most_rows} rows")
    if not unpacking.eof or unpacking.unused_data or len(content) % _ROW_BYTES:
        raise ValueError("damaged")
    values.frombytes(content)
    if not math.isfinite(sum(values)):
        raise ValueError("not finite")
    return values
