"""Read the simulation part of a study: world, vehicle, sensors, situations, the chosen stack, sources of the numbers.

They stand beside the declaration of a stack, because nothing that is flown or judged depends on them: flights keep
their keys when a claim changes.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from itertools import combinations
from pathlib import Path
from typing import Annotated, Any

from scaloft_fi.document import Item, is_there
from scaloft_fi.document import load as load_document
from scaloft_fi.errors import Faults, InputError, did_you_mean
from scaloft_fi.marks import Called, Choices
from scaloft_fi.model import read
from scaloft_fi.sim.grid import Grid, read_grid, remedy
from scaloft_fi.sim.grids import FILE
from scaloft_fi.sim.patch import PARTS, leaves, patched
from scaloft_fi.sim.scenario import Scenario
from scaloft_fi.sim.sensors import SensorsConfig, read_sensors
from scaloft_fi.sim.situation import AxisValue, Situation
from scaloft_fi.sim.stacks import StackChoice
from scaloft_fi.sim.vehicle import Vehicle
from scaloft_fi.sim.world import World

DOCUMENTS = (*PARTS, "situations", "stack")
MOST_NOMINAL_S = 3_600.0
"""Longest nominal mission time [s]: no battery lasts longer, and a log grows by some 10 kB each second."""
MOST_DRAWN = 256
"""Scenarios with drawn numbers that are kept; each takes half a megabyte, and a search has thousands."""
KINDS = {
    "published": "a paper, its repository, or another publication",
    "datasheet": "maker's data, or the configuration that a device is shipped with",
    "derived": "computed from those",
    "assumption": "chosen for the study; tables of sensitivity vary these",
}


@dataclass(frozen=True)
class NumberSource:
    """The source of the numbers at a path.

    Attributes:
        kind: what kind of source it is.
        text: the source, or the reason of an assumption.
    """

    kind: Annotated[str, Choices(KINDS)]
    text: Annotated[str, Called("source")]


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
    sources: Mapping[str, NumberSource]
    numbers: Mapping[str, float]
    _scenarios: dict[str, Scenario] = field(default_factory=dict, repr=False)
    _drawn: dict[str, Scenario] = field(default_factory=dict, repr=False)

    def scenario(self, situation: Situation) -> Scenario:
        """The scenario of a situation, made once; of those with drawn numbers the last `MOST_DRAWN` are kept.

        Raises:
            InputError: the values of the axes contradict each other, or the mission takes too long.
        """
        kept = self._drawn if situation.numbers else self._scenarios
        if situation.key not in kept:
            kept[situation.key] = self._built(situation)
            if len(self._drawn) > MOST_DRAWN:
                del self._drawn[next(iter(self._drawn))]
        return kept[situation.key]

    def _built(self, situation: Situation) -> Scenario:
        values = self.grid.values(situation)
        try:
            scenario = Scenario(situation, *_read(self.grid, self.grid.documents_with(values.values())))
        except InputError as error:
            numbers, levels = dict(situation.numbers), dict(situation.levels)

            def written(axis: str) -> str:
                """The part of the key for one axis, such as `T1` or `Cs=0.871`."""
                level = {axis: levels[axis]} if axis in levels else {}
                return Situation.of(level, {axis: numbers[axis]} if axis in numbers else {}).key

            for axis in numbers:
                if self._refused(values[axis]):
                    sentence = f"{error}: {written(axis)} is not possible, as in situation {situation.key}"
                    place = next(item.place for item in values[axis].changes.values())
                    raise InputError(f"{sentence}; the range at {place} must leave it out") from error
            blamed = self._to_blame(values)
            names = " and ".join(written(axis) for axis, _ in blamed)
            sentence = f"{error}: {names} cannot be combined, as in situation {situation.key}"
            if any(axis not in levels for axis, _ in blamed):
                raise InputError(sentence) from error
            raise InputError(f"{sentence}; {remedy(*blamed)}") from error

        if not scenario.nominal_s <= MOST_NOMINAL_S:
            place = self.grid.documents["world"].need("mission").place
            lasts = f"the mission in {situation.key} must last at most {MOST_NOMINAL_S:,.0f} s"
            raise InputError(f"{place}: {lasts} at its speeds, it lasts {scenario.nominal_s:,.0f} s")
        for happening in scenario.world.happenings:
            if happening.start.at_s >= scenario.t_max_s:
                limit = f"before the time limit of situation {situation.key}, {scenario.t_max_s:.1f} s"
                sentence = f"at_s={happening.start.at_s:g} must be {limit}, or {happening.name!r} cannot come"
                raise InputError(f"{happening.item.place}: {sentence}")
        return scenario

    def _to_blame(self, values: Mapping[str, AxisValue]) -> tuple[tuple[str, int], ...]:
        """The first two values of a situation that cannot be combined; all values where any two can."""
        pairs = (pair for pair in combinations(values.items(), 2) if self._refused(*(value for _, value in pair)))
        return tuple((axis, value.id) for axis, value in next(pairs, values.items()))

    def _refused(self, *values: AxisValue) -> bool:
        """Whether these values cannot be."""
        try:
            _read(self.grid, self.grid.documents_with(values))
        except InputError:
            return True
        return False

    def source_of(self, path: str) -> NumberSource | None:
        """The source of the number at `path`, or of its nearest parent with a source."""
        while path and path not in self.sources:
            path = path.rpartition(".")[0]
        return self.sources.get(path)

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
    places = {path: Item(Path("overrides"), 1, path, value) for path, value in (overrides or {}).items()}
    documents = patched(documents, places)
    if grid is None:
        grid = read_grid(documents["situations"], documents)
    elif grid.item is not None:
        # what the grid adds is in its documents
        entries = {key: entry for key, entry in grid.item.mapping().items() if key != "adds"}
        documents = {**documents, **grid.documents, "situations": replace(grid.item, value=entries)}
    for value in grid.proved_values:
        if any(not path.startswith("world.") for path in value.changes):  # the grid itself has read the world
            _read(grid, grid.documents_with([value]))
    world, vehicle, sensors = _read(grid, documents)
    return SimConfig(
        world=world,
        vehicle=vehicle,
        sensors=sensors,
        grid=grid,
        stack=StackChoice.read(documents["stack"]),
        sources=_sources(folder, grid, documents),
        numbers={
            f"{name}.{path}": float(item.value)
            for name, document in documents.items()
            for path, item in leaves(document)
            if isinstance(item.value, int | float) and not isinstance(item.value, bool)
        },
    )


def _read(grid: Grid, documents: Mapping[str, Item]) -> tuple[World, Vehicle, SensorsConfig]:
    faults, parts = Faults(), list[Any]()
    with faults.collecting():
        parts.append(grid.world_of(documents))
    with faults.collecting():
        parts.append(read(Vehicle, documents["vehicle"]))
    with faults.collecting():
        parts.append(read_sensors(documents["sensors"]))
    faults.end()
    world, vehicle, sensors = parts
    return world, vehicle, sensors


def _sources(folder: Path, grid: Grid, documents: Mapping[str, Item]) -> dict[str, NumberSource]:
    """Read the sources of the study, those of `situations.yaml` only where its grid is read, and of a further grid.

    Raises:
        InputError: a kind is unknown, or a path does not begin with the name of a document.
    """
    path, faults, sources = folder / "sources.yaml", Faults(), dict[str, NumberSource]()
    own = documents["situations"].path == folder / FILE
    further = grid.item.get("sources") if grid.item and grid.further else None
    for item in (load_document(path) if is_there(path) else None, further):
        for number, entry in (item.mapping() if item else {}).items():
            name = number.split(".")[0]
            if name not in documents:
                faults.add(InputError(f"{entry.place}: no document for {number!r}{did_you_mean(name, documents)}"))
            with faults.collecting():
                source = read(NumberSource, entry)
                if own or item is further or name != "situations":
                    sources[number] = source
    faults.end()
    return sources
