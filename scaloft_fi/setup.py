"""The part of a study that decides a flight and its judgement: world, vehicle, sensors, situations, requirements."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from scaloft_fi.document import is_there, load
from scaloft_fi.errors import InputError
from scaloft_fi.judge.requirement import Check, Requirement, check_caps, load_requirements, within_caps
from scaloft_fi.judge.space import Realisation, Space
from scaloft_fi.judge.stl import Formula, FormulaError
from scaloft_fi.registry import in_one_line
from scaloft_fi.sim.grid import Grid, load_grid
from scaloft_fi.sim.log import SIGNALS, signal_names
from scaloft_fi.sim.situation import Situation
from scaloft_fi.sim.stacks import StackChoice
from scaloft_fi.stack.declaration import Declaration

if TYPE_CHECKING:
    from scaloft_fi.outside.command import FlightCommand
    from scaloft_fi.outside.records import RecordMap
    from scaloft_fi.sim.load import Scenario, SimConfig


@dataclass(frozen=True)
class Setup:
    """The setup of flights; each part is read at its first use.

    Attributes:
        folder: folder of the study; its `sim/` is read.
        grid_name: name of a further grid of the study, a file in `sim/grids/`; None for its own grid.
    """

    folder: Path
    grid_name: str | None = None

    @cached_property
    def command(self) -> FlightCommand | None:
        """The command that flies, where `sim/flyer.yaml` declares one; None = our simulator flies.

        Raises:
            InputError: the file declares no command.
        """
        path = self.folder / "sim" / "flyer.yaml"
        if not is_there(path):
            return None
        # by name: the keys of a study without a command leave out what reads one
        command: FlightCommand = import_module("scaloft_fi.outside.command").load_command(path)
        return command

    @cached_property
    def stack(self) -> Declaration:
        """The declaration of the stack that `sim/stack.yaml` names; its own operators are declared with it.

        Of a stack that a command flies only the seams count that `sim/flyer.yaml` offers.

        Raises:
            InputError: there is no such stack, or its operators cannot be loaded.
        """
        declared = StackChoice.read(load(self.folder / "sim" / "stack.yaml")).declaration
        for module in declared.operators:
            try:
                import_module(module)
            except Exception as error:
                sentence = f"stack {declared.name!r}: its operators in {module!r} cannot be loaded"
                raise InputError(f"{sentence}: {in_one_line(error)}") from error
        return self.command.declared(declared) if self.command else declared

    @cached_property
    def sim(self) -> SimConfig:
        """Mine, vehicle, sensors, stack and situations."""
        from scaloft_fi.sim.load import load as load_sim

        return load_sim(self.folder / "sim", grid=self.grid)

    @cached_property
    def grid(self) -> Grid:
        """The situations.  Verbs that only read results build no worlds; `sim` proves that the worlds are possible.

        Raises:
            InputError: a predicate of an axis compares a signal with a threshold beyond its cap.
        """
        grid = load_grid(self.folder / "sim", self.grid_name)
        caps = self._caps(grid)
        for axis in grid.axes if self.command is None else ():
            for value in (*axis.values, *axis.extremes):
                try:
                    check_caps(value.realised, caps)
                except FormulaError as error:
                    raise InputError(f"{value.place}: realised of {axis.id}{value.id} {error}") from error
        return grid

    @cached_property
    def signals(self) -> tuple[str, ...]:
        """Names of the signals that requirements and situations may use; a command adds those of its record."""
        world = self.grid.recorded
        ours = signal_names(world.surfaces, self.stack.beliefs, world.signals)
        path = self.folder / "sim" / "record.yaml"
        if self.command is None or not is_there(path):
            return ours
        mapping: RecordMap = import_module("scaloft_fi.outside.records").load_record_map(path)
        return tuple(dict.fromkeys((*ours, *mapping.signals)))

    @cached_property
    def caps(self) -> Mapping[str, float]:
        """The cap of each belief and each optional signal that has one."""
        return self._caps(self.grid)

    def _caps(self, grid: Grid) -> Mapping[str, float]:
        optional = (SIGNALS[name] for name in grid.recorded.signals)
        return {**self.stack.caps, **{signal.name: signal.most for signal in optional if math.isfinite(signal.most)}}

    @cached_property
    def requirements(self) -> tuple[Requirement, ...]:
        """The requirements; a simulator that a command starts has no caps of ours."""
        if self.command is not None:
            return self.requirements_over(())
        return self._requirements(self.signals, within_caps(Formula.parse, self.caps))

    def requirements_over(self, recorded: Iterable[str]) -> tuple[Requirement, ...]:
        """The requirements, over any signal that is `recorded` besides; what a record measures has no caps of ours."""
        return self._requirements(tuple(dict.fromkeys((*self.signals, *recorded))), Formula.parse)

    def _requirements(self, signals: Sequence[str], check: Check) -> tuple[Requirement, ...]:
        return load_requirements(self.folder / "sim" / "requirements.yaml", signals, check)

    @cached_property
    def space(self) -> Space:
        """The situation space for scores and coverage."""
        return Space.of(self.grid)

    @cached_property
    def realisation(self) -> Realisation:
        """Judges whether a flight met its situation.

        Raises:
            InputError: a predicate of an axis is no formula over the signals of the log.
        """
        return Realisation.read(self.grid, (*self.signals, *self.grid.passing_signals))

    def scenario(self, situation: Situation) -> Scenario:
        """The scenario of the situation."""
        return self.sim.scenario(situation)

    def expected_s(self, situation: Situation) -> float:
        """Expected duration of a flight in the situation: its nominal mission time [s]."""
        return self.scenario(situation).nominal_s

    def limit_s(self, situation: Situation) -> float:
        """Time limit of a flight in the situation [s]."""
        return self.scenario(situation).t_max_s

    def runner(self, situation: Situation) -> str:
        """What flies the situation: one run of it flies all situations of the same runner, for one subject and seed."""
        return situation.key

    @property
    def most_wall_s(self) -> float:
        """Longest wall time of a flight that ends itself after it [s]; 0 for our simulator, which ends by itself."""
        return self.command.limit_s if self.command else 0.0

    def changes(self, situation: Situation) -> dict[str, Any]:
        """The values that the situation sets in the documents of world, vehicle and sensors, by dotted path."""
        values = self.grid.values(situation).values()
        return {path: item.plain() for value in values for path, item in value.changes.items()}

    def realised(self, situation: Situation) -> dict[str, Any]:
        """The predicates of the situation's values by axis; for a benign value, the predicates of the other values."""
        values = self.grid.values(situation)
        return {
            axis.id: values[axis.id].realised or [other.realised for other in axis.values] for axis in self.grid.axes
        }
