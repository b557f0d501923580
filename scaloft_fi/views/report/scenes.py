"""What stands in each situation, for the page's map."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from scaloft_fi.views.pictures.scene import scene_of

if TYPE_CHECKING:
    from scaloft_fi.sim.world import World
    from scaloft_fi.study import Study

DIGITS = 2
"""Centimetres."""


def scenes(study: Study, situations: Iterable[str]) -> dict[str, Any]:
    """The mines, each once, and by situation its scene.

    Raises:
        InputError: the values of a situation do not go together.
    """
    mines: list[dict[str, Any]] = []
    by = {key: scene(study.grid.world(study.grid.situation(key)), mines) for key in situations}
    return {"mines": mines, "situations": by}


def scene(world: World, mines: list[dict[str, Any]]) -> dict[str, Any]:
    """The place of a world's mine in `mines`, to which it is added, and bodies, waypoints and home [m, world].

    A body is its role, its outline, the path of one that moves, and its name, which `struck` has too.
    """
    seen = scene_of(world)
    floor = [_outline(ring) for ring in seen.floor]
    # a closed floor draws its own walls
    mine = {"floor": floor, "walls": [] if floor else [_outline(segment) for segment in seen.walls]}
    if mine not in mines:
        mines.append(mine)
    return {
        "mine": mines.index(mine),
        "bodies": [
            [body.kind, _outline(body.outline), _outline(body.path), own.name]
            for own, body in zip(world.present, seen.bodies, strict=True)
        ],
        "waypoints": _outline(seen.waypoints),
        "home": _rounded(seen.home),
    }


def _outline(points: Iterable[tuple[float, float]]) -> list[list[float]]:
    return [_rounded(point) for point in points]


def _rounded(point: tuple[float, float]) -> list[float]:
    return [round(float(point[0]), DIGITS), round(float(point[1]), DIGITS)]
