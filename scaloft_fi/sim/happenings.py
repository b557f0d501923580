"""Things that happen during a flight: a body appears or walks, light, dust, wind, drift of the localisation.

A plugin declares a kind in a module that its entry point in the group `scaloft_fi.plugins` names:

    @dataclass(frozen=True)
    class Rain(Effect):
        haze_per_m: NotNegative

        def apply(self, around: Surroundings, since_s: float) -> None:
            around.haze_per_m += self.haze_per_m
            around.note(rain_per_m=self.haze_per_m)

    HAPPENINGS.declare("rain", HappeningKind(Rain, signals=("rain_per_m",)))

A happening in a study's `world.yaml` is of that kind with `kind: rain`.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import chain
from typing import Annotated, Any, ClassVar

import numpy as np

from scaloft_fi.document import Item
from scaloft_fi.errors import DeclaredError, Faults, InputError, did_you_mean, refused
from scaloft_fi.marks import Bounds, Called, Choices, Examples, MoreThanZero, NotNegative, Share, Size
from scaloft_fi.model import Names, Schema, keys_of, read, schema, summary_of
from scaloft_fi.registry import Registry
from scaloft_fi.sim.mesh import Scene
from scaloft_fi.stack.messages import Point


@dataclass(frozen=True)
class Start:
    """When a happening starts: at a time, or when the vehicle first comes near a place.

    Attributes:
        at_s: earliest time from the start of the flight [s].
        near: the vehicle comes near this place x, y [m, world]; left out: a time.
        within_m: level distance of the vehicle's centre from the place [m].
    """

    at_s: Annotated[NotNegative, Examples(20.0)] = 0.0
    near: Annotated[tuple[float, float] | None, Examples((0.0, 3.5))] = None
    within_m: Annotated[MoreThanZero, Examples(0.7)] = 0.0
    CONDITIONS: ClassVar[Mapping[str, object]] = {
        "dependentRequired": {"near": ["within_m"], "within_m": ["near"]},
        "anyOf": [{"required": ["at_s"]}, {"required": ["near"]}],
    }

    def contradictions(self, item: Item) -> Iterator[InputError]:
        """Refuse a place without its distance, and a start that is none."""
        if (self.near is None) != (item.get("within_m") is None) or (self.near is None and not item.get("at_s")):
            yield InputError(f"{item.place}: start must have at_s, or near and within_m")

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
class HappeningKind:
    """A declared kind of happening.

    Attributes:
        effect: the model of the happening's entry in `world.yaml` (`scaloft_fi.model`), without the framework's keys:
            `kind`, `active`, `start` and `lasts_s`.
        check: called with the effect, the `sim.world.World` and the item; refuses an effect that this world cannot
            have, with an `InputError` that begins with a place.
        signals: names of the signals that a flight with such a happening records; `apply` notes their values.
    """

    effect: type[Effect]
    check: Callable[[Any, Any, Item], None] = lambda _effect, _world, _item: None
    signals: tuple[str, ...] = ()


HAPPENINGS = Registry[HappeningKind]("kind of happening")


@dataclass(frozen=True)
class Happening:
    """Something that happens in a world.

    Attributes:
        name: unique name.
        kind: what kind it is.
        start: when it starts.
        lasts_s: how long it lasts [s]; infinite for the rest of the flight.
        effect: what it does.
        item: its entry in `world.yaml`.
    """

    name: str
    kind: HappeningKind
    start: Start
    lasts_s: float
    effect: Effect
    item: Item


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
        # indices of the vertices of each body
        self._parts = {name: np.unique(scene.faces[scene.owner == scene.names.index(name)]) for name in self.shifts}
        self.noted = dict.fromkeys((name for h in self._happenings for name in h.kind.signals), 0.0)
        for happening in self._happenings:
            happening.effect.prepare(self)

    def update(self, now_s: float, x_m: float, y_m: float) -> None:
        """Go on to `now_s` [s], with the vehicle at (x, y) [m, world].

        Raises:
            DeclaredError: a happening makes light, haze, wind, drift or a place that is not finite.
        """
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
                made = (self.light, self.haze_per_m, *self.wind_mps, *self.drift_m, *chain(*self.shifts.values()))
                if not math.isfinite(sum(made)):
                    told = "light, haze, wind, drift or a place that is not finite"
                    sentence = f"happening {happening.name!r} at {now_s:.3f} s makes {told}"
                    raise DeclaredError(sentence, type(happening.effect).__module__)

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
        if not self.shifts:
            return list(self.noted.values())
        moved = zip(map(self.position, self.shifts), self.shifts.values(), strict=True)
        return [*self.noted.values(), *(at + by for place, by_m in moved for at, by in zip(place, by_m, strict=False))]


def signals_of(happenings: Collection[Happening]) -> tuple[str, ...]:
    """Names of the signals that a flight with these happenings records."""
    noted = dict.fromkeys(name for happening in happenings for name in happening.kind.signals)
    moved = dict.fromkeys(happening.effect.moved for happening in happenings if happening.effect.moved)
    return (*noted, *(f"{body}_{axis}_m" for body in moved for axis in "xy"))


@dataclass(frozen=True)
class Occasion:
    """What every happening has.

    Attributes:
        kind: which of the kinds it is.
        active: whether it happens; an axis may set this.
        start: when it starts; left out: at take-off.
        lasts_s: how long it lasts; left out: to the end of the flight [s].
    """

    kind: Annotated[str, Choices(HAPPENINGS.keys)]
    active: bool
    start: Start = Start()
    lasts_s: Annotated[MoreThanZero, Examples(5.0)] = math.inf


def read_happenings(item: Item) -> tuple[Happening, ...]:
    """Read the active happenings of a world; `misfits` holds them against the world.

    Raises:
        InputError: a value is not allowed, a key or a kind is unknown.
    """
    faults, found = Faults(), list[Happening]()
    for name, entry in item.mapping().items():
        with faults.collecting():
            kind, inner = HAPPENINGS[entry.need("kind").choice(tuple(HAPPENINGS))], Faults()
            with inner.collecting():
                occasion = read(Occasion, entry, beside=keys_of(kind.effect))
            with inner.collecting():
                effect = read(kind.effect, entry, beside=(*entry.mapping(), *keys_of(Occasion)))
            inner.end()
            if occasion.active:
                found.append(Happening(name, kind, occasion.start, occasion.lasts_s, effect, entry))
    faults.end()
    return tuple(found)


def happenings_schema(names: Names) -> Schema:
    """The JSON Schema of the happenings of a world: a form for each kind."""
    kinds = []
    for name in names.get("happenings", HAPPENINGS):
        effect = HAPPENINGS[name].effect
        framework, own, about = schema(Occasion), schema(effect), summary_of(effect)
        properties = {**framework["properties"], "kind": {"const": name, "description": about}, **own["properties"]}
        required = [*framework["required"], *own["required"]]
        kinds.append({**framework, "description": about, "properties": properties, "required": required})
    each = {"description": "What changes around the vehicle.", "oneOf": kinds}
    return {"type": "object", "additionalProperties": each}


def misfits(world: Any) -> Iterator[InputError]:
    """An error for each happening that cannot come, that this world cannot have, or that moves a body as another does.

    Args:
        world: the `sim.world.World`.
    """
    moved: dict[str, str] = {}
    for happening in world.happenings:
        near, item = happening.start.near, happening.item
        if near is not None and not world.mine.holds((*near, world.mission.altitude_m)):
            sentence = f"near={list(near)!r} must be in the open space of the mine"
            yield InputError(f"{item.need('start').place}: {sentence}, or happening {happening.name!r} cannot come")
        if error := refused(happening.kind.check, happening.effect, world, item):
            yield error
        body = happening.effect.moved
        if body and moved.setdefault(body, happening.name) != happening.name:
            yield InputError(f"{item.place}: body {body!r} is moved by happening {moved[body]!r} already")


MOST_WALK_MPS = 10.0
MOST_PLACES = 1000
_PLACES = f"a list of 1 to {MOST_PLACES} places [x, y]"


@dataclass(frozen=True)
class Walk(Effect):
    """A body goes from its position straight to each place of a path, and stays at the last one.

    Attributes:
        body: name of a present body of this file.
        places: places x, y that the body goes to, straight, in order [m, world].
        speed_mps: its speed [m/s].
    """

    body: str
    places: Annotated[tuple[tuple[float, float], ...], Called("path"), Size(1, MOST_PLACES, _PLACES)]
    speed_mps: Annotated[float, Bounds(above=0.0, most=MOST_WALK_MPS)]

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
            way = f"path of {walk.body!r} from {list(here)} to {list(place)}"
            raise InputError(f"{entry.place}: {way} must not lead through a wall")
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


HAPPENINGS.declare("walk", HappeningKind(Walk, check=_check))


HIDDEN_M = (0.0, 0.0, -1000.0)
"""Shift of a body that has not appeared: under the mine, out of every sensor's range [m]."""


