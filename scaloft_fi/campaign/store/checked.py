"""Make an outcome from values that another machine sent: the checks of the store, and what a flight decides itself."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from typing import Any, Final

from scaloft_fi.campaign.store.cells import MOST_CELL_BYTES, TooLargeError
from scaloft_fi.campaign.store.record import COLUMNS, Reader
from scaloft_fi.judge.outcome import TRACK_COLUMNS, Outcome, track_values
from scaloft_fi.sim.log import Ending

MOST_TRACK_BYTES: Final = 1 << 20
"""Greatest size of an unpacked track; the largest of the reference campaign has 29,316 bytes, of 209 s [bytes]."""
MOST_ENTRIES: Final = 1000
"""Greatest number of readings, violations or axes of an outcome."""
_TYPES: Mapping[str, tuple[type, ...]] = {"TEXT": (str,), "INTEGER": (int,), "REAL": (int, float)}
"""Python's types of a column's values; a truth value is no number here."""
_DIGEST = re.compile(r"[0-9a-f]{64}")
_ENDINGS = {ending.value for ending in Ending}
_RULES: Mapping[str, Callable[[Any], bool]] = {
    "ending": _ENDINGS.__contains__,
    "digest": lambda text: _DIGEST.fullmatch(text) is not None,
    "perceived_digest": lambda text: _DIGEST.fullmatch(text) is not None,
    "duration_s": lambda number: number >= 0,
}


def checked(row: object, track: bytes) -> Outcome:
    """The outcome of the values of `COLUMNS` and a packed track; a store that keeps it can be read.

    Raises:
        ValueError: a value is of another type, no finite number, or out of its range; the message names its column.
    """
    if not isinstance(row, list) or len(row) != len(COLUMNS):
        raise ValueError(f"an outcome is a list of {len(COLUMNS)} values")
    values = dict(zip(COLUMNS, row, strict=True))
    for name, value in values.items():
        if type(value) not in _TYPES[COLUMNS[name]] and not (name == "infected_at_s" and value is None):
            raise ValueError(f"{name} is no {COLUMNS[name]}")
        if isinstance(value, str) and (len(value) > MOST_CELL_BYTES or value.count("\n") >= MOST_ENTRIES):
            raise ValueError(f"{name} is too long")
    try:
        (outcome,) = Reader()([tuple(row)], [track])
    except TooLargeError as error:
        raise ValueError(str(error)) from error
    for name, is_right in _RULES.items():
        if not is_right(values[name]) and not (outcome.invalid and values[name] == ""):
            raise ValueError(f"{name} is out of its range")
    try:
        track_values(track, MOST_TRACK_BYTES // (4 * len(TRACK_COLUMNS)))
    except ValueError as error:
        raise ValueError(f"the track is {error}") from error
    return outcome
