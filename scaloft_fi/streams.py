"""Streams of noise: a sample depends only on the name of its stream and on its index, not on earlier draws.

The name of a sensor's stream is (situation, seed, channel), the name of a tap's stream (mutant, situation, seed, seam).
"""

from __future__ import annotations

import hashlib
from typing import Final

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

CHUNK: Final = 1024
"""Number of rows that are drawn at once."""


def key_words(*parts: object) -> tuple[int, int]:
    """Two 64-bit words that identify a stream: the first 16 bytes of SHA-256 over the parts, joined by newlines.

    >>> key_words("T0O0W0D0H0", 0, "imu") == key_words("T0O0W0D0H0", 0, "imu")
    True
    """
    digest = hashlib.sha256("\n".join(map(str, parts)).encode()).digest()
    return int.from_bytes(digest[:8], "little"), int.from_bytes(digest[8:16], "little")


def generator(*parts: object, block: int = 0) -> np.random.Generator:
    """A counter-based generator (Philox 4x64) at `block` of the stream that `parts` name; blocks never overlap."""
    return np.random.Generator(np.random.Philox(key=np.array(key_words(*parts), np.uint64), counter=[0, 0, block, 0]))


class Table:
    """Rows of random numbers by index, drawn in chunks; row i is always the same, in whatever order rows are read.

    Args:
        width: numbers in a row.
        parts: name of the stream.
        uniform: draw numbers from 0 to 1 instead of standard normal numbers.

    >>> rows = Table(3, "T0O0W0D0H0", 0, "imu")
    >>> late, early = rows.row(5000).copy(), rows.row(1)
    >>> bool((rows.row(5000) == late).all())
    True
    """

    def __init__(self, width: int, *parts: object, uniform: bool = False) -> None:
        self._width = width
        self._parts = parts
        self._uniform = uniform
        self._block = -1
        self._chunk: Array = np.empty((0, width))

    def row(self, index: int) -> Array:
        """Row `index` (width,) of the table; read only."""
        chunk, offset = self.place(index)
        row: Array = chunk[offset]
        return row

    def place(self, index: int) -> tuple[Array, int]:
        """The chunk (CHUNK, width) that holds row `index`, read only, and the position of the row in the chunk."""
        block, offset = divmod(index, CHUNK)
        if block != self._block:
            draw = generator(*self._parts, block=block)
            shape = (CHUNK, self._width)
            self._block = block
            self._chunk = draw.random(shape) if self._uniform else draw.standard_normal(shape)
        return self._chunk, offset
