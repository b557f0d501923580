"""The top-down map of flights, drawn as SVG by hand: mine, bodies, waypoints, paths in colours of speed, events."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from math import ceil, floor, hypot

from scaloft_fi.views.pictures.picture import Frame, Point, text
from scaloft_fi.views.pictures.symbols import (
    FAINT,
    FLOOR,
    HOLES,
    INK,
    LINE_STYLE,
    RAMP,
    ROCK,
    THIN,
    body_style,
    legend,
    shade,
    svg,
    waypoint,
)
from scaloft_fi.views.tables.literal import xml

Segment = tuple[Point, Point]

SCALE, MARGIN, GAP, TOP, LINE = 62.0, 54.0, 64.0, 118.0, 19.0
LONGEST_LIST = 10
SIDES = ((1.0, -0.3), (-1.0, 0.3), (0.3, 1.0), (-0.3, -1.0))


@dataclass(frozen=True)
class BodyOutline:
    """A body seen from above.

    Attributes:
        kind: its role.
        outline: its corners in order at take-off [m, world].
        path: the places of a body that moves, in order [m, world].
        name: its name in the world.
    """

    kind: str
    outline: tuple[Point, ...]
    path: tuple[Point, ...] = ()
    name: str = ""


@dataclass(frozen=True)
class MapScene:
    """What the flights share.

    Attributes:
        floor: outlines of what is open at flight height, and of pillars in it [m, world]; everything else is rock.
        walls: where the wall surface cuts flight height [m, world].
        bodies: what stands in the mine.
        waypoints: in the order of the mission [m, world].
        home: where the mission starts and ends [m, world].
    """

    floor: tuple[tuple[Point, ...], ...]
    walls: tuple[Segment, ...]
    bodies: tuple[BodyOutline, ...]
    waypoints: tuple[Point, ...]
    home: Point


@dataclass(frozen=True)
class Mark:
    """Something that happened: when [s], where [m, world], what, in which colour."""

    t_s: float
    at: Point
    text: str
    colour: str


@dataclass(frozen=True)
class Track:
    """One flight's panel.  points: (T,) positions [m, world]; speeds_mps: (T,) [m/s]."""

    title: str
    note: str
    points: Sequence[Point]
    speeds_mps: Sequence[float]
    marks: tuple[Mark, ...]


def draw(scene: MapScene, tracks: Sequence[Track], *, title: str, subtitle: str = "") -> str:
    """The map of `tracks` (baseline first) side by side at one scale, as the text of an SVG file.

    Raises:
        ValueError: there is no track.
    """
    if not tracks:
        raise ValueError("a map needs at least one track")
    x0, x1, y0, y1 = extent(scene, (point for track in tracks for point in track.points))
    width = (x1 - x0) * SCALE
    frames = [Frame(x0, x1, y0, y1, MARGIN + i * (width + GAP), TOP, SCALE) for i in range(len(tracks))]
    listed = max(min(len(track.marks), LONGEST_LIST + 1) for track in tracks)
    list_top = TOP + frames[0].height + 62
    legend_top = list_top + listed * LINE + 18
    wide, high = max(frames[-1].left + width + 24, 640.0), legend_top + 78
    parts = [
        text(MARGIN, 34, title, size=20, weight="bold"),
        text(MARGIN, 57, subtitle, colour=FAINT, size=14),
    ]
    for number, (frame, track) in enumerate(zip(frames, tracks, strict=True)):
        parts += _panel(frame, scene, track, number)
        parts += _list(frame, track, list_top)
    parts += legend(MARGIN, legend_top)
    return svg(wide, high, title, parts, font_size=13)


def extent(scene: MapScene, more: Iterable[Point] = ()) -> tuple[float, float, float, float]:
    """The box x0, x1, y0, y1 around the scene and `more` points [m], rounded outwards to half metres."""
    points = [scene.home, *scene.waypoints, *more]
    drawn = ((*body.outline, *body.path) for body in scene.bodies)
    for outline in (*scene.floor, *drawn, *scene.walls):
        points += outline
    xs, ys = [p[0] for p in points], [p[1] for p in points]
    return _low(min(xs)), _high(max(xs)), _low(min(ys)), _high(max(ys))


def _low(metres: float) -> float:
    return floor(2 * (metres - 0.2)) / 2


def _high(metres: float) -> float:
    return ceil(2 * (metres + 0.2)) / 2


