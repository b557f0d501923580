"""The world of a flight: mine, bodies with their roles, waypoints, mission and light, read from `world.yaml`.

A plugin declares a role in a module that its entry point in the group `scaloft_fi.plugins` names:

    ROLES.declare("dog", Role("an animal that may stand in the way", label="dog", fill="#d6d3d1"))

A body in a study's `world.yaml` gets the role with `role: dog`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cache, cached_property
from typing import Annotated, Any, Literal

import numpy as np

from scaloft_fi import marks
from scaloft_fi.document import Item
from scaloft_fi.errors import Faults, InputError, did_you_mean
from scaloft_fi.marks import Bounds, Choices, Examples, MoreThanZero, NotNegative, Pattern, Reads, Share, Size
from scaloft_fi.model import read, schema_of, value_of
from scaloft_fi.registry import Registry
from scaloft_fi.sim import mesh
from scaloft_fi.sim.happenings import Happening, Surroundings, happenings_schema, misfits, read_happenings
from scaloft_fi.sim.log import SIGNALS, truth_signals
from scaloft_fi.sim.mesh import FARTHEST_M, Mesh, Scene
from scaloft_fi.sim.mine import Metres, Mine, Rock, flaws_of, read_mine, reading_for


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


ROLES = Registry[Role]("role of a body")
ROLES.declare("obstacle", Role("stands on the path", is_obstacle=True))
_PERSON = Role("a person, whom SR2 protects", label="person", is_person=True, fill="#fdba74", stroke="#9a3412")
ROLES.declare("person", _PERSON)
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


def _place(allowed: str, hint: Any) -> Any:
    """Reads two or three coordinates."""

    def find(item: Item) -> tuple[float, ...]:
        numbers: tuple[float, ...] = value_of(tuple[hint, ...], item)
        if len(numbers) not in (2, 3):
            raise item.error(allowed)
        return numbers

    size = {"minItems": 2, "maxItems": 3, "examples": [[0.0, 7.0], [0.0, 7.0, 1.4]]}
    return Reads(find, lambda _names: {"type": "array", "items": schema_of(hint), **size})


@dataclass(frozen=True, eq=False)
class Body:
    """A body in the mine.

    Attributes:
        name: unique name, also in `struck`.
        role: how detector, observer and map treat it.
        position: x, y of its foot, and the height of the foot where it stands on something [m, world].
        reflectivity: share of infrared light that it reflects; dark bodies vanish in the dark.
        present: whether it is there; an axis may set this.
        optional: whether flights without it have no signal of it.
    """

    name: marks.Key
    role: Annotated[str, Choices(lambda: {name: role.meaning for name, role in ROLES.items()}, named="roles")]
    position: Annotated[tuple[float, ...], _place("[x, y] or [x, y, z of the foot]", Metres)]
    reflectivity: Annotated[Share, Examples(0.3)]
    present: bool
    optional: bool = field(default=False, kw_only=True)

    def form(self, less_m: float) -> tuple[Mesh, float]:
        """Its triangles about its centre, smaller by `less_m` on all sides [m], and its whole height [m]."""
        raise NotImplementedError

    @cached_property
    def centre(self) -> Point:
        """Its centre [m, world]."""
        foot_m = self.position[2] if len(self.position) == 3 else 0.0
        return (self.position[0], self.position[1], foot_m + 0.5 * self.form(0.0)[1])

    @cached_property
    def mesh(self) -> Mesh:
        """Its triangles [m, world]."""
        return self.form(0.0)[0].moved(self.centre)

    @cached_property
    def core(self) -> Mesh:
        """The same shape, smaller by `MARGIN_M` on all sides; the physics server adds that margin to it."""
        return self.form(MARGIN_M)[0].moved(self.centre)


Edge = Annotated[float, Bounds(least=LEAST_M, most=FARTHEST_M)]


@dataclass(frozen=True, eq=False)
class Box(Body):
    """A box.

    Attributes:
        shape: a box about the vertical.
        size_m: edges x, y, z of the box [m].
        yaw_deg: turn about the vertical, counter-clockwise from above [deg].
    """

    shape: Literal["box"]
    size_m: Annotated[tuple[Edge, Edge, Edge], Examples((0.5, 0.5, 1.8))]
    yaw_deg: Annotated[float, Bounds(least=-360.0, most=360.0)] = field(default=0.0, kw_only=True)

    def form(self, less_m: float) -> tuple[Mesh, float]:
        """The box, and its edge z [m]."""
        made = mesh.box([edge - 2.0 * less_m for edge in self.size_m])
        return (made.turned(math.radians(self.yaw_deg)) if self.yaw_deg else made), self.size_m[2]


@dataclass(frozen=True, eq=False)
class Turned(Body):
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

    def form(self, less_m: float) -> tuple[Mesh, float]:
        """The solid, and its height [m]."""
        turned = mesh.cylinder if self.shape == "cylinder" else mesh.capsule
        return turned(self.radius_m - less_m, self.height_m - 2.0 * less_m), self.height_m


Waypoint = Annotated[tuple[float, ...], _place("[x, y] or [x, y, z]", float)]
_SIGNAL = Choices(lambda: {name: signal.meaning for name, signal in SIGNALS.items()}, named="signals")
_BODY = "a name of letters, digits and _ other than 'wall' and 'ground'"


@dataclass(frozen=True, eq=False)
class World:
    """The mine, its bodies, the mission and what happens during a flight.  World axes: x east, y north, z up.

    Attributes:
        rock: the rock: a ground plan, or a mesh of your own.
        mine: the rock as it was read.
        bodies: the bodies by name; each has a clearance in the log.
        places: the places of the mission by name; without z at the mission's altitude [m, world].
        mission: what the drone has to fly.
        light: brightness of visible light: 0 dark, 1 full.
        signals: optional signals that every flight records; `scaloft-fi signals` lists them.
        happenings: what happens during a flight, by name.
    """

    rock: Annotated[Item, marks.Called("mine"), Reads(lambda item: item, lambda _names: schema_of(Rock))]
    mine: Annotated[Mine, marks.Given(lambda item: read_mine(item.need("mine")))]
    bodies: Annotated[
        Mapping[str, Annotated[Box | Turned, marks.Either(by="shape")]],
        Size(0, MOST_BODIES),
        Pattern(r"(?!(?:wall|ground)$)[^\W\d]\w*", _BODY),
    ]
    places: Annotated[Mapping[str, Waypoint], marks.Called("waypoints"), Size(0, MOST_WAYPOINTS)]
    mission: MissionPlan
    light: Annotated[Share, Examples(0.9, 0.003)]
    signals: tuple[Annotated[str, _SIGNAL], ...] = ()
    happenings: Annotated[tuple[Happening, ...], Reads(read_happenings, happenings_schema)] = ()

    def contradictions(self, item: Item) -> Iterator[InputError]:
        """Refuse a home among the waypoints, unknown places of the route, and signals that are recorded anyway."""
        waypoints, route = item.need("waypoints"), item.need("mission").need("route")
        if (own := waypoints.get("home")) is not None:
            yield InputError(f"{own.place}: home is no waypoint of its own; it is set under mission")
        known = ["home", *self.places]
        for name, entry in zip(self.mission.route, route, strict=True):
            if name not in known:
                yield InputError(f"{entry.place}: no waypoint {name!r}{did_you_mean(name, known)}")
        recorded = {signal.name for signal in truth_signals((WALL, GROUND, *self.bodies))}
        for name, entry in zip(self.signals, item.get("signals") or (), strict=True):
            if name in recorded:
                yield InputError(f"{entry.place}: signal {name!r} is recorded already; list it once, or not at all")
            recorded.add(name)

    @cached_property
    def waypoints(self) -> Mapping[str, Point]:
        """(x, y, z) by name [m, world]; `home` comes from the mission."""
        z_m = self.mission.altitude_m
        places = {"home": self.mission.home, **self.places}
        return {name: (at[0], at[1], at[2] if len(at) == 3 else z_m) for name, at in places.items()}

    @cached_property
    def present(self) -> tuple[Body, ...]:
        """The bodies that are present; `bodies` has the absent ones too."""
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
        mine, bodies = self.mine, self.present
        meshes = [mine.wall, mine.ground, *(body.mesh for body in bodies)]
        whole, names = mesh.join(meshes), (WALL, GROUND, *(body.name for body in bodies))
        owner = np.repeat(np.arange(len(meshes)), [len(part.faces) for part in meshes]).astype(np.int16)
        reflectivity = [mine.wall_reflectivity, mine.ground_reflectivity, *(body.reflectivity for body in bodies)]
        return Scene(whole.vertices, whole.faces, owner, names, np.array(reflectivity))

    def path_of(self, body: Body) -> tuple[tuple[float, float], ...]:
        """The places (x, y) of a body that moves, its position first [m, world]; empty for a body that stands."""
        paths = (happening.effect.path for happening in self.happenings if happening.effect.moved == body.name)
        return next(((body.centre[:2], *path) for path in paths if path), ())

    def surroundings(self) -> Surroundings:
        """The surroundings of a new flight."""
        places = {body.name: body.centre for body in self.present}
        return Surroundings(self.scene, self.light, places, self.happenings)


def read_world(item: Item, mine: Mine | None = None) -> World:
    """Read and check a world; `mine` is its mine, if that was read already.

    Raises:
        InputError: a value is not allowed, a key is unknown, a waypoint is not in open space.
    """
    world, faults = assembled(item, mine), Faults()
    faults.add(*misplaced(world, item), *misfits(world))
    faults.end()
    return world


def assembled(item: Item, mine: Mine | None = None) -> World:
    """Read a world and its active happenings, without a check that they fit together.

    Raises:
        InputError: a value is not allowed, or a key is unknown.
    """
    faults = Faults()
    with faults.collecting():
        world = read(World, item, fixed={"mine": mine})
    if mine is None and "mine" in item.mapping():
        with faults.collecting():
            found = read_mine(item.need("mine"))
    faults.end()
    return world if mine is not None else replace(world, mine=found)


def without_rock(item: Item) -> World:
    """A world of which only names are asked: its `mine`, which takes seconds to read from a mesh, is None."""
    return read(World, item, fixed={"mine": None})


ON_FLOOR_M = 0.05
"""Approximate height of a standing vehicle's centre [m]."""
MOST_TRIED = 20
"""Waypoints with which another unit or axis of a mesh is tried."""
_ROCK = "the open space of the mine, not in the wall or outside"


