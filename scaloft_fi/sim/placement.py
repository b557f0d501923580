"""Whether home and waypoints of a world are in open space."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import cache
from typing import Any

from scaloft_fi.document import Item
from scaloft_fi.errors import InputError

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
    from scaloft_fi.sim.mesh_flaws import flaws_of  # brings scipy

    flaws = sorted(flaws_of(item.need("mine")), key=lambda flaw: not flaw.grave)
    return f"; the mesh may be the cause: {flaws[0]}" if flaws else ""