def _panel(frame: Frame, scene: MapScene, track: Track, number: int) -> list[str]:
    clip = f"panel{number}"
    return [
        text(frame.left, frame.top - 29, track.title, weight="bold", size=15),
        text(frame.left, frame.top - 11, track.note, colour=FAINT),
        f'<clipPath id="{clip}"><rect {_box(frame)}/></clipPath>',
        f'<g clip-path="url(#{clip})">',
        *ground(frame, scene),
        *_path(frame, track),
        "</g>",
        *axes(frame),
        *_marks(frame, track),
    ]


def ground(frame: Frame, scene: MapScene, every_m: int = 1) -> list[str]:
    """What stands in the mine, with a grid line every so many metres."""
    return [
        f'<rect {_box(frame)} fill="{ROCK if scene.floor else FLOOR}"/>',
        f'<path d="{"".join(f"M{frame.all(outline)}Z" for outline in scene.floor)}" fill="{FLOOR}" {HOLES}/>',
        *_grid(frame, every_m),
        f'<path d="{_strokes(frame, scene.walls)}" {LINE_STYLE} stroke="{INK}" stroke-width="1.6"/>',
        *_places(frame, scene),
        *(_body(frame, body) for body in scene.bodies),
    ]


def _box(frame: Frame) -> str:
    return f'x="{frame.left:.1f}" y="{frame.top:.1f}" width="{frame.width:.1f}" height="{frame.height:.1f}"'


def _grid(frame: Frame, every_m: int) -> list[str]:
    lines: list[Segment] = [((x, frame.y0), (x, frame.y1)) for x in _metres(frame.x0, frame.x1, every_m)]
    lines += [((frame.x0, y), (frame.x1, y)) for y in _metres(frame.y0, frame.y1, every_m)]
    return [f'<path d="{_strokes(frame, lines)}" stroke="{INK}" stroke-opacity="0.08" fill="none"/>']


def axes(frame: Frame, every_m: int = 1) -> list[str]:
    """The border of a panel with a number every so many metres."""
    foot = frame.top + frame.height
    parts = [f'<rect {_box(frame)} fill="none" stroke="{FAINT}"/>']
    for x in _metres(frame.x0, frame.x1, every_m):
        px = frame.pixel((x, 0))[0]
        parts += [f'<path d="M{px:.1f},{foot:.1f}v5" stroke="{FAINT}"/>']
        parts += [text(px, foot + 19, _signed(x), anchor="middle", colour=FAINT, size=12)]
    for y in _metres(frame.y0, frame.y1, every_m):
        py = frame.pixel((0, y))[1]
        parts += [f'<path d="M{frame.left:.1f},{py:.1f}h-5" stroke="{FAINT}"/>']
        parts += [text(frame.left - 9, py + 4, _signed(y), anchor="end", colour=FAINT, size=12)]
    parts += [text(frame.left + frame.width / 2, foot + 36, "x [m]", anchor="middle", colour=FAINT, size=12)]
    px, py = frame.left - 34, frame.top + frame.height / 2
    return [*parts, text(px, py, "y [m]", anchor="middle", colour=FAINT, size=12, turn=-90)]


def _places(frame: Frame, scene: MapScene) -> list[str]:
    x, y = frame.pixel(scene.home)
    parts = [
        f'<rect x="{x - 11:.1f}" y="{y - 11:.1f}" width="22" height="22" rx="4" fill="#ffffff" {THIN}/>',
        text(x - 20, y + 5, "H", anchor="middle", weight="bold", size=14),
    ]
    for point in dict.fromkeys(p for p in scene.waypoints if hypot(p[0] - scene.home[0], p[1] - scene.home[1]) > 0.3):
        x, y = frame.pixel(point)
        parts += [waypoint(x, y)]
    return parts


def _body(frame: Frame, body: BodyOutline) -> str:
    style = body_style(body.kind)
    outline = f'<polygon points="{frame.all(body.outline)}" {style}><title>{xml(body.kind)}</title></polygon>'
    if not body.path:
        return outline
    (x, y), dashes = (
        frame.pixel(body.path[-1]),
        f'{LINE_STYLE} stroke="{INK}" stroke-width="1.6" stroke-dasharray="2 5"',
    )
    return f'<polyline points="{frame.all(body.path)}" {dashes}/><circle cx="{x:.1f}" cy="{y:.1f}" r="3"/>{outline}'


