"""The plan of a situation before any flight: mine, bodies, route and happenings by name, with a scale."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import hypot

from scaloft_fi.views.picture import (
    FAINT,
    INK,
    LINE_STYLE,
    MARGIN,
    SCALE,
    Frame,
    MapScene,
    Point,
    axes,
    extent,
    ground,
    signs,
    svg,
    text,
)

LARGEST_PX = 1100.0
"""Greatest width and height of the mine in the picture; a larger mine is drawn smaller [px]."""
TOP, LINE, LETTER, ARROW_PX = 84.0, 19.0, 6.9, 7.0
BESIDE_PX = 4.0
"""How far right of the straight line a leg is drawn, so that out and back are two lines [px]."""
STEPS_M = (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000)
HAPPENS = "#7c3aed"


@dataclass(frozen=True)
class Happens:
    """What happens at a place.  near: where the vehicle starts it, within_m of it; None for a time [m, world]."""

    words: str
    near: Point | None = None
    within_m: float = 0.0


@dataclass(frozen=True)
class FloorPlan:
    """A situation from above.

    Attributes:
        scene: what stands in it.
        places: name and place of each waypoint of the route, in its order [m, world].
        happenings: what happens.
        facts: lines under the plan.
    """

    scene: MapScene
    places: tuple[tuple[str, Point], ...]
    happenings: tuple[Happens, ...]
    facts: tuple[str, ...]


def draw_plan(plan: FloorPlan, *, title: str, subtitle: str) -> str:
    """The plan as the text of an SVG file."""
    scene = plan.scene
    x0, x1, y0, y1 = extent(scene, (happens.near for happens in plan.happenings if happens.near))
    scale = min(SCALE, LARGEST_PX / (x1 - x0), LARGEST_PX / (y1 - y0))
    frame = Frame(x0, x1, y0, y1, MARGIN, TOP, scale)
    every_m = next(step for step in STEPS_M if step * scale >= 36.0 or step == STEPS_M[-1])
    lines = [*(f"{place} {happens.words}" for place, happens in enumerate(plan.happenings, 1)), *plan.facts]
    foot = TOP + frame.height + 66
    route, low = MARGIN + 480, foot + LINE * len(lines) + 8
    texts = max(12.0 * len(title), 7.8 * len(subtitle), 7.2 * max(map(len, lines), default=0))
    wide = max(frame.left + frame.width + 24, MARGIN + texts, MARGIN + 600)
    parts = [
        text(MARGIN, 34, title, size=20, weight="bold"),
        text(MARGIN, 57, subtitle, colour=FAINT, size=14),
        *ground(frame, scene, every_m),
        *_route(frame, [scene.home, *(at for _, at in plan.places)]),
        *axes(frame, every_m),
        *(part for place, happens in enumerate(plan.happenings, 1) for part in _happens(frame, place, happens)),
        *_names(frame, plan),
        *_scale_bar(frame, every_m),
        *(text(MARGIN, foot + LINE * place, line) for place, line in enumerate(lines)),
        *signs(MARGIN, low),
        _leg(route, low, route + 34, low),
        _arrow(route + 22, low, 1.0, 0.0),
        text(route + 42, low + 4.5, "route", size=12),
    ]
    return svg(wide, low + 32, title, parts, font_size=13)


def _route(frame: Frame, points: Sequence[Point]) -> Iterator[str]:
    """A dashed line with an arrow for each leg, a little to its right."""
    for (ax, ay), (bx, by) in zip(map(frame.pixel, points), map(frame.pixel, points[1:]), strict=False):
        long = hypot(bx - ax, by - ay)
        if long < 1.0:
            continue
        ux, uy = (bx - ax) / long, (by - ay) / long
        right_x, right_y = -uy * BESIDE_PX, ux * BESIDE_PX
        yield _leg(ax + right_x, ay + right_y, bx + right_x, by + right_y)
        yield _arrow(0.5 * (ax + bx) + right_x, 0.5 * (ay + by) + right_y, ux, uy)


def _leg(ax: float, ay: float, bx: float, by: float) -> str:
    way = f"M{ax:.1f},{ay:.1f}L{bx:.1f},{by:.1f}"
    return f'<path d="{way}" {LINE_STYLE} stroke="{INK}" stroke-width="1.8" stroke-dasharray="7 5"/>'


def _arrow(x: float, y: float, ux: float, uy: float) -> str:
    a = f"{x - ARROW_PX * (ux + 0.6 * uy):.1f},{y - ARROW_PX * (uy - 0.6 * ux):.1f}"
    b = f"{x - ARROW_PX * (ux - 0.6 * uy):.1f},{y - ARROW_PX * (uy + 0.6 * ux):.1f}"
    return f'<path d="M{a}L{x:.1f},{y:.1f}L{b}Z" fill="{INK}"/>'


def _happens(frame: Frame, number: int, happens: Happens) -> list[str]:
    """Where a happening starts: a circle, and its number in the list below."""
    if happens.near is None:
        return []
    x, y = frame.pixel(happens.near)
    look = f'fill="none" stroke="{HAPPENS}" stroke-width="1.4" stroke-dasharray="2 4"'
    return [
        f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{max(happens.within_m * frame.scale, 4.0):.1f}" {look}/>',
        text(x, y + 4, str(number), anchor="middle", weight="bold", colour=HAPPENS),
    ]


def _names(frame: Frame, plan: FloorPlan) -> Iterator[str]:
    """The names of bodies and waypoints, each where no other stands."""
    wanted = [
        (body.name, (max(x for x, _ in body.outline), sum(y for _, y in body.outline) / len(body.outline)))
        for body in plan.scene.bodies
    ]
    visits: dict[Point, list[str]] = {}
    for place, (name, at) in enumerate(plan.places, 1):
        visits.setdefault(at, [name]).append(str(place))
    wanted += [(f"{name} ({', '.join(places)})", at) for at, (name, *places) in visits.items()]
    taken = [(x - 12.0, y + 5.0, 24.0) for x, y in map(frame.pixel, (plan.scene.home, *visits))]
    for name, at in wanted:
        x, y = frame.pixel(at)
        wide = LETTER * len(name)
        spots = [(x + dx, y + dy) for dy in (4.0, -14.0, 22.0, -30.0, 38.0) for dx in (14.0, -14.0 - wide)]
        inside = [(u, v) for u, v in spots if frame.left < u and u + wide < frame.left + frame.width]
        free = (spot for spot in inside if not any(_meet((*spot, wide), other) for other in taken))
        u, v = next(free, (inside or spots)[0])
        taken.append((u, v, wide))
        yield _outlined(text(u, v, name, size=12))


def _meet(one: tuple[float, float, float], other: tuple[float, float, float]) -> bool:
    """Whether two lines of text (left, foot, width) overlap."""
    apart = one[0] > other[0] + other[2] or other[0] > one[0] + one[2]
    return not apart and abs(one[1] - other[1]) < 14.0


def _scale_bar(frame: Frame, every_m: int) -> list[str]:
    right, y = frame.left + frame.width - 12, frame.top + frame.height - 14
    left = right - every_m * frame.scale
    bar = f"M{left:.1f},{y - 4:.1f}v4H{right:.1f}v-4"
    return [
        f'<path d="{bar}" fill="none" stroke="#ffffff" stroke-width="5"/>',
        f'<path d="{bar}" fill="none" stroke="{INK}" stroke-width="2"/>',
        _outlined(text((left + right) / 2, y - 6, f"{every_m} m", anchor="middle", size=12)),
    ]


def _outlined(words: str) -> str:
    """A text that can be read on any ground."""
    return f'<g stroke="#ffffff" stroke-width="3" paint-order="stroke">{words}</g>'
