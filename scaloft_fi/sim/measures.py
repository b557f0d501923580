"""Optional signals of the ground truth: a study chooses them in addition to the signals that every flight has.

A plugin declares a signal with one decorated function, in a module that its entry point in the group
`scaloft_fi.plugins` names:

    @signal("tilt_deg", "deg", "angle between body z and the vertical")
    def tilt(scenario):
        return lambda state: math.degrees(math.acos(1.0 - 2.0 * (state[3] ** 2 + state[4] ** 2)))

A study that lists the signal under `signals` in `world.yaml` has it in its flight logs.  Requirements and predicates of
the study may use it, and the digest of a flight covers it.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from scaloft_fi.registry import Registry
from scaloft_fi.stack.messages import Array

Maker = Callable[[Any], "Measure"]
"""Called with the `sim.scenario.Scenario` of the flight: situation, world, route, camera."""
Measure = Callable[[Array], float]
"""Called at 20 Hz with the true state (13,) of the vehicle in the layout of `sim.vehicle`; returns the value."""


@dataclass(frozen=True)
class DeclaredSignal:
    """A signal that a study can choose.

    Attributes:
        name: unique name, with the unit at the end.
        unit: unit; "" for a dimensionless number.
        meaning: the meaning in words.
        make: makes the measure of a flight from its scenario; called once before the flight.
        most: greatest value; a formula may not compare the signal with a greater number.
    """

    name: str
    unit: str
    meaning: str
    make: Maker
    most: float = math.inf


SIGNALS = Registry[DeclaredSignal]("signal")


def signal(name: str, unit: str, meaning: str, *, most: float = math.inf) -> Callable[[Maker], Maker]:
    """Declare the decorated function (scenario) -> measure as the signal `name`.

    Raises:
        ValueError: the name is taken.
    """

    def declare(make: Maker) -> Maker:
        SIGNALS.declare(name, DeclaredSignal(name, unit, meaning, make, most))
        return make

    return declare


@signal("mass_kg", "kg", "mass of the vehicle, payload included")
def _mass_kg(scenario: Any) -> Measure:
    mass_kg: float = scenario.vehicle.mass_kg
    return lambda _state: mass_kg


@signal("takeoff_charge", "", "state of charge of the battery at take-off, 0..1", most=1.0)
def _takeoff_charge(scenario: Any) -> Measure:
    charge: float = scenario.sensors.battery.charge
    return lambda _state: charge
