"""The operators that fit any stack, one module a kind of deviation; importing this package declares them."""

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
