"""A body that moves along a path, such as a person who walks."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from scaloft_fi.document import Item
from scaloft_fi.errors import InputError, did_you_mean
from scaloft_fi.sim.happenings.happening import Effect, Surroundings
from scaloft_fi.sim.happenings.kinds import HAPPENINGS, HappeningKind

MOST_MPS = 10.0
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
        return cls(item.need("body").text(), path, item.need("speed_mps").number(above=0.0, most=MOST_MPS))

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
