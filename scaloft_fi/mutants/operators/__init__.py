"""The operators, one module a kind of deviation; importing this package declares them all."""

from scaloft_fi.mutants.operator import OPERATORS
from scaloft_fi.mutants.operators import event, presence, timing, value
from scaloft_fi.mutants.reference import (
    clock,
    collision,
    depth,
    goal,
    inertial,
    limits,
    mapping,
    person,
    pose,
    power,
    route,
)

__all__ = [
    "OPERATORS",
    "clock",
    "collision",
    "depth",
    "event",
    "goal",
    "inertial",
    "limits",
    "mapping",
    "person",
    "pose",
    "power",
    "presence",
    "route",
    "timing",
    "value",
]
