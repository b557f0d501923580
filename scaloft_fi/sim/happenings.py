"""Things that happen during a flight: a body appears or walks, light, dust, wind, drift of the localisation.

A plugin declares a kind in a module that its entry point in the group `scaloft_fi.plugins` names:

    @dataclass(frozen=True)
    class Rain(Effect):
        haze_per_m: float

        def apply(self, around: Surroundings, since_s: float) -> None:
            around.haze_per_m += self.haze_per_m
            around.note(rain_per_m=self.haze_per_m)

    HAPPENINGS.declare(
        "rain", HappeningKind(lambda item: Rain(item.need("haze_per_m").number(least=0.0)), signals=("rain_per_m",))
    )

A happening in a study's `world.yaml` is of that kind with `kind: rain`.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from scaloft_fi.document import Item
from scaloft_fi.errors import InputError, did_you_mean
from scaloft_fi.registry import Registry
from scaloft_fi.sim.mesh import Faces, Scene
from scaloft_fi.stack.messages import Point


@dataclass(frozen=True)
class Start:
    """When a happening starts: at a time, or when the vehicle first comes near a place.

    Attributes:
        at_s: earliest time [s from the start of the flight].
        near: place (x, y) [m, world]; None for a time.
        within_m: level distance of the vehicle's centre from the place [m].
    """

    at_s: float = 0.0
    near: tuple[float, float] | None = None
    within_m: float = 0.0

    def has_come(self, now_s: float, x_m: float, y_m: float) -> bool:
        """Whether a happening that has not started yet starts now, with the vehicle at (x, y).

        >>> Start(near=(0.0, 5.0), within_m=1.0).has_come(3.0, 0.0, 4.2)
        True
        """
        if now_s < self.at_s:
            return False
        return self.near is None or math.hypot(x_m - self.near[0], y_m - self.near[1]) <= self.within_m


class Effect(ABC):
    """What a happening does; a frozen object."""

    @property
    def moved(self) -> str:
        """Name of the body that it moves; "" for none."""
        return ""

    @property
    def path(self) -> tuple[tuple[float, float], ...]:
        """Places (x, y) to which it moves that body, in order [m, world]."""
        return ()

    @property
    def top_body_mps(self) -> float:
        """Greatest speed of that body [m/s]."""
        return 0.0

    @property
    def top_wind_mps(self) -> float:
        """Greatest speed of the air that it adds [m/s]."""
        return 0.0

    def prepare(self, around: Surroundings) -> None:  # noqa: B027 - most effects change nothing before they start
        """Change the surroundings before take-off."""

    @abstractmethod
    def apply(self, around: Surroundings, since_s: float) -> None:
        """Change the surroundings, `since_s` after the start [s]; called at every tick while the happening lasts."""


@dataclass(frozen=True)
class Happening:
    """Something that happens in a world.

    Attributes:
        name: unique name.
        signals: names of the signals that a flight with it records.
        start: when it starts.
        lasts_s: how long it lasts [s]; infinite for the rest of the flight.
        effect: what it does.
        place: `file:line`, for errors.
    """

    name: str
    signals: tuple[str, ...]
    start: Start
    lasts_s: float
    effect: Effect
    place: str


class Surroundings:
    """The surroundings of one flight.

    Args:
        scene: the triangles of the world at take-off.
        light: visible light at take-off, 0..1.
        places: where each body stands at take-off, by name [m, world].
        happenings: what happens.

    Attributes:
        light: visible light, 0..1.
        haze_per_m: extinction of light by dust [1/m].
        wind_mps: (3,) velocity of the air [m/s, world].
        drift_m: (3,) error of the localisation [m, world].
        scene: the triangles of the world where they are at this tick.
        shifts: how far each body that can move is from its position, by name [m, world].
        top_body_mps, top_wind_mps: greatest speed of any body, and of the air [m/s].
        noted: sums of what the happenings note at this tick, by signal, in the order of `row`.
    """

    def __init__(
        self, scene: Scene, light: float, places: Mapping[str, Point], happenings: Sequence[Happening]
    ) -> None:
        self._at_rest, self._light, self._places, self._happenings = scene, light, places, tuple(happenings)
        self.light, self.haze_per_m = light, 0.0
        self.wind_mps, self.drift_m = np.zeros(3), np.zeros(3)
        self.scene = scene
        self.shifts: dict[str, Point] = {h.effect.moved: (0.0, 0.0, 0.0) for h in self._happenings if h.effect.moved}
        self.top_body_mps = max((happening.effect.top_body_mps for happening in self._happenings), default=0.0)
        self.top_wind_mps = sum(happening.effect.top_wind_mps for happening in self._happenings)
        self._began_s = [math.inf] * len(self._happenings)
        if self.shifts:
            self.scene = replace(scene, vertices=scene.vertices.copy())
        self._parts = {name: _vertices_of(scene, name) for name in self.shifts}
        self.noted = dict.fromkeys((name for h in self._happenings for name in h.signals), 0.0)
        for happening in self._happenings:
            happening.effect.prepare(self)

    def update(self, now_s: float, x_m: float, y_m: float) -> None:
        """Go on to `now_s` [s], with the vehicle at (x, y) [m, world]."""
        if not self._happenings:
            return
        self.light, self.haze_per_m = self._light, 0.0
        self.wind_mps[:] = self.drift_m[:] = 0.0
        self.noted = dict.fromkeys(self.noted, 0.0)
        for number, happening in enumerate(self._happenings):
            if math.isinf(self._began_s[number]) and happening.start.has_come(now_s, x_m, y_m):
                self._began_s[number] = happening.start.at_s if happening.start.near is None else now_s
            if 0.0 <= now_s - self._began_s[number] <= happening.lasts_s:
                happening.effect.apply(self, now_s - self._began_s[number])

    def move(self, now_s: float) -> None:
        """Move the bodies on to `now_s` [s], which lies within the tick."""
        for number, happening in enumerate(self._happenings):
            if happening.effect.top_body_mps and 0.0 <= now_s - self._began_s[number] <= happening.lasts_s:
                happening.effect.apply(self, now_s - self._began_s[number])

    def shift(self, body: str, by_m: Point) -> None:
        """Put a body at its position plus `by_m` (3,) [m, world]."""
        if self.shifts[body] != by_m:
            self.shifts[body] = by_m
            part = self._parts[body]
            self.scene.vertices[part] = self._at_rest.vertices[part] + by_m

    def position(self, body: str) -> tuple[float, float]:
        """Where a body stands at take-off, (x, y) [m, world]."""
        x, y, _ = self._places[body]
        return x, y

    def note(self, **values: float) -> None:
        """Add values to the signals that the kinds of the happenings declare."""
        for name, value in values.items():
            self.noted[name] += value

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the signals that a flight records of the happenings; none in a world without them."""
        return signals_of(self._happenings)

    @property
    def began(self) -> list[tuple[float, str]]:
        """Start [s] and name of each happening that has started."""
        pairs = zip(self._began_s, self._happenings, strict=True)
        return [(began_s, happening.name) for began_s, happening in pairs if math.isfinite(began_s)]

    def row(self) -> list[float]:
        """The values of `names`."""
        moved = zip(map(self.position, self.shifts), self.shifts.values(), strict=True)
        return [*self.noted.values(), *(at + by for place, by_m in moved for at, by in zip(place, by_m, strict=False))]


