"""How large a number of each unit may be: computed from what the study declares of mine, vehicle, sensors and stack."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from scaloft_fi.sim.vehicle import Vehicle
from scaloft_fi.study import Study


@dataclass(frozen=True)
class Quantity:
    """The largest magnitude of a unit.

    Attributes:
        unit: as `Seam.unit` names it; "" is a plain number.
        most: the magnitude, in the unit.
        source: what it is computed from, in words.
    """

    unit: str
    most: float
    source: str


def quantities(study: Study) -> dict[str, Quantity]:
    """The largest magnitude of each unit, by unit."""
    return {quantity.unit: quantity for quantity in _quantities(study)}


def places(study: Study) -> int:
    """Number of waypoints in the longest route of the grid."""
    return max(len(study.scenario(situation).route) for situation in study.grid.situations)


def shortest_s(study: Study) -> float:
    """The shortest nominal mission of the grid [s]."""
    return min(study.scenario(situation).nominal_s for situation in study.grid.situations)


def _quantities(study: Study) -> Iterator[Quantity]:
    scenarios = [study.scenario(situation) for situation in study.grid.situations]
    scenario = scenarios[0]
    vehicle, cells = scenario.vehicle, scenario.sensors.battery
    length_m = _length_m([corner for ring in scenario.world.mine.footprint for corner in ring])
    force_mps2 = len(vehicle.rotors_m) * vehicle.max_thrust_n / vehicle.mass_kg
    yield Quantity("s", max(s.nominal_s for s in scenarios), "the longest nominal mission of the grid")
    yield Quantity("m", length_m, "the longer side of the mine's ground plan")
    yield Quantity("m/s2", force_mps2, "greatest thrust of all rotors over the mass")
    yield Quantity("m/s", math.sqrt(2 * force_mps2 * length_m), "that acceleration over that length")
    yield Quantity("rad", math.pi, "half a turn")
    yield Quantity("rad/s", math.sqrt(2 * _roll_radps2(vehicle) * math.pi), "greatest roll torque over half a turn")
    yield Quantity("deg", 360.0, "a turn")
    yield Quantity("N", vehicle.max_thrust_n, "greatest thrust of a rotor")
    yield Quantity("V", cells.cells * cells.full_cell_v, "the full battery")
    yield Quantity("EV", float(study.sim.stack.parameters["exposure"]["limit_ev"]), "the limit of exposure control")
    yield Quantity("", 1.0, "the whole, for shares, confidences and gains")


def _length_m(corners: list[tuple[float, float]]) -> float:
    xs, ys = zip(*corners, strict=True)
    return float(max(max(xs) - min(xs), max(ys) - min(ys)))


def _roll_radps2(vehicle: Vehicle) -> float:
    """Greatest angular acceleration about the body's x axis: one side at full thrust, the other at none [rad/s2]."""
    arm_m = sum(y for _, y in vehicle.rotors_m if y > 0)
    return vehicle.max_thrust_n * arm_m / vehicle.inertia_kgm2[0]
