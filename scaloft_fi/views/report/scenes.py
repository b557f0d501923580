"""What stands in each situation, for the page's map."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from scaloft_fi.views.pictures.scene import scene_of

if TYPE_CHECKING:
    from scaloft_fi.study import Study

DIGITS = 2
"""Centimetres."""


def scenes(study: Study, situations: Iterable[str]) -> dict[str, Any]:
    """The mines, each once, and by situation its mine, bodies, waypoints and home [m, world].

    Raises:
        InputError: the values of a situation do not go together.
    """
    mines: list[dict[str, Any]] = []
    by: dict[str, Any] = {}
    for key in situations:
        scene = scene_of(study.grid.world(study.grid.situation(key)))
        floor = [_outline(ring) for ring in scene.floor]
        # a closed floor draws its own walls
        mine = {"floor": floor, "walls": [] if floor else [_outline(segment) for segment in scene.walls]}
        if mine not in mines:
            mines.append(mine)
        by[key] = {
            "mine": mines.index(mine),
            "bodies": [[body.kind, _outline(body.outline), _outline(body.path)] for body in scene.bodies],
            "waypoints": _outline(scene.waypoints),
            "home": _rounded(scene.home),
        }
    return {"mines": mines, "situations": by}


def _outline(points: Iterable[tuple[float, float]]) -> list[list[float]]:
    return [_rounded(point) for point in points]


def _rounded(point: tuple[float, float]) -> list[float]:
    return [round(float(point[0]), DIGITS), round(float(point[1]), DIGITS)]
