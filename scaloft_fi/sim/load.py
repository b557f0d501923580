"""Read the simulation part of a study: world, vehicle, sensors, situations, stack, sources of the numbers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from scaloft_fi.document import Item
from scaloft_fi.document import load as load_document
from scaloft_fi.errors import InputError, did_you_mean
from scaloft_fi.reading import is_there
from scaloft_fi.sim.grid import Grid, read_grid
from scaloft_fi.sim.patch import leaves, overridden
from scaloft_fi.sim.scenario import Scenario
from scaloft_fi.sim.sensors import SensorsConfig, read_sensors
from scaloft_fi.sim.situation import Situation
from scaloft_fi.sim.vehicle import Vehicle, read_vehicle
from scaloft_fi.sim.world import World, read_world
from scaloft_fi.stack.config import ConfigError, build
from scaloft_fi.stack.declaration import Declaration

DOCUMENTS = ("world", "vehicle", "sensors", "situations", "stack")
MOST_NOMINAL_S = 3_600.0
"""Longest nominal mission time [s]: no battery lasts longer, and a log grows by some 10 kB each second."""
KINDS = ("published", "datasheet", "derived", "assumption")


@dataclass(frozen=True)
class Source:
    """The source of a number.  kind: one of `KINDS`; text: the source, or the reason of an assumption."""

    kind: str
    text: str


@dataclass(frozen=True, eq=False)
class StackChoice:
    """The choice of the stack.

    Attributes:
        name: name in the registry of stacks.
        parameters: settings of the stack, plain data.
        document: the document of the settings, for the places of errors.
    """

    name: str
    parameters: Mapping[str, Any]
    document: Item

    def settings(self, declared: Declaration) -> Any:
        """The settings in the schema that the stack declares.

        Raises:
            InputError: the settings do not fit; the message names the place.
        """
        if declared.settings is None:
            return self.parameters
        try:
            return build(declared.settings(), self.parameters)
        except ConfigError as error:
            raise InputError(f"{self.place_of(error.path)}: {error}") from error

    def place_of(self, path: str) -> str:
        """`file:line` of the setting at `path`, such as `stack.mission.goal_radius_m`, or of its nearest parent."""
        item = self.document
        for key in path.replace("[", ".").split(".")[1:]:
            inner = item.value.get(key) if isinstance(item.value, dict) else None
            if inner is None:
                break
            item = inner
        return item.place


@dataclass(frozen=True, eq=False)
class SimConfig:
    """The simulation part of a study.

    Attributes:
        world: the world with every axis at its benign value.
        vehicle: the vehicle.
        sensors: settings of the sensors.
        grid: the situations.
        stack: the stack under test.
        sources: source by dotted path; a path covers all paths below it.
        numbers: every number of the study's `sim/` by dotted path.
    """

    world: World
    vehicle: Vehicle
    sensors: SensorsConfig
    grid: Grid
    stack: StackChoice
    sources: Mapping[str, Source]
    numbers: Mapping[str, float]
    _scenarios: dict[str, Scenario] = field(default_factory=dict, repr=False)

    def scenario(self, situation: Situation) -> Scenario:
        """The scenario of a situation, made once.

        Raises:
            InputError: the values of the axes contradict each other, or the mission takes too long.
        """
        if situation.key not in self._scenarios:
            world = self.grid.world(situation.levels)
            scenario = Scenario(situation, world, self.sensors.depth.camera)
            if not scenario.nominal_s <= MOST_NOMINAL_S:
                place = self.grid.document.need("mission").place
                lasts = f"the mission in {situation.key} must last at most {MOST_NOMINAL_S:,.0f} s"
                raise InputError(f"{place}: {lasts} at its speeds, it lasts {scenario.nominal_s:,.0f} s")
            self._scenarios[situation.key] = scenario
        return self._scenarios[situation.key]

    def source_of(self, path: str) -> Source | None:
        """The source of the number at `path`, or of its nearest parent with a source."""
        parts = path.split(".")
        for length in range(len(parts), 0, -1):
            source = self.sources.get(".".join(parts[:length]))
            if source is not None:
                return source
        return None

    @property
    def assumptions(self) -> dict[str, float]:
        """The assumed numbers by path."""
        return {
            path: value
            for path, value in self.numbers.items()
            if (s := self.source_of(path)) and s.kind == "assumption"
        }


def load(
    folder: Path, overrides: Mapping[str, float | str | bool] | None = None, *, grid: Grid | None = None
) -> SimConfig:
    """Read a study's `sim` folder; it need not have a `sources.yaml`.

    Args:
        folder: the folder.
        overrides: values by dotted path that replace values of the files, such as `{"sensors.depth.latency_s": 0.13}`.
        grid: the situations, if they were already read without overrides.

    Raises:
        InputError: a file cannot be read, a value is not allowed, a key or path is unknown.
    """
    documents = {name: load_document(folder / f"{name}.yaml") for name in DOCUMENTS}
    documents = overridden(documents, overrides or {})
    return SimConfig(
        world=read_world(documents["world"]) if grid is None else grid.world(()),
        vehicle=read_vehicle(documents["vehicle"]),
        sensors=read_sensors(documents["sensors"]),
        grid=read_grid(documents["situations"], documents["world"]) if grid is None else grid,
        stack=_stack(documents["stack"]),
        sources=_sources(load_document(sources), documents) if is_there(sources := folder / "sources.yaml") else {},
        numbers=_numbers(documents),
    )


def _stack(item: Item) -> StackChoice:
    name = item.need("name").text()
    parameters = {key: entry.plain() for key, entry in item.mapping().items() if key != "name"}
    return StackChoice(name, parameters, item)


def _numbers(documents: Mapping[str, Item]) -> dict[str, float]:
    return {
        f"{name}.{path}": float(item.value)
        for name, document in documents.items()
        for path, item in leaves(document)
        if isinstance(item.value, int | float) and not isinstance(item.value, bool)
    }


def _sources(item: Item, documents: Mapping[str, Item]) -> dict[str, Source]:
    """Read the sources.

    Raises:
        InputError: a kind is unknown, or a path does not begin with the name of a document.
    """
    sources = {}
    for path, entry in item.mapping().items():
        if path.split(".")[0] not in documents:
            raise InputError(f"{entry.place}: no document for {path!r}{did_you_mean(path.split('.')[0], documents)}")
        sources[path] = Source(entry.need("kind").choice(KINDS), entry.need("source").text())
        entry.close()
    return sources