def misplaced(world: Any, item: Item) -> Iterator[InputError]:
    """An error for a home whose floor is not at height 0, and for each waypoint that is not in open space.

    Args:
        world: the `sim.world.World`.
        item: the document that it was read from.
    """
    home, mine = item.need("mission").need("home"), world.mine
    places = {"home": home, **item.need("waypoints").mapping()}
    scaled = "" if mine.footprint else ": z must be up, and `scale_m` is metres per unit of the file"
    reach = f"; the mine reaches from {mine.extents_text} m{scaled}"
    points = [world.waypoints[name] for name in places]
    reading = cache(lambda: reading_for(item.need("mine"), points[:MOST_TRIED]))
    flaws = cache(lambda: sorted(flaws_of(item.need("mine"), points[:MOST_TRIED]), key=lambda flaw: not flaw.grave))
    if not abs(world.floor_m) < 0.1:  # where the stack takes off
        actual = "there is none" if math.isnan(world.floor_m) else f"it is at z={world.floor_m:.2f} m"
        sentence = f"home={list(world.mission.home)!r} must have the floor at z=0, but {actual}"
        moves = f"`shift_m: [0, 0, {-world.floor_m:.3g}]` beside `mesh` moves it" * (not mine.footprint)
        grave = [f"the mesh may be the cause: {flaw}" for flaw in flaws()[:1] if flaw.grave]
        remedy = reading() or "; ".join(grave) or moves * math.isfinite(world.floor_m)
        yield InputError(f"{home.place}: {sentence}{reach}{'; ' * bool(remedy)}{remedy}")
        del places["home"]
    for name, place in places.items():
        why, point = _obstructed(world, name), world.waypoints[name]
        if why == _ROCK and not ((point >= mine.extents[0]) & (point <= mine.extents[1])).all():
            why += f"{reach}{reading() and f'; {reading()}'}"
        elif why == _ROCK and not mine.footprint:
            causes = [mine.bare(point), *(f"the mesh may be the cause: {flaw}" for flaw in flaws()[:1]), reading()]
            why = "; ".join([why, *filter(None, causes)])
        if why:
            yield InputError(f"{place.place}: {name}={list(point[:2])!r} must be in {why}")


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
