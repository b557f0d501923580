"""Operators that fit any stack, one module for each kind of deviation; an import of this package declares them."""

from scaloft_fi.mutants.operator import OPERATORS
from scaloft_fi.mutants.operators import boxes, clock, event, image, inertial, power, presence, timing, value

__all__ = [
    "OPERATORS",
    "boxes",
    "clock",
    "event",
    "image",
    "inertial",
    "power",
    "presence",
    "timing",
    "value",
]
