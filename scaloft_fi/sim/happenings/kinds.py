"""Kinds of happenings: their registry, and the happenings of a `world.yaml`.

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
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

from scaloft_fi.document import Item
from scaloft_fi.errors import InputError
from scaloft_fi.registry import Registry
from scaloft_fi.sim.happenings.happening import Effect, Happening, Start


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
