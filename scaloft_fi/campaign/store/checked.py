"""Make an outcome from values that another machine sent; every value is checked first."""

from __future__ import annotations

import json
import math
import re
import zlib
from array import array
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Final

from scaloft_fi.campaign.store.record import COLUMNS, Reader
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.judge.requirement import Kind
from scaloft_fi.judge.track import TRACK_COLUMNS
from scaloft_fi.sim.log import Ending

MOST_TRACK_BYTES: Final = 1 << 20
"""Greatest size of an unpacked track; the largest of the reference campaign has 29,316 bytes, of 209 s [bytes]."""
MOST_ENTRIES: Final = 1000
"""Greatest number of readings, violations or axes of an outcome."""
_MOST = 1e300
_DIGEST = re.compile(r"[0-9a-f]{64}")
_ENDINGS = {ending.value for ending in Ending}
_KINDS = {kind.value for kind in Kind}

Check = Callable[[Any], bool]


def checked(row: object, track: bytes) -> Outcome:
    """The outcome of the values of `COLUMNS` and a packed track.

    Raises:
        ValueError: a value is of another type, no finite number, or out of its range; the message names its column.
    """
    if not isinstance(row, list) or len(row) != len(COLUMNS):
        raise ValueError(f"an outcome is a list of {len(COLUMNS)} values")
    values = dict(zip(COLUMNS, row, strict=True))
    for name, value in values.items():
        if not _TYPES[COLUMNS[name]](value) and not (name == "infected_at_s" and value is None):
            raise ValueError(f"{name} is no {COLUMNS[name]}")
    valid = not values["invalid"]
    for name, is_right in _RULES.items():
        if not is_right(values[name]) and (valid or values[name] != ""):
            raise ValueError(f"{name} is out of its range")
    for name, entry in _ENTRIES.items():
        _check_lines(name, values[name], entry)
    _check_track(track)
    return Reader()([tuple(row)], [track])[0]


def _is_text(value: object) -> bool:
    return isinstance(value, str) and "\0" not in value


def _is_count(value: object) -> bool:
    return type(value) is int and 0 <= value < 1 << 63


def _is_number(value: object) -> bool:
    return type(value) in (int, float) and -_MOST <= value <= _MOST  # type: ignore[operator]


def _is_number_or_none(value: object) -> bool:
    return value is None or _is_number(value)


def _is_flag(value: object) -> bool:
    return isinstance(value, bool)


def _is_kind(value: object) -> bool:
    return isinstance(value, str) and value in _KINDS


_TYPES: Mapping[str, Check] = {"TEXT": _is_text, "INTEGER": _is_count, "REAL": _is_number}
_RULES: Mapping[str, Check] = {
    "ending": _ENDINGS.__contains__,
    "digest": lambda text: _DIGEST.fullmatch(text) is not None,
    "perceived_digest": lambda text: _DIGEST.fullmatch(text) is not None,
    "duration_s": lambda number: number >= 0,
}
_ENTRIES: Mapping[str, Sequence[Check]] = {
    "readings": (_is_text, _is_kind, _is_number, _is_number_or_none, _is_count, _is_flag),
    "violations": (_is_text, _is_kind, _is_number, _is_number, _is_number, _is_number, _is_text),
    "realised": (_is_text, _is_flag),
}


def _check_lines(name: str, text: str, entry: Sequence[Check]) -> None:
    lines = text.split("\n") if text else []
    if len(lines) > MOST_ENTRIES:
        raise ValueError(f"{name} has more than {MOST_ENTRIES} entries")
    for line in lines:
        try:
            values = json.loads(line)
        except (ValueError, RecursionError) as error:
            raise ValueError(f"{name} is no JSON") from error
        fits = isinstance(values, list) and len(values) == len(entry)
        if not fits or not all(check(value) for check, value in zip(entry, values, strict=True)):
            raise ValueError(f"an entry of {name} has values of other types")


def _check_track(track: bytes) -> None:
    if not track:
        return
    unpacking = zlib.decompressobj()
    try:
        content = unpacking.decompress(track, MOST_TRACK_BYTES)
    except zlib.error as error:
        raise ValueError("the track is not packed") from error
    values = array("f")
    if not unpacking.eof or unpacking.unused_data or len(content) % (values.itemsize * len(TRACK_COLUMNS)):
        raise ValueError(
            f"the track has no whole rows of {len(TRACK_COLUMNS)} values, or over {MOST_TRACK_BYTES} bytes"
        )
    values.frombytes(content)
    if not all(map(math.isfinite, values)):
        raise ValueError("a value of the track is not finite")