def signals_of(happenings: Collection[Happening]) -> tuple[str, ...]:
    """Names of the signals that a flight with these happenings records."""
    noted = dict.fromkeys(name for happening in happenings for name in happening.signals)
    moved = dict.fromkeys(happening.effect.moved for happening in happenings if happening.effect.moved)
    return (*noted, *(f"{body}_{axis}_m" for body in moved for axis in "xy"))


def _vertices_of(scene: Scene, body: str) -> Faces:
    """Indices of the vertices of a body."""
    return np.unique(scene.faces[scene.owner == scene.names.index(body)])


@dataclass(frozen=True)
class HappeningKind:
    """A declared kind of happening.

    Attributes:
        read: reads the effect from the happening's entry in `world.yaml`; the keys `kind`, `active`, `start` and
            `lasts_s` are the framework's.
        check: called with the effect, the `sim.world.World` and the item; refuses an effect that this world cannot
            have, with an `InputError` that begins with a place.
        signals: names of the signals that a flight with such a happening records; `apply` notes their values.
    """

    read: Callable[[Item], Effect]
    check: Callable[[Any, Any, Item], None] = lambda _effect, _world, _item: None
    signals: tuple[str, ...] = ()


HAPPENINGS = Registry[HappeningKind]("kind of happening")


class Read(NamedTuple):
    """A happening with its kind and its entry in `world.yaml`."""

    happening: Happening
    kind: HappeningKind
    item: Item


def read_happenings(item: Item | None) -> tuple[Read, ...]:
    """Read the active happenings of a world; `check_happenings` checks them against the world.

    Raises:
        InputError: a value is not allowed, a key or a kind is unknown.
    """
    entries = item.mapping().items() if item else ()
    return tuple(found for name, entry in entries if (found := read_happening(name, entry)) is not None)