@dataclass(frozen=True)
class Appear(Effect):
    """A body is not there before the start; it stays when the happening ends.

    Attributes:
        body: name of a present body of this file.
    """

    body: str

    @property
    def moved(self) -> str:
        """The body."""
        return self.body

    def prepare(self, around: Surroundings) -> None:
        """Hide the body at take-off."""
        around.shift(self.body, HIDDEN_M)

    def apply(self, around: Surroundings, since_s: float) -> None:
        """Put the body at its position."""
        around.shift(self.body, (0.0, 0.0, 0.0))


HAPPENINGS.declare("appear", HappeningKind(Appear, check=lambda own, world, item: check_body(own.body, world, item)))


@dataclass(frozen=True)
class Drift(Effect):
    """The localisation drifts; it jumps back at the end.

    Attributes:
        rate_mps: every fix is off by this rate x, y, z times the time since the start [m/s, world].
    """

    rate_mps: tuple[float, float, float]

    def apply(self, around: Surroundings, since_s: float) -> None:
        """Add to the error of the fixes."""
        x, y, z = (rate_mps * since_s for rate_mps in self.rate_mps)
        around.drift_m += (x, y, z)
        around.note(drift_x_m=x, drift_y_m=y, drift_z_m=z)


HAPPENINGS.declare("drift", HappeningKind(Drift, signals=("drift_x_m", "drift_y_m", "drift_z_m")))


