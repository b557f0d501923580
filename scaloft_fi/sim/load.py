"""The simulation part of a study: world, vehicle, sensors, situations, the chosen stack, sources of the numbers.

A scenario is the world of a situation with the mission, and the times derived from them.  The sources of the numbers
stand beside them, because nothing that is flown or judged depends on them: flights keep their keys when one changes.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import combinations
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import numpy as np

from scaloft_fi.document import Item, is_there
from scaloft_fi.document import load as load_document
from scaloft_fi.errors import Faults, InputError, did_you_mean, refused
from scaloft_fi.marks import Called, Choices
from scaloft_fi.model import read
from scaloft_fi.sim.grid import FILE, Grid, impossible_worlds, read_grid, remedy
from scaloft_fi.sim.mine import WallPoint
from scaloft_fi.sim.sensors import SensorsConfig, read_sensors
from scaloft_fi.sim.sensors.camera import look
from scaloft_fi.sim.situation import PARTS, AxisValue, Situation, leaves, patched
from scaloft_fi.sim.stacks import StackChoice
from scaloft_fi.sim.vehicle import Vehicle
from scaloft_fi.sim.world import ROLES, Point, World

TIME_LIMIT_S, TIME_LIMIT_FACTOR = 20.0, 1.5
"""A flight may last 20 s + 1.5 x the nominal mission time (definition of OP1)."""

NEAR_HOME_M = 0.5
"""A waypoint closer to home than this counts as home [m]."""
SIGHTED_PIXELS = 25
"""A person with at least this number of pixels is in view."""
LOOK_EVERY_S = 0.2


class Leg(NamedTuple):
    """A piece of the nominal flight at constant speed.  start, end: position (3,) [m, world] and heading [rad]."""

    duration_s: float
    start: tuple[float, float, float, float]
    end: tuple[float, float, float, float]


@dataclass(frozen=True, eq=False)
class Scenario:
    """World, vehicle, sensors and nominal flight of a situation.

    Attributes:
        situation: the point of the grid.
        world: mine, bodies, mission, light.
        vehicle: the vehicle.
        sensors: settings of the sensors.
    """

    situation: Situation
    world: World
    vehicle: Vehicle
    sensors: SensorsConfig

    @property
    def key(self) -> str:
        """Key of the situation."""
        return self.situation.key

    @cached_property
    def home(self) -> Point:
        """Start and end of the mission, on the floor [m, world]."""
        return (*self.world.mission.home, self.world.floor_m)

    @property
    def route(self) -> tuple[Point, ...]:
        """The waypoints of the mission in order; it lands at the last one [m, world]."""
        return self.world.route

    @property
    def persons(self) -> tuple[str, ...]:
        """Names of the persons that are present."""
        return self.world.bodies_with(lambda role: role.is_person)

    @cached_property
    def labels(self) -> Mapping[str, str]:
        """Class label of each body that the person detector finds, by the body's name."""
        bodies = self.world.bodies
        return {name: ROLES[bodies[name].role].label for name in self.world.bodies_with(lambda role: role.label)}

    @property
    def start(self) -> Point:
        """Centre of the vehicle when it stands at home [m, world]."""
        x, y, floor_m = self.home
        return x, y, floor_m + self.vehicle.half_height_m

    @cached_property
    def first_leg(self) -> tuple[Point, Point]:
        """Start and end of the first leg that leads away from home [m, world]."""
        x0, y0 = self.world.mission.home
        end = next((p for p in self.route if math.hypot(p[0] - x0, p[1] - y0) > NEAR_HOME_M), self.route[0])
        return (x0, y0, end[2]), end

    @cached_property
    def wall_right(self) -> WallPoint | None:
        """The point on the wall right of the first leg that is nearest to the leg's middle; None without a wall."""
        (x0, y0, z), (x1, y1, _) = self.first_leg
        return self.world.mine.wall_towards(((x0 + x1) / 2, (y0 + y1) / 2, z), (y1 - y0, x0 - x1))

    @cached_property
    def nominal_s(self) -> float:
        """Nominal mission time [s]: climb, turns, legs at cruise speed (slow speed with a person present), landing."""
        mission = self.world.mission
        return sum(leg.duration_s for leg in self._legs(mission.slow_mps if self.persons else mission.cruise_mps))

    @cached_property
    def t_max_s(self) -> float:
        """Time limit of a flight [s]."""
        return TIME_LIMIT_S + TIME_LIMIT_FACTOR * self.nominal_s

    @cached_property
    def sighting_s(self) -> float | None:
        """Time at which the nominal flight first has a person in view [s]; None if it never has."""
        around = self.world.surroundings()
        scene, persons = around.scene, [around.scene.names.index(name) for name in self.persons]
        begun_s = 0.0
        for leg in self._legs(self.world.mission.cruise_mps) if persons else ():
            for k in range(math.ceil(leg.duration_s / LOOK_EVERY_S)):
                share = k * LOOK_EVERY_S / leg.duration_s
                x, y, z, yaw = ((1.0 - share) * a + share * b for a, b in zip(leg.start, leg.end, strict=True))
                around.update(begun_s + k * LOOK_EVERY_S, x, y)
                attitude = np.array([0.0, 0.0, math.sin(0.5 * yaw), math.cos(0.5 * yaw)])
                view = look(scene, self.sensors.depth.camera, np.array([x, y, z]), attitude)
                if any(np.count_nonzero(view.segments == person) >= SIGHTED_PIXELS for person in persons):
                    return begun_s + k * LOOK_EVERY_S
            begun_s += leg.duration_s
        return None

    def _legs(self, speed_mps: float) -> Iterator[Leg]:
        """The nominal flight: climb; for each waypoint turn on the spot and fly straight; descend where it ends."""
        mission = self.world.mission
        nominal = mission.nominal
        x, y, floor_m = self.home
        z, yaw = mission.altitude_m, mission.yaw_rad
        yield Leg((z - floor_m) / nominal.climb_mps, (x, y, floor_m, yaw), (x, y, z, yaw))
        yield Leg(nominal.dwell_s, (x, y, z, yaw), (x, y, z, yaw))
        for to_x, to_y, to_z in self.route:
            level_m = math.hypot(to_x - x, to_y - y)
            if level_m > 0:
                heading = math.atan2(to_y - y, to_x - x)
                turned = yaw + math.remainder(heading - yaw, 2.0 * math.pi)
                yield Leg(abs(turned - yaw) / math.radians(nominal.turn_degps), (x, y, z, yaw), (x, y, z, turned))
                yaw = turned
            distance_m = math.hypot(level_m, to_z - z) if to_z != z else level_m
            if distance_m > 0:
                yield Leg(distance_m / speed_mps, (x, y, z, yaw), (to_x, to_y, to_z, yaw))
                x, y, z = to_x, to_y, to_z
        yield Leg((z - floor_m) / nominal.sink_mps, (x, y, z, yaw), (x, y, floor_m, yaw))


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
        return refused(lambda: _read(self.grid, self.grid.documents_with(values))) is not None

    def source_of(self, path: str) -> NumberSource | None:
        """The source of the number at `path`, or of its nearest parent with a source."""
        while path and path not in self.sources:
            path = path.rpartition(".")[0]
        return self.sources.get(path)

    @property
    def assumptions(self) -> dict[str, float]:
        """The assumed numbers by path."""
        sources = {path: self.source_of(path) for path in self.numbers}
        return {path: self.numbers[path] for path, own in sources.items() if own and own.kind == "assumption"}


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
    elif (own := grid.item) is not None:
        # what the grid adds is in its documents
        entries = {key: entry for key, entry in own.mapping().items() if key != "adds"}
        documents = {**documents, **grid.documents, "situations": replace(own, value=entries)}
    faults = Faults()
    faults.add(*impossible_worlds(grid))
    faults.end()
    for value in grid.proved_values:
        if any(not path.startswith("world.") for path in value.changes):  # the grid itself has read the world
            _read(grid, grid.documents_with([value]))
    numbers = {
        f"{name}.{path}": float(item.value)
        for name, document in documents.items()
        for path, item in leaves(document)
        if isinstance(item.value, int | float) and not isinstance(item.value, bool)
    }
    choice, sources = StackChoice.read(documents["stack"]), _sources(folder, grid, documents)
    return SimConfig(*_read(grid, documents), grid, choice, sources, numbers)


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