def read_happening(name: str, item: Item) -> Read | None:
    """Read one happening; None for one that is not active.

    Raises:
        InputError: a value is not allowed, a key or the kind is unknown.
    """
    kind_item, lasts = item.need("kind"), item.get("lasts_s")
    kind = HAPPENINGS[kind_item.choice(tuple(HAPPENINGS))]
    active = item.need("active").flag()
    happening = Happening(
        name=name,
        signals=kind.signals,
        start=_start(item.get("start")),
        lasts_s=lasts.number(above=0.0) if lasts else math.inf,
        effect=kind.read(item),
        place=item.place,
    )
    item.close()
    return Read(happening, kind, item) if active else None


def _start(item: Item | None) -> Start:
    if item is None:
        return Start()
    at_s, near, within = item.get("at_s"), item.get("near"), item.get("within_m")
    if (near is None) != (within is None) or (near is None and at_s is None):
        raise InputError(f"{item.place}: start must have at_s, or near and within_m")
    x, y = near.numbers(2) if near else (0.0, 0.0)
    start = Start(
        at_s=at_s.number(least=0.0) if at_s else 0.0,
        near=(x, y) if near else None,
        within_m=within.number(above=0.0) if within else 0.0,
    )
    item.close()
    return start


def check_happenings(world: Any, found: tuple[Read, ...]) -> None:
    """Refuse a happening that cannot come, that this world cannot have, or that moves a body as another does.

    Raises:
        InputError: as above; the message names the place.
    """
    moved: dict[str, str] = {}
    for happening, kind, item in found:
        near = happening.start.near
        if near is not None and not world.mine.holds((*near, world.mission.altitude_m)):
            raise InputError(
                f"{item.need('start').place}: near={list(near)!r} must be in the open space of the mine, or "
                f"happening {happening.name!r} cannot come"
            )
        kind.check(happening.effect, world, item)
        body = happening.effect.moved
        if body and moved.setdefault(body, happening.name) != happening.name:
            raise InputError(f"{item.place}: body {body!r} is moved by happening {moved[body]!r} already")


MOST_WALK_MPS = 10.0
MOST_PLACES = 1000


@dataclass(frozen=True)
class Walk(Effect):
    """A body goes from its position straight to each place of a path, and stays at the last one.

    Attributes:
        body: name of the body.
        places: places (x, y) [m, world].
        speed_mps: its speed [m/s].
    """

    body: str
    places: tuple[tuple[float, float], ...]
    speed_mps: float

    @property
    def moved(self) -> str:
        """The body."""
        return self.body

    @property
    def path(self) -> tuple[tuple[float, float], ...]:
        """The places."""
        return self.places

    @property
    def top_body_mps(self) -> float:
        """The body's speed [m/s]."""
        return self.speed_mps

    @classmethod
    def read(cls, item: Item) -> Walk:
        """Read it."""
        path_item = item.need("path")
        path = tuple((x, y) for x, y in (place.numbers(2) for place in path_item))
        if not 0 < len(path) <= MOST_PLACES:
            raise path_item.error(f"a list of 1 to {MOST_PLACES} places [x, y]")
        return cls(item.need("body").text(), path, item.need("speed_mps").number(above=0.0, most=MOST_WALK_MPS))

    def shift(self, start: tuple[float, float], since_s: float) -> tuple[float, float]:
        """How far the body has moved from its position `start` [m].

        >>> Walk("person", ((0.0, 2.0), (1.0, 2.0)), 0.5).shift((0.0, 0.0), 5.0)
        (0.5, 2.0)
        """
        left_m = max(0.0, since_s) * self.speed_mps
        x, y = start
        for to_x, to_y in self.places:
            leg_m = math.hypot(to_x - x, to_y - y)
            if left_m < leg_m:
                share = left_m / leg_m
                return x + share * (to_x - x) - start[0], y + share * (to_y - y) - start[1]
            x, y, left_m = to_x, to_y, left_m - leg_m
        return x - start[0], y - start[1]

    def apply(self, around: Surroundings, since_s: float) -> None:
        """Move the body; it stays where it is when the happening ends."""
        around.shift(self.body, (*self.shift(around.position(self.body), since_s), 0.0))


def _check(walk: Walk, world: Any, item: Item) -> None:
    """Refuse a body that is not there, and a path through a wall."""
    check_body(walk.body, world, item)
    mine, body = world.mine, world.bodies[walk.body]
    z_m = body.centre[2]
    here = (body.centre[0], body.centre[1])
    for place, entry in zip(walk.places, item.need("path"), strict=True):
        if mine.is_between(here, place, z_m) or not mine.holds((*place, z_m)):
            raise InputError(
                f"{entry.place}: path of {walk.body!r} from {list(here)} to {list(place)} must not lead through a wall"
            )
        here = place


