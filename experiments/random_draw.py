"""Draw random faults: a seam, an operator that fits its message, and arguments within what operator and study declare.

The draw reads no cell, ladder or default of the deviation matrix.  A seam is drawn with equal probability, then an
operator among those that its message allows, then each argument:

- a text or a switch: each allowed one with equal probability; so is the field, among those that the operator takes;
- a number whose declared bounds lie within the largest magnitude of its unit (`quantities`): uniform between them;
- a factor: log-uniform from 1/1000 to 1000; a number with two positive bounds: log-uniform between them;
- a place in the route, or a field of whole numbers: uniform over the places of the longest route;
- the time at which a fault begins: uniform over the shortest nominal mission, so that it comes in every situation; a
  fault that recurs does so after a time that is uniform up to that first one;
- any other number: a magnitude log-uniform over the three decades up to the largest of its unit, of either sign where
  the bounds allow both.

So the time of a fault is what its operator takes: from take-off to the end, from a drawn time on, or in drawn windows.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from scaloft_fi.hazop.matrix import Value
from scaloft_fi.mutants.mutant import Mutant
from scaloft_fi.mutants.operator import ALL, Argument, Operator
from scaloft_fi.mutants.operators import OPERATORS
from scaloft_fi.sim.vehicle import Vehicle
from scaloft_fi.stack.declaration import Declaration, Seam, unit_of
from scaloft_fi.stack.messages import field_type, number_fields, vector_fields
from scaloft_fi.streams import generator
from scaloft_fi.study import Study


def quantities(study: Study) -> dict[str, float]:
    """The largest magnitude of each unit, as `Seam.unit` names it and in it; "" is a plain number."""
    scenarios = [study.scenario(situation) for situation in study.grid.situations]
    vehicle, cells, mine = scenarios[0].vehicle, scenarios[0].sensors.battery, scenarios[0].world.mine
    xs, ys = zip(*(corner for ring in mine.footprint for corner in ring), strict=True)
    length_m = float(max(max(xs) - min(xs), max(ys) - min(ys)))
    force_mps2 = len(vehicle.rotors_m) * vehicle.max_thrust_n / vehicle.mass_kg
    return {
        "s": max(scenario.nominal_s for scenario in scenarios),  # the longest nominal mission of the grid
        "m": length_m,  # the longer side of the mine's ground plan
        "m/s2": force_mps2,  # greatest thrust of all rotors over the mass
        "m/s": math.sqrt(2 * force_mps2 * length_m),  # that acceleration over that length
        "rad": math.pi,  # half a turn
        "rad/s": math.sqrt(2 * _roll_radps2(vehicle) * math.pi),  # greatest roll torque over half a turn
        "deg": 360.0,  # a turn
        "N": vehicle.max_thrust_n,  # greatest thrust of a rotor
        "V": cells.cells * cells.full_cell_v,  # the full battery
        "EV": float(study.sim.stack.parameters["exposure"]["limit_ev"]),  # the limit of exposure control
        "": 1.0,  # the whole, for shares, confidences and gains
    }


def _roll_radps2(vehicle: Vehicle) -> float:
    """Greatest angular acceleration about the body's x axis: one side at full thrust, the other at none [rad/s2]."""
    arm_m = sum(y for _, y in vehicle.rotors_m if y > 0)
    return vehicle.max_thrust_n * arm_m / vehicle.inertia_kgm2[0]


GUIDEWORD = "RANDOM"
"""Of the ids of random faults; no guideword of the study has this name."""
DECADES = 3
TIMES = ("at_s", "period_s", "phase_s")
"""Arguments that say when a fault strikes; other times are durations."""
PACKAGES = ("scaloft_fi.mutants.operators", "scaloft_fi.mutants.reference")
"""Where the operators come from; plugins that happen to be installed have no part in the draw."""


