"""The world of a flight: mine, bodies with their roles, waypoints, mission and light, read from `world.yaml`.

A plugin declares a role in a module that its entry point in the group `scaloft_fi.plugins` names:

    ROLES.declare("dog", Role("an animal that may stand in the way", label="dog", fill="#d6d3d1"))

A body in a study's `world.yaml` gets the role with `role: dog`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cache, cached_property
from typing import Annotated, Any, Literal

import numpy as np

from scaloft_fi.document import Item
from scaloft_fi.errors import Faults, InputError, did_you_mean
from scaloft_fi.marks import (
    Bounds,
    Choices,
    Either,
    Examples,
    MoreThanZero,
    NotNegative,
    Pattern,
    Reads,
    Share,
    Size,
)
from scaloft_fi.model import read, schema_of, value_of
from scaloft_fi.registry import Registry
from scaloft_fi.sim import mesh
from scaloft_fi.sim.happenings import Happening, Occurrence, Surroundings, happenings_schema, misfits, read_happenings
from scaloft_fi.sim.log import SIGNALS, truth_signals
from scaloft_fi.sim.mesh import FARTHEST_M, Mesh, Scene
from scaloft_fi.sim.mine import Metres, Mine, Rock, flaws_of, read_mine


@dataclass(frozen=True)
class Role:
    """A role of bodies.

    Attributes:
        meaning: the role in a few words.
        label: class label of the detector's boxes for such a body; "" if the detector ignores it.
        is_person: whether `person_range_m` and `person_sight_m` measure the distance to the body, and whether the
            nominal flight uses the slow speed if such a body is present.
        is_obstacle: whether `obstacle_pixels` counts the pixels of the body.
        fill, stroke: colours of the body on a map.
        stroke_px: width of the body's outline on a map [px].
    """

    meaning: str
    label: str = ""
    is_person: bool = False
    is_obstacle: bool = False
    fill: str = "#a8a29e"
    stroke: str = "#44403c"
    stroke_px: float = 1.4

    @property
    def seen_as(self) -> tuple[str, bool, bool]:
        """The part that can change a flight: how detector and observer treat the body."""
        return self.label, self.is_person, self.is_obstacle


def _optional_signals() -> dict[str, str]:
    return {name: signal.meaning for name, signal in SIGNALS.items()}


ROLES = Registry[Role]("role of a body")
ROLES.declare("obstacle", Role("stands on the path", is_obstacle=True))
ROLES.declare(
    "person",
    Role("a person, whom SR2 protects", label="person", is_person=True, fill="#fdba74", stroke="#9a3412"),
)
ROLES.declare("structure", Role("part of the mine's fittings", fill="#111827", stroke="#111827", stroke_px=3.0))


WALL, GROUND = "wall", "ground"

MARGIN_M = 0.001
"""Bullet's margin around a convex mesh [m]."""

LEAST_M = 0.005
"""Least thickness of a body [m]."""

MOST_BODIES, MOST_WAYPOINTS = 100, 1_000
"""Each body costs time in every frame, and a signal in every log; each waypoint is checked in every situation."""

Point = tuple[float, float, float]
_ROUTE = "a list of waypoints, where the mission lands at the last one"


@dataclass(frozen=True, eq=False)
class Body:
    """A body in the mine.

    Attributes:
        name: unique name, also in `struck`.
        role: name of its role in `ROLES`.
        mesh: its triangles [m, world].
        core: the same shape, smaller by `MARGIN_M` on all sides; the physics server adds that margin to it.
        centre: its centre [m, world].
        reflectivity: reflected share of infrared light, 0..1.
        present: whether the body is in the mine.
        optional: whether flights without the body have no signal of it.
    """

    name: str
    role: str
    mesh: Mesh
    core: Mesh
    centre: Point
    reflectivity: float
    present: bool
    optional: bool = False


@dataclass(frozen=True)
class Nominal:
    """Speeds of the nominal flight; the time limit follows from them.

    Attributes:
        climb_mps: speed of climb at the start [m/s].
        sink_mps: speed of descent at the end [m/s].
        turn_degps: rate of a turn on the spot [deg/s].
        dwell_s: pause after take-off [s].
    """

    climb_mps: Annotated[MoreThanZero, Examples(0.7)]
    sink_mps: Annotated[MoreThanZero, Examples(0.5)]
    turn_degps: Annotated[MoreThanZero, Examples(45.0)]
    dwell_s: Annotated[NotNegative, Examples(0.5)]