def check_body(name: str, world: Any, item: Item) -> None:
    """Refuse a body that is unknown or not present.

    Raises:
        InputError: as above.
    """
    place = item.need("body").place
    if name not in world.bodies:
        raise InputError(f"{place}: no body {name!r}{did_you_mean(name, world.bodies)}")
    if not world.bodies[name].present:
        raise InputError(f"{place}: body={name!r} must be present for the happening {item.name!r}")


HAPPENINGS.declare("walk", HappeningKind(Walk.read, check=_check))


HIDDEN_M = (0.0, 0.0, -1000.0)
"""Shift of a body that has not appeared: under the mine, out of every sensor's range [m]."""


@dataclass(frozen=True)
class Appear(Effect):
    """The body `body` is not there before the start; it stays when the happening ends."""

    body: str

    @property
    def moved(self) -> str:
        """The body."""
        return self.body

    @classmethod
    def read(cls, item: Item) -> Appear:
        """Read it."""
        return cls(item.need("body").text())

    def prepare(self, around: Surroundings) -> None:
        """Hide the body at take-off."""
        around.shift(self.body, HIDDEN_M)

    def apply(self, around: Surroundings, since_s: float) -> None:
        """Put the body at its position."""
        around.shift(self.body, (0.0, 0.0, 0.0))


HAPPENINGS.declare(
    "appear", HappeningKind(Appear.read, check=lambda effect, world, item: check_body(effect.body, world, item))
)


@dataclass(frozen=True)
class Drift(Effect):
    """Every fix is off by `rate_mps` (3,) [m/s, world] times the time since the start; it jumps back at the end."""

    rate_mps: tuple[float, float, float]

    @classmethod
    def read(cls, item: Item) -> Drift:
        """Read it."""
        x, y, z = item.need("rate_mps").numbers(3)
        return cls((x, y, z))

    def apply(self, around: Surroundings, since_s: float) -> None:
        """Add to the error of the fixes."""
        x, y, z = (rate_mps * since_s for rate_mps in self.rate_mps)
        around.drift_m += (x, y, z)
        around.note(drift_x_m=x, drift_y_m=y, drift_z_m=z)


HAPPENINGS.declare("drift", HappeningKind(Drift.read, signals=("drift_x_m", "drift_y_m", "drift_z_m")))


MOST_PER_M = 10.0
"""Greatest extinction: at 10 per metre a wall half a metre away has less than 1 % of its contrast."""


@dataclass(frozen=True)
class Dust(Effect):
    """Dust: light falls to exp(-haze_per_m * distance) (Beer-Lambert; the contrast of a picture too, Koschmieder 1924).

    The distance of sight (5 % contrast) is 3 / haze_per_m.
    """

    haze_per_m: float

    @classmethod
    def read(cls, item: Item) -> Dust:
        """Read it."""
        return cls(item.need("haze_per_m").number(above=0.0, most=MOST_PER_M))

    def apply(self, around: Surroundings, since_s: float) -> None:
        """Add to the extinction of the air."""
        around.haze_per_m += self.haze_per_m
        around.note(haze_per_m=self.haze_per_m)


HAPPENINGS.declare("dust", HappeningKind(Dust.read, signals=("haze_per_m",)))


@dataclass(frozen=True)
class Light(Effect):
    """The visible light becomes `light`, 0..1."""

    light: float

    @classmethod
    def read(cls, item: Item) -> Light:
        """Read it."""
        return cls(item.need("light").number(least=0.0, most=1.0))

    def apply(self, around: Surroundings, since_s: float) -> None:
        """Set the light; of two that last at the same time, the later one in the file decides."""
        around.light = self.light


HAPPENINGS.declare("light", HappeningKind(Light.read))


MOST_WIND_MPS = 30.0


@dataclass(frozen=True)
class Wind(Effect):
    """Wind, the same everywhere [m/s, world]; its force is the vehicle's drag times the velocity."""

    velocity_mps: tuple[float, float, float]

    @property
    def top_wind_mps(self) -> float:
        """The speed of the wind [m/s]."""
        return math.hypot(*self.velocity_mps)

    @classmethod
    def read(cls, item: Item) -> Wind:
        """Read it."""
        velocity = item.need("velocity_mps")
        x, y, z = velocity.numbers(3)
        if max(abs(x), abs(y), abs(z)) > MOST_WIND_MPS:
            raise velocity.error(f"3 numbers from -{MOST_WIND_MPS:g} to {MOST_WIND_MPS:g}")
        return cls((x, y, z))

    def apply(self, around: Surroundings, since_s: float) -> None:
        """Add to the wind."""
        x, y, z = self.velocity_mps
        around.wind_mps += self.velocity_mps
        around.note(wind_x_mps=x, wind_y_mps=y, wind_z_mps=z)


HAPPENINGS.declare("wind", HappeningKind(Wind.read, signals=("wind_x_mps", "wind_y_mps", "wind_z_mps")))