@dataclass(frozen=True)
class Draw:
    """What faults are drawn from.

    Attributes:
        stack: declares the seams.
        quantities: the largest magnitude of each unit.
        places: number of waypoints in the longest route.
        shortest_s: the shortest nominal mission [s].
    """

    stack: Declaration
    quantities: Mapping[str, float]
    places: int
    shortest_s: float

    @classmethod
    def of(cls, study: Study) -> Draw:
        """What the study declares."""
        scenarios = [study.scenario(situation) for situation in study.grid.situations]
        places, shortest_s = max(len(one.route) for one in scenarios), min(one.nominal_s for one in scenarios)
        return cls(study.stack, quantities(study), places, shortest_s)

    def faults(self, number: int) -> tuple[Mutant, ...]:
        """The first `number` random faults; a fault that was drawn before is drawn anew."""
        drawn: dict[tuple[object, ...], Mutant] = {}
        attempt = 0
        while len(drawn) < number:
            fault = self.fault(len(drawn) + 1, generator("random fault", attempt))
            drawn.setdefault((fault.seam, fault.operator, *sorted(fault.arguments.items())), fault)
            attempt += 1
        return tuple(drawn.values())

    def fault(self, number: int, rng: np.random.Generator) -> Mutant:
        """A random fault whose id has the number `number`."""
        seam = self.stack.seams[int(rng.integers(len(self.stack.seams)))]
        fitting = self.fitting[seam.name]
        operator = fitting[int(rng.integers(len(fitting)))]
        arguments = operator.check(seam.name, seam.message, self.arguments(seam, operator, rng))
        name = f"{GUIDEWORD}-{seam.name}@{number}"
        return Mutant(name, GUIDEWORD, seam.name, str(number), 0.0, seam.name, operator.name, arguments)

    @cached_property
    def fitting(self) -> Mapping[str, tuple[Operator, ...]]:
        """The operators that fit each seam, by its name, in the order of their names; the identity is no fault."""
        return {seam.name: tuple(self._fitting(seam)) for seam in self.stack.seams}

    def _fitting(self, seam: Seam) -> Iterator[Operator]:
        for name in sorted(OPERATORS):
            operator = OPERATORS[name]
            known = operator.make.__module__.startswith(PACKAGES)
            takes_field = "field" not in operator.arguments or fields(seam, operator)
            if name != "identity" and known and operator.need.met_by(seam.message) and takes_field:
                yield operator

    def arguments(self, seam: Seam, operator: Operator, rng: np.random.Generator) -> dict[str, Value]:
        """Random arguments of an operator on a seam, not yet checked."""
        drawn: dict[str, Value] = self._times(operator, rng)
        for argument in sorted(operator.arguments.values(), key=lambda argument: argument.field is None):
            if argument.name in TIMES:
                continue
            if argument.field:
                drawn[argument.name] = _one_of(fields(seam, operator), rng)
            elif argument.name == "component" and "field" in drawn:
                vector = drawn["field"] in vector_fields(seam.message)
                drawn[argument.name] = _one_of(argument.choices, rng) if vector else ""
            elif argument.choices:
                drawn[argument.name] = _one_of(argument.choices, rng)
            elif argument.kind is bool:
                drawn[argument.name] = bool(rng.integers(2))
            elif argument.kind is not str:  # a free text keeps the operator's own
                drawn[argument.name] = self._number(argument, seam, str(drawn.get("field", "")), rng)
        return drawn

    def _times(self, operator: Operator, rng: np.random.Generator) -> dict[str, Value]:
        """When the fault strikes, where the operator takes a time [s]."""
        first_s = self.shortest_s * (1.0 - rng.random())
        if "period_s" in operator.arguments:
            period_s = first_s * (1.0 - rng.random())
            return {"period_s": _rounded(period_s), "phase_s": _rounded(first_s - period_s)}
        return {"at_s": _rounded(first_s)} if "at_s" in operator.arguments else {}

    def _number(self, argument: Argument, seam: Seam, field: str, rng: np.random.Generator) -> Value:
        kind = field_type(seam.message, field) if argument.of_field and field != ALL else argument.kind
        if kind is bool:
            return bool(rng.integers(2))
        least, most = max(argument.allowed.least, argument.allowed.above), argument.allowed.most
        if argument.name == "factor":
            return _rounded(_log_uniform(max(least, 10.0**-DECADES), min(most, 10.0**DECADES), rng))
        if least > 0.0 and math.isfinite(most) and kind is int:
            return round(_log_uniform(least, most, rng))
        if kind is int:
            return int(rng.integers(self.places))
        top = self._top(argument, seam, field)
        if -top <= least and most <= top:
            return _rounded(least + (most - least) * rng.random())
        magnitude = _log_uniform(top * 10.0**-DECADES, min(most, top), rng)
        return _rounded(-magnitude if least < 0.0 and rng.integers(2) else magnitude)

    def _top(self, argument: Argument, seam: Seam, field: str) -> float:
        """The largest magnitude of a number, in its unit."""
        if argument.name == "rate_hz":
            return seam.rate_hz
        return self.quantities[_unit(argument, seam, field)]


def fields(seam: Seam, operator: Operator) -> tuple[str, ...]:
    """The fields of a seam that an operator can take.

    Left out are a field that is no vector where a component must be named, a field that is no angle where it is turned,
    texts, whose allowed values no declaration has, and all fields at once where one number would have several units.
    """
    arguments, message = operator.arguments, seam.message
    if "component" in arguments and arguments["component"].required:
        return vector_fields(message)
    if any(argument.of_field for argument in arguments.values()):
        single = tuple(name for name in message.__annotations__ if field_type(message, name) in (float, int, bool))
        numbers = number_fields(message)
        alike = {seam.unit(name) for name in numbers}, {field_type(message, name) for name in numbers}
        return (*single, ALL) if len(numbers) > 1 and all(len(one) == 1 for one in alike) else single
    if "angle_deg" in arguments:
        return tuple(name for name in number_fields(message) if seam.unit(name) == "rad")
    units = {seam.unit(name) for name in number_fields(message)}
    in_unit = any(_in_unit_of_field(argument) for argument in arguments.values())
    several = len(number_fields(message)) > 1 and (len(units) == 1 or not in_unit)
    return (*number_fields(message), ALL) if several else number_fields(message)


def _in_unit_of_field(argument: Argument) -> bool:
    return argument.of_field or argument.name in ("amount", "sigma")


def _unit(argument: Argument, seam: Seam, field: str) -> str:
    """The unit of a number: of the field where it has the field's unit, else the ending of its name."""
    if _in_unit_of_field(argument):
        return seam.unit(number_fields(seam.message)[0] if field == ALL else field)
    return unit_of(argument.name)


def _one_of(texts: tuple[str, ...], rng: np.random.Generator) -> str:
    return texts[int(rng.integers(len(texts)))]


def _log_uniform(least: float, most: float, rng: np.random.Generator) -> float:
    return float(least * (most / least) ** rng.random())


def _rounded(number: float) -> float:
    """Four significant digits, as the file of faults has them."""
    return float(f"{number:.4g}")