def _path(frame: Frame, track: Track) -> list[str]:
    """A pale casing, then runs of one colour each, then a chevron every few metres to show the direction."""
    if len(track.points) < 2:
        return []
    parts = [f'<polyline points="{frame.all(track.points)}" {LINE_STYLE} stroke="#ffffff" stroke-width="6"/>']
    first, tint = 0, shade(track.speeds_mps[0])
    for i in range(1, len(track.points) + 1):
        if i == len(track.points) or shade(track.speeds_mps[i]) != tint:
            run = track.points[first : min(i, len(track.points) - 1) + 1]
            parts += [f'<polyline points="{frame.all(run)}" {LINE_STYLE} stroke="{RAMP[tint]}" stroke-width="3.2"/>']
            if i < len(track.points):
                first, tint = i, shade(track.speeds_mps[i])
    return [*parts, *_chevrons(frame, track.points)]


def _chevrons(frame: Frame, points: Sequence[Point], every_m: float = 1.6) -> Iterable[str]:
    since_m, anchor = every_m / 2, points[0]
    for point in points[1:]:
        step_m = hypot(point[0] - anchor[0], point[1] - anchor[1])
        if step_m < 0.05:
            continue
        since_m += step_m
        if since_m >= every_m:
            since_m = 0.0
            ux, uy = (point[0] - anchor[0]) / step_m, (anchor[1] - point[1]) / step_m
            x, y = frame.pixel(point)
            a = f"{x - 6 * ux - 4.5 * uy:.1f},{y - 6 * uy + 4.5 * ux:.1f}"
            b = f"{x - 6 * ux + 4.5 * uy:.1f},{y - 6 * uy - 4.5 * ux:.1f}"
            yield f'<path d="M{a}L{x:.1f},{y:.1f}L{b}" {LINE_STYLE} stroke="{INK}" stroke-width="1.5"/>'
        anchor = point


def _marks(frame: Frame, track: Track) -> list[str]:
    """Numbered discs beside the path, each with a leader to its place; pushed on where another disc already is."""
    taken: list[Point] = []
    parts: list[str] = []
    for number, mark in enumerate(track.marks[:LONGEST_LIST], start=1):
        x, y = frame.pixel(mark.at)
        spots = [(x + dx * r, y + dy * r) for r in (22.0, 44.0, 66.0, 88.0) for dx, dy in SIDES]
        inside = [(u, v) for u, v in spots if frame.left + 9 < u < frame.left + frame.width - 9]
        u, v = next((s for s in inside if all(hypot(s[0] - t[0], s[1] - t[1]) > 20 for t in taken)), spots[0])
        taken.append((u, v))
        colour = mark.colour
        parts += [
            f'<path d="M{x:.1f},{y:.1f}L{u:.1f},{v:.1f}" stroke="{colour}" stroke-width="1.2"/>',
            f'<circle cx="{x:.1f}" cy="{y:.1f}" r="3" fill="{colour}" stroke="#ffffff"/>',
            *_disc(u, v, number, colour),
        ]
    return parts


def _disc(x: float, y: float, number: int, colour: str) -> list[str]:
    return [
        f'<circle cx="{x:.1f}" cy="{y:.1f}" r="9.5" fill="{colour}" stroke="#ffffff" stroke-width="1.2"/>',
        text(x, y + 4, str(number), anchor="middle", size=11, weight="bold", colour="#ffffff"),
    ]


def _list(frame: Frame, track: Track, top: float) -> list[str]:
    parts: list[str] = []
    for number, mark in enumerate(track.marks[:LONGEST_LIST], start=1):
        y = top + (number - 1) * LINE
        parts += _disc(frame.left + 9, y, number, mark.colour)
        parts += [text(frame.left + 80, y + 4.5, f"{mark.t_s:.2f} s", anchor="end", colour=FAINT)]
        parts += [text(frame.left + 90, y + 4.5, mark.text)]
    if len(track.marks) > LONGEST_LIST:
        rest = f"and {len(track.marks) - LONGEST_LIST} more"
        parts += [text(frame.left + 90, top + LONGEST_LIST * LINE + 4.5, rest, colour=FAINT)]
    return parts


def _strokes(frame: Frame, segments: Iterable[Segment]) -> str:
    return "".join(f"M{frame.at(a)}L{frame.at(b)}" for a, b in segments)


def _signed(metres: float) -> str:
    return f"{metres:g}".replace("-", "\N{MINUS SIGN}")


def _metres(low: float, high: float, every_m: int) -> range:
    return range(every_m * ceil(low / every_m), floor(high) + 1, every_m)