@dataclass(frozen=True)
class MissionPlan:
    """What the drone has to fly.

    Attributes:
        home: x, y of take-off and landing; the floor there is at z = 0 [m, world].
        yaw_deg: heading at the start, from x, left positive [deg].
        route: names of waypoints in order, or home; it lands at the last one.
        altitude_m: altitude of flight, where a waypoint has none of its own [m].
        cruise_mps: cruise speed [m/s].
        slow_mps: speed after the first detection of a person [m/s].
        nominal: speeds of the nominal flight, from which the time limit follows.
    """

    home: Annotated[tuple[float, float], Examples((0.0, 0.0))]
    yaw_deg: Annotated[float, Examples(0.0)]
    route: Annotated[tuple[str, ...], Size(1, MOST_WAYPOINTS, _ROUTE), Examples(("corner", "home"))]
    altitude_m: Annotated[MoreThanZero, Examples(1.65)]
    cruise_mps: Annotated[MoreThanZero, Examples(0.5)]
    slow_mps: Annotated[MoreThanZero, Examples(0.2)]
    nominal: Nominal

    @property
    def yaw_rad(self) -> float:
        """Heading at the start [rad]."""
        return math.radians(self.yaw_deg)


@dataclass(frozen=True, eq=False)
class World:
    """The world of a flight without the vehicle.

    Attributes:
        mine: the rock.
        bodies: bodies by name, absent bodies included.
        waypoints: (x, y, z) by name [m, world]; `home` comes from the mission.
        mission: the mission.
        light: brightness of visible light, 0..1.
        signals: names of the optional signals that flights in this world record.
        happenings: what happens during a flight.
    """

    mine: Mine
    bodies: Mapping[str, Body]
    waypoints: Mapping[str, Point]
    mission: MissionPlan
    light: float
    signals: tuple[str, ...] = ()
    happenings: tuple[Happening, ...] = ()

    @cached_property
    def present(self) -> tuple[Body, ...]:
        """The bodies that are present."""
        return tuple(body for body in self.bodies.values() if body.present)

    @property
    def surfaces(self) -> tuple[str, ...]:
        """Names of the surfaces that have a signal: wall, ground, then the bodies, but for absent optional ones."""
        return (WALL, GROUND, *(name for name, body in self.bodies.items() if body.present or not body.optional))

    def bodies_with(self, trait: Callable[[Role], object]) -> tuple[str, ...]:
        """Names of the present bodies whose role has the trait."""
        return tuple(body.name for body in self.present if trait(ROLES[body.role]))

    @cached_property
    def route(self) -> tuple[Point, ...]:
        """The waypoints of the mission in order; it lands at the last one [m, world]."""
        return tuple(self.waypoints[name] for name in self.mission.route)

    @cached_property
    def floor_m(self) -> float:
        """Height of the floor at home [m, world]."""
        return self.mine.floor_m(*self.mission.home)

    @cached_property
    def scene(self) -> Scene:
        """All triangles of the world."""
        mine = self.mine
        meshes = [mine.wall, mine.ground, *(body.mesh for body in self.present)]
        whole = mesh.join(meshes)
        return Scene(
            vertices=np.ascontiguousarray(whole.vertices),
            faces=np.ascontiguousarray(whole.faces),
            owner=np.repeat(np.arange(len(meshes)), [len(part.faces) for part in meshes]).astype(np.int16),
            names=(WALL, GROUND, *(body.name for body in self.present)),
            reflectivity=np.array(
                [mine.wall_reflectivity, mine.ground_reflectivity, *(body.reflectivity for body in self.present)]
            ),
        )

    def path_of(self, body: Body) -> tuple[tuple[float, float], ...]:
        """The places (x, y) of a body that moves, its position first [m, world]; empty for a body that stands."""
        paths = (happening.effect.path for happening in self.happenings if happening.effect.moved == body.name)
        return next(((body.centre[:2], *path) for path in paths if path), ())

    def surroundings(self) -> Surroundings:
        """The surroundings of a new flight."""
        places = {body.name: body.centre for body in self.present}
        return Surroundings(self.scene, self.light, places, self.happenings)


def _place(allowed: str, hint: Any) -> Any:
    """Reads two or three coordinates."""

    def find(item: Item) -> tuple[float, ...]:
        numbers: tuple[float, ...] = value_of(tuple[hint, ...], item)
        if len(numbers) not in (2, 3):
            raise item.error(allowed)
        return numbers

    size = {"minItems": 2, "maxItems": 3, "examples": [[0.0, 7.0], [0.0, 7.0, 1.4]]}
    return Reads(find, lambda _names: {"type": "array", "items": schema_of(hint), **size})