MOST_PER_M = 10.0
"""Greatest extinction: at 10 per metre a wall half a metre away has less than 1 % of its contrast."""


@dataclass(frozen=True)
class Dust(Effect):
    """Dust: light falls to exp(-haze_per_m * distance) (Beer-Lambert; the contrast of a picture too, Koschmieder 1924).

    Attributes:
        haze_per_m: extinction of light; 5 % of the contrast is left after 3 / haze_per_m [1/m].
    """

    haze_per_m: Annotated[float, Bounds(above=0.0, most=MOST_PER_M)]

    def apply(self, around: Surroundings, since_s: float) -> None:
        """Add to the extinction of the air."""
        around.haze_per_m += self.haze_per_m
        around.note(haze_per_m=self.haze_per_m)


HAPPENINGS.declare("dust", HappeningKind(Dust, signals=("haze_per_m",)))


@dataclass(frozen=True)
class Light(Effect):
    """The visible light changes.

    Attributes:
        light: it becomes this, 0 (dark) to 1.
    """

    light: Share

    def apply(self, around: Surroundings, since_s: float) -> None:
        """Set the light; of two that last at the same time, the later one in the file decides."""
        around.light = self.light


HAPPENINGS.declare("light", HappeningKind(Light))


WindSpeed = Annotated[float, Bounds(least=-30.0, most=30.0)]


@dataclass(frozen=True)
class Wind(Effect):
    """Wind, the same everywhere; its force is the vehicle's drag times the velocity.

    Attributes:
        velocity_mps: velocity of the air x, y, z [m/s, world].
    """

    velocity_mps: tuple[WindSpeed, WindSpeed, WindSpeed]

    @property
    def top_wind_mps(self) -> float:
        """The speed of the wind [m/s]."""
        return math.hypot(*self.velocity_mps)

    def apply(self, around: Surroundings, since_s: float) -> None:
        """Add to the wind."""
        x, y, z = self.velocity_mps
        around.wind_mps += self.velocity_mps
        around.note(wind_x_mps=x, wind_y_mps=y, wind_z_mps=z)


HAPPENINGS.declare("wind", HappeningKind(Wind, signals=("wind_x_mps", "wind_y_mps", "wind_z_mps")))
