"""Small messages for the examples of operators that fit any stack."""

from __future__ import annotations

from typing import NamedTuple

from scaloft_fi.stack.fields import Stamp, Vector


class Reading(NamedTuple):
    """A number with its time."""

    stamp_s: Stamp
    value: float


class Move(NamedTuple):
    """A vector and an angle [rad] with their time."""

    stamp_s: Stamp
    velocity: Vector
    angle_rad: float


class Word(NamedTuple):
    """A text with its time."""

    stamp_s: Stamp
    word: str