@dataclass(frozen=True)
class _Shape:
    """What every body has.

    Attributes:
        role: how detector, observer and map treat it.
        position: x, y of its foot, and the height of the foot where it stands on something [m, world].
        reflectivity: share of infrared light that it reflects; dark bodies vanish in the dark.
        present: whether it is there; an axis may set this.
        optional: whether flights without it have no signal of it.
    """

    role: Annotated[str, Choices(lambda: {name: role.meaning for name, role in ROLES.items()}, named="roles")]
    position: Annotated[tuple[float, ...], _place("[x, y] or [x, y, z of the foot]", Metres)]
    reflectivity: Annotated[Share, Examples(0.3)]
    present: bool
    optional: bool = field(default=False, kw_only=True)

    def forms(self) -> tuple[Mesh, Mesh, float]:
        """Its triangles about its centre, those of its core, and its height [m]."""
        raise NotImplementedError

    def body(self, name: str) -> Body:
        """The body in the mine."""
        form, core, height_m = self.forms()
        foot_m = self.position[2] if len(self.position) == 3 else 0.0
        centre = (self.position[0], self.position[1], foot_m + 0.5 * height_m)
        meshes = form.moved(centre), core.moved(centre)
        return Body(name, self.role, *meshes, centre, self.reflectivity, self.present, self.optional)


Edge = Annotated[float, Bounds(least=LEAST_M, most=FARTHEST_M)]


@dataclass(frozen=True)
class Box(_Shape):
    """A box.

    Attributes:
        shape: a box about the vertical.
        size_m: edges x, y, z of the box [m].
    """

    shape: Literal["box"]
    size_m: Annotated[tuple[Edge, Edge, Edge], Examples((0.5, 0.5, 1.8))]

    def forms(self) -> tuple[Mesh, Mesh, float]:
        """The box, its core, and its edge z [m]."""
        return mesh.box(self.size_m), mesh.box([edge - 2.0 * MARGIN_M for edge in self.size_m]), self.size_m[2]


@dataclass(frozen=True)
class Turned(_Shape):
    """A cylinder, or a capsule.

    Attributes:
        shape: an upright cylinder, or one with round ends.
        radius_m: radius [m].
        height_m: height; of a capsule at least twice the radius [m].
    """

    shape: Literal["cylinder", "capsule"]
    radius_m: Annotated[Edge, Examples(0.25)]
    height_m: Annotated[float, Bounds(least=LEAST_M, most=2.0 * FARTHEST_M), Examples(1.7)]

    def contradictions(self, item: Item) -> Iterator[InputError]:
        """Refuse a capsule whose round ends would overlap."""
        if self.shape == "capsule" and self.height_m < 2.0 * self.radius_m:
            yield item.need("height_m").error(f">= {2.0 * self.radius_m:g} and <= {2.0 * FARTHEST_M:g}")

    def forms(self) -> tuple[Mesh, Mesh, float]:
        """The solid, its core, and its height [m]."""
        turned = mesh.cylinder if self.shape == "cylinder" else mesh.capsule
        core = turned(self.radius_m - MARGIN_M, self.height_m - 2.0 * MARGIN_M)
        return turned(self.radius_m, self.height_m), core, self.height_m


Solid = Annotated[Box | Turned, Either(by="shape")]
Waypoint = Annotated[tuple[float, ...], _place("[x, y] or [x, y, z]", float)]
_BODY = "a name of letters, digits and _ other than 'wall' and 'ground'"


@dataclass(frozen=True)
class WorldModel:
    """The mine, its bodies, the mission and what happens during a flight.  World axes: x east, y north, z up.

    Attributes:
        mine: the rock: a ground plan, or a mesh of your own.
        bodies: the bodies by name; each has a clearance in the log.
        waypoints: the places of the mission by name; without z at the mission's altitude [m, world].
        mission: what the drone has to fly.
        light: brightness of visible light: 0 dark, 1 full.
        signals: optional signals that every flight records; `scaloft-fi signals` lists them.
        happenings: what happens during a flight, by name.
    """

    mine: Annotated[Item, Reads(lambda item: item, lambda _names: schema_of(Rock))]
    bodies: Annotated[Mapping[str, Solid], Size(0, MOST_BODIES), Pattern(r"(?!(?:wall|ground)$)[^\W\d]\w*", _BODY)]
    waypoints: Annotated[Mapping[str, Waypoint], Size(0, MOST_WAYPOINTS)]
    mission: MissionPlan
    light: Annotated[Share, Examples(0.9, 0.003)]
    signals: tuple[Annotated[str, Choices(_optional_signals, named="signals")], ...] = ()
    happenings: Annotated[tuple[Occurrence, ...], Reads(read_happenings, happenings_schema)] = ()

    def contradictions(self, item: Item) -> Iterator[InputError]:
        """Refuse a home among the waypoints, unknown places of the route, and signals that are recorded anyway."""
        waypoints, route = item.need("waypoints"), item.need("mission").need("route")
        if (own := waypoints.get("home")) is not None:
            yield InputError(f"{own.place}: home is no waypoint of its own; it is set under mission")
        known = ["home", *self.waypoints]
        for name, entry in zip(self.mission.route, route, strict=True):
            if name not in known:
                yield InputError(f"{entry.place}: no waypoint {name!r}{did_you_mean(name, known)}")
        listed = item.get("signals")
        recorded = {signal.name for signal in truth_signals((WALL, GROUND, *self.bodies))}
        for name, entry in zip(self.signals, listed or (), strict=True):
            if name in recorded:
                yield InputError(f"{entry.place}: signal {name!r} is recorded already; list it once, or not at all")
            recorded.add(name)

    def world(self, mine: Mine) -> World:
        """The world around a mine."""
        altitude_m = self.mission.altitude_m
        return World(
            mine=mine,
            bodies={name: solid.body(name) for name, solid in self.bodies.items()},
            waypoints={
                "home": (*self.mission.home, altitude_m),
                **{n: (at[0], at[1], at[2] if len(at) == 3 else altitude_m) for n, at in self.waypoints.items()},
            },
            mission=self.mission,
            light=self.light,
            signals=self.signals,
            happenings=tuple(one.happening for one in self.happenings),
        )


