"""The world of a flight: mine, bodies with their roles, waypoints, mission and light, read from `world.yaml`.

A plugin declares a role in a module that its entry point in the group `scaloft_fi.plugins` names:

    ROLES.declare("dog", Role("an animal that may stand in the way", label="dog", fill="#d6d3d1"))

A body in a study's `world.yaml` gets the role with `role: dog`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Any

import numpy as np

from scaloft_fi.document import Item
from scaloft_fi.errors import InputError, did_you_mean
from scaloft_fi.registry import Registry
from scaloft_fi.sim import mesh
from scaloft_fi.sim.happenings import Happening, Read, Surroundings, check_happenings, read_happenings
from scaloft_fi.sim.log import SIGNALS, truth_signals
from scaloft_fi.sim.mesh import FARTHEST_M, Mesh, Scene, flaws_of
from scaloft_fi.sim.mine import Mine, read_mine


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

SHAPES = ("box", "cylinder", "capsule")

Point = tuple[float, float, float]


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
        climb_mps, sink_mps: speed of climb at the start, speed of descent at the end [m/s].
        turn_radps: rate of a turn on the spot [rad/s].
        dwell_s: pause after take-off [s].
    """

    climb_mps: float
    sink_mps: float
    turn_radps: float
    dwell_s: float


@dataclass(frozen=True)
class MissionPlan:
    """The mission of the vehicle.

    Attributes:
        home: (x, y) of take-off and landing [m, world].
        yaw_rad: heading at the start [rad].
        route: names of the waypoints in order; it lands at the last one.
        altitude_m: altitude of flight, where a waypoint has none of its own [m].
        cruise_mps, slow_mps: speed before and after the first detection of a person [m/s].
        nominal: other speeds of the nominal flight.
    """

    home: tuple[float, float]
    yaw_rad: float
    route: tuple[str, ...]
    altitude_m: float
    cruise_mps: float
    slow_mps: float
    nominal: Nominal


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


def read_world(item: Item, mine: Mine | None = None) -> World:
    """Read and check a world; `mine` is its mine, if that was read already.

    Raises:
        InputError: a value is not allowed, a key is unknown, a waypoint is not in open space.
    """
    world, happenings = assembled(item, mine)
    for error in misplaced(world, item):
        raise error
    check_happenings(world, happenings)
    return world


def assembled(item: Item, mine: Mine | None = None) -> tuple[World, tuple[Read, ...]]:
    """Read a world and its active happenings, without a check that they fit together.

    Raises:
        InputError: a value is not allowed, or a key is unknown.
    """
    mine_item = item.need("mine")
    mine = read_mine(mine_item) if mine is None else mine
    bodies = {name: read_body(name, body) for name, body in item.need("bodies").mapping(most=MOST_BODIES).items()}
    waypoint_items = item.need("waypoints").mapping(most=MOST_WAYPOINTS)
    mission_item = item.need("mission")
    if "home" in waypoint_items:
        raise InputError(f"{waypoint_items['home'].place}: home is no waypoint of its own; it is set under mission")
    mission = read_mission(mission_item, waypoint_items)
    waypoints = {name: read_waypoint(entry, mission.altitude_m) for name, entry in waypoint_items.items()}
    happenings = read_happenings(item.get("happenings"))
    world = World(
        mine=mine,
        bodies=bodies,
        waypoints={"home": (*mission.home, mission.altitude_m), **waypoints},
        mission=mission,
        light=read_light(item.need("light")),
        signals=read_signals(item.get("signals"), (WALL, GROUND, *bodies)),
        happenings=tuple(read.happening for read in happenings),
    )
    item.close()
    return world, happenings


def read_light(item: Item) -> float:
    """Read the brightness of visible light, 0..1.

    Raises:
        InputError: it is none.
    """
    return item.number(least=0.0, most=1.0)


def read_signals(item: Item | None, surfaces: Iterable[str]) -> tuple[str, ...]:
    """Read the names of the optional signals.

    Raises:
        InputError: a name is unknown, belongs to a signal that every flight has, or is listed twice.
    """
    known = {signal.name for signal in truth_signals(surfaces)}
    names: list[str] = []
    for entry in item or ():
        name = entry.choice(tuple(SIGNALS))
        if name in known or name in names:
            raise InputError(f"{entry.place}: signal {name!r} is recorded already; list it once, or not at all")
        names.append(name)
    return tuple(names)


