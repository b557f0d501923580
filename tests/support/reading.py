"""An independent reader of the page: what a person's own script would do with it."""

from __future__ import annotations

import base64
import json
import re
import struct
import zlib
from typing import Any


def embedded(text: str, name: str) -> Any:
    """The JSON of a script element by its id."""
    found = re.findall(rf'<script type="application/json" id="{name}">(.*?)</script>', text, re.DOTALL)
    assert len(found) == 1
    return json.loads(found[0])


def unpacked(pack: str, quanta: list[float]) -> list[dict[str, Any]]:
    """The flights of a pack, each with its rows as whole numbers times the quantum."""
    data = zlib.decompress(base64.b64decode(pack))
    (length,) = struct.unpack_from("<I", data)
    told = json.loads(data[4 : 4 + length])
    at = 4 + length
    tracks: list[list[list[int]]] = []
    for count, same, base in told["tracks"]:
        own = count - same
        size = own * len(quanta)
        low, high = data[at : at + size], data[at + size : at + 2 * size]
        at += 2 * size
        rows = [list(row) for row in tracks[base][:same]] if same else []
        fresh = [[0] * len(quanta) for _ in range(own)]
        for column in range(len(quanta)):
            value = rows[-1][column] if rows else 0
            for row in range(own):
                word = low[column * own + row] + 256 * high[column * own + row]
                value += word // 2 if word % 2 == 0 else -(word + 1) // 2
                value = (value + 32768) % 65536 - 32768
                fresh[row][column] = value
        tracks.append(rows + fresh)
    assert at == len(data)
    return [
        flight | {"rows": None if flight["track"] is None else _scaled(tracks[flight["track"]], quanta)}
        for flight in told["flights"]
    ]


def _scaled(rows: list[list[int]], quanta: list[float]) -> list[list[float]]:
    return [[value * quantum for value, quantum in zip(row, quanta, strict=True)] for row in rows]