def read_world(item: Item, mine: Mine | None = None) -> World:
    """Read and check a world; `mine` is its mine, if that was read already.

    Raises:
        InputError: a value is not allowed, a key is unknown, a waypoint is not in open space.
    """
    world, happenings = assembled(item, mine)
    faults = Faults()
    faults.add(*misplaced(world, item), *misfits(world, happenings))
    faults.end()
    return world


def assembled(item: Item, mine: Mine | None = None) -> tuple[World, tuple[Occurrence, ...]]:
    """Read a world and its active happenings, without a check that they fit together.

    Raises:
        InputError: a value is not allowed, or a key is unknown.
    """
    faults, model = Faults(), None
    with faults.collecting():
        model = read(WorldModel, item)
    if mine is None and "mine" in item.mapping():
        with faults.collecting():
            mine = read_mine(item.need("mine"))
    faults.end()
    assert model is not None
    assert mine is not None
    return model.world(mine), model.happenings


ON_FLOOR_M = 0.05
"""Approximate height of a standing vehicle's centre [m]."""
_ROCK = "the open space of the mine, not in the wall or outside"


def misplaced(world: Any, item: Item) -> Iterator[InputError]:
    """An error for a home whose floor is not at height 0, and for each waypoint that is not in open space.

    Args:
        world: the `sim.world.World`.
        item: the document that it was read from.
    """
    mission = item.need("mission")
    home = mission.need("home")
    places = {"home": home, **item.need("waypoints").mapping()}
    if not abs(world.floor_m) < 0.1:  # where the stack takes off
        actual = "there is none" if math.isnan(world.floor_m) else f"it is at z={world.floor_m:.2f} m"
        sentence = f"home={list(world.mission.home)!r} must have the floor at z=0, but {actual}"
        yield InputError(f"{home.place}: {sentence}; the mine reaches from {world.mine.extents_text} m{_scaled(world)}")
        del places["home"]
    flaws = cache(lambda: _mesh_flaws(item))
    for name, place in places.items():
        why = _obstructed(world, name)
        if why == _ROCK:
            why += _beyond(world, name) or flaws()
        if why:
            yield InputError(f"{place.place}: {name}={list(world.waypoints[name][:2])!r} must be in {why}")


def _obstructed(world: Any, name: str) -> str:
    """Why a waypoint is not in open space at its altitude, home and the last one also just above the floor, or ""."""
    x, y, z_m = world.waypoints[name]
    floor_m = world.mine.floor_m(x, y)
    lands = name in ("home", world.mission.route[-1]) and math.isfinite(floor_m)
    for point in ((x, y, z) for z in [z_m] + [floor_m + ON_FLOOR_M] * lands):
        if not world.mine.holds(point):
            return _ROCK
        for body in world.present:
            if body.mesh.encloses(point):
                return f"open space, not inside {body.name!r}"
    return ""


def _beyond(world: Any, name: str) -> str:
    """How far the mine reaches, where the waypoint is outside the box around it; else ""."""
    low, high = world.mine.extents
    point = world.waypoints[name]
    if all(least <= value <= most for least, value, most in zip(low, point, high, strict=True)):
        return ""
    return f"; the mine reaches from {world.mine.extents_text} m{_scaled(world)}"


def _scaled(world: Any) -> str:
    """What a mesh of another program often lacks; "" for an extruded mine."""
    return "" if world.mine.footprint else ": z must be up, and `scale_m` is metres per unit of the file"


def _mesh_flaws(item: Item) -> str:
    """What is wrong with the mesh of the mine, for which open space may pass for rock; "" for a sound one."""
    flaws = sorted(flaws_of(item.need("mine")), key=lambda flaw: not flaw.grave)
    return f"; the mesh may be the cause: {flaws[0]}" if flaws else ""