def read_waypoint(item: Item, altitude_m: float) -> Point:
    """A waypoint [x, y] at the altitude of the mission, or [x, y, z].

    Raises:
        InputError: it is none.
    """
    numbers = item.numbers()
    if len(numbers) not in (2, 3):
        raise item.error("[x, y] or [x, y, z]")
    return numbers[0], numbers[1], numbers[2] if len(numbers) == 3 else altitude_m


def _pair(item: Item) -> tuple[float, float]:
    x, y = item.numbers(2)
    return x, y


def read_body(name: str, item: Item) -> Body:
    """Read one body.

    Raises:
        InputError: a value is not allowed, or a key is unknown.
    """
    if name in (WALL, GROUND) or not name.isidentifier():
        raise InputError(
            f"{item.place}: body {name!r} must have a name of letters, digits and _ other than 'wall' and 'ground'"
        )
    role = item.need("role").choice(tuple(ROLES))
    shape = item.need("shape").choice(SHAPES)
    if shape == "box":
        size_item = item.need("size_m")
        size = size_item.numbers(3, most=FARTHEST_M)
        if min(size) < LEAST_M:
            raise size_item.error(f"3 numbers >= {LEAST_M:g}")
        form, height_m = mesh.box(size), size[2]
        core = mesh.box([edge - 2.0 * MARGIN_M for edge in size])
    else:
        radius_m = item.need("radius_m").number(least=LEAST_M, most=FARTHEST_M)
        height_m = item.need("height_m").number(
            least=2.0 * radius_m if shape == "capsule" else LEAST_M, most=2.0 * FARTHEST_M
        )
        turned = mesh.cylinder if shape == "cylinder" else mesh.capsule
        form, core = turned(radius_m, height_m), turned(radius_m - MARGIN_M, height_m - 2.0 * MARGIN_M)
    position_item = item.need("position")
    position = position_item.numbers(least=-FARTHEST_M, most=FARTHEST_M)
    if len(position) not in (2, 3):
        raise position_item.error("[x, y] or [x, y, z of the foot]")
    foot_m = position[2] if len(position) == 3 else 0.0
    centre = (position[0], position[1], foot_m + 0.5 * height_m)
    body = Body(
        name=name,
        role=role,
        mesh=form.moved(centre),
        core=core.moved(centre),
        centre=centre,
        reflectivity=item.need("reflectivity").number(least=0.0, most=1.0),
        present=item.need("present").flag(),
        optional=optional.flag() if (optional := item.get("optional")) else False,
    )
    item.close()
    return body


def read_mission(item: Item, waypoints: Collection[str]) -> MissionPlan:
    """Read the mission.

    Args:
        item: its entry.
        waypoints: names of the waypoints.

    Raises:
        InputError: a value is not allowed, or a key or waypoint is unknown.
    """
    route_item = item.need("route")
    route = []
    for entry in route_item.items(most=MOST_WAYPOINTS):
        name = entry.text()
        if name != "home" and name not in waypoints:
            raise InputError(f"{entry.place}: no waypoint {name!r}{did_you_mean(name, ['home', *waypoints])}")
        route.append(name)
    if not route:
        raise route_item.error("a list of waypoints, where the mission lands at the last one")
    nominal_item = item.need("nominal")
    nominal = Nominal(
        climb_mps=nominal_item.need("climb_mps").number(above=0.0),
        sink_mps=nominal_item.need("sink_mps").number(above=0.0),
        turn_radps=math.radians(nominal_item.need("turn_degps").number(above=0.0)),
        dwell_s=nominal_item.need("dwell_s").number(least=0.0),
    )
    nominal_item.close()
    mission = MissionPlan(
        home=_pair(item.need("home")),
        yaw_rad=math.radians(item.need("yaw_deg").number()),
        route=tuple(route),
        altitude_m=item.need("altitude_m").number(above=0.0),
        cruise_mps=item.need("cruise_mps").number(above=0.0),
        slow_mps=item.need("slow_mps").number(above=0.0),
        nominal=nominal,
    )
    item.close()
    return mission


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
