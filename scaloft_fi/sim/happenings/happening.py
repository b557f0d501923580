"""Happenings: what changes around the vehicle during a flight, when it starts, and how long it lasts."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from scaloft_fi.sim.optics import Faces, Scene
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
