"""Signals of the ground truth that a study may ask for, beside those that every flight has.

A signal of another author's package is one function and one declaration, in a module that the package's entry point in
the group `scaloft_fi.plugins` names:

    @signal("tilt_deg", "deg", "angle between body z and the vertical")
    def tilt(scenario):
        return lambda state: math.degrees(math.acos(1.0 - 2.0 * (state[3] ** 2 + state[4] ** 2)))

A study whose `world.yaml` lists it under `signals` has it in its flight logs; its requirements and its predicates may
speak of it, and the digest of a flight covers it.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from scaloft_fi.registry import Registry
from scaloft_fi.stack.fields import Array

Maker = Callable[[Any], "Measure"]
"""Called with the `sim.scenario.Scenario` of the flight: situation, world, route, camera."""
Measure = Callable[[Array], float]
"""(13,) true state of the vehicle, laid out as `sim.vehicle` says -> the signal's value; called at 20 Hz."""


@dataclass(frozen=True)
class DeclaredSignal:
    """A signal that a study may ask for.

    Attributes:
        name: unique name, with its unit at the end.
        unit: "" for a plain number.
        meaning: in words.
        make: the measure of a flight, made once from all that stands before the flight begins.
        most: the value is never greater; a formula may not compare it with more.
    """

    name: str
    unit: str
    meaning: str
    make: Maker
    most: float = math.inf


SIGNALS = Registry[DeclaredSignal]("signal")


def signal(name: str, unit: str, meaning: str, *, most: float = math.inf) -> Callable[[Maker], Maker]:
    """Declare the decorated factory (scenario) -> measure as signal `name`.

    Raises:
        ValueError: the name is taken.
    """

    def declare(make: Maker) -> Maker:
        SIGNALS.declare(name, DeclaredSignal(name, unit, meaning, make, most))
        return make

    return declare
