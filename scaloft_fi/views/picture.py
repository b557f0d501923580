"""The top-down map of flights, drawn as SVG by hand: mine, bodies, waypoints, paths, events, legend."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import chain, groupby, pairwise
from math import ceil, dist, floor, hypot
from pathlib import Path

from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.judge.requirement import Compliance, Kind
from scaloft_fi.sim.log import FlightLog
from scaloft_fi.sim.mesh import hull, section
from scaloft_fi.sim.world import ROLES, World
from scaloft_fi.views.table import xml

Point = tuple[float, float]

FONTS = Path(__file__).parent / "fonts"
FAMILY = "Scaloft Map"


@dataclass(frozen=True)
class Frame:
    """From world metres to picture pixels.

    Attributes:
        x0, x1, y0, y1: the part of the world that is shown [m].
        left, top: where its upper left corner is in the picture [px].
        scale: pixels a metre.
    """

    x0: float
    x1: float
    y0: float
    y1: float
    left: float
    top: float
    scale: float

    @property
    def width(self) -> float:
        """Of the picture [px]."""
        return (self.x1 - self.x0) * self.scale

    @property
    def height(self) -> float:
        """Of the picture [px]."""
        return (self.y1 - self.y0) * self.scale

    def pixel(self, point: Point) -> Point:
        """Where `point` [m, world] is in the picture [px]."""
        return self.left + (point[0] - self.x0) * self.scale, self.top + (self.y1 - point[1]) * self.scale

    def at(self, point: Point) -> str:
        """The same as the text `x,y`."""
        x, y = self.pixel(point)
        return f"{x:.1f},{y:.1f}"

    def all(self, points: Iterable[Point]) -> str:
        """Several points as the text of a `points` attribute."""
        return " ".join(self.at(point) for point in points)


def text(
    x: float,
    y: float,
    words: str,
    *,
    anchor: str = "",
    colour: str = "",
    size: int = 0,
    weight: str = "",
    turn: float = 0.0,
) -> str:
    """An SVG text element at (x, y) [px], escaped."""
    looks = (("text-anchor", anchor), ("fill", colour), ("font-size", size), ("font-weight", weight))
    style = "".join(f' {key}="{value}"' for key, value in looks if value)
    turned = f' transform="rotate({turn:g} {x:.1f} {y:.1f})"' if turn else ""
    return f'<text x="{x:.1f}" y="{y:.1f}"{style}{turned}>{xml(words)}</text>'


def png(svg: str, zoom: float = 2.0) -> bytes:
    """The picture of an SVG text, with no font but our own, so that every machine draws the same."""
    import resvg_py

    return bytes(
        resvg_py.svg_to_bytes(
            svg_string=svg,
            zoom=zoom,
            skip_system_fonts=True,
            font_files=[str(FONTS / "map-regular.ttf"), str(FONTS / "map-bold.ttf")],
            font_family=FAMILY,
            sans_serif_family=FAMILY,
        )
    )


FONT = f"{FAMILY}, Helvetica, Arial, sans-serif"
RAMP = ("#440154", "#472d7b", "#3b528b", "#2c728e", "#21918c", "#28ae80", "#5ec962", "#a0da39")
"""Viridis without its palest end: even in lightness, safe for colour-blind readers."""
SHADE_MPS = 0.1
"""One colour is a tenth of a metre per second, centred, so that a steady speed keeps one colour."""
INK, FAINT, ROCK, FLOOR = "#22262b", "#6b727b", "#d5d1c9", "#fbfaf7"
THIN = f'stroke="{INK}" stroke-width="1.3"'
HOLES = 'fill-rule="evenodd"'
LINE_STYLE = 'fill="none" stroke-linejoin="round" stroke-linecap="round"'


def body_style(role: str) -> str:
    """How a body of that role is drawn."""
    look = ROLES[role]
    return f'fill="{look.fill}" stroke="{look.stroke}" stroke-width="{look.stroke_px:g}"'


def svg(wide: float, high: float, title: str, parts: Iterable[str], *, font_size: int) -> str:
    """The text of an SVG file `wide` x `high` [px], white behind its parts."""
    box = f'width="{wide:.0f}" height="{high:.0f}" viewBox="0 0 {wide:.0f} {high:.0f}"'
    look = f'font-family="{FONT}" font-size="{font_size}" fill="{INK}"'
    head = f'<svg xmlns="http://www.w3.org/2000/svg" {box} {look} role="img"><title>{xml(title)}</title>'
    return "\n".join([head, '<rect width="100%" height="100%" fill="#ffffff"/>', *parts, "</svg>", ""])


def waypoint(x: float, y: float, radius: float = 9.0) -> str:
    """A dashed ring with a cross."""
    ring = f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{radius:g}" fill="none" {THIN} stroke-dasharray="3 2.4"/>'
    return ring + f'<path d="M{x - 4:.1f},{y:.1f}h8M{x:.1f},{y - 4:.1f}v8" {THIN}/>'


def shade(speed_mps: float) -> int:
    """Which colour of `RAMP` a speed has [m/s]."""
    return min(len(RAMP) - 1, round(speed_mps / SHADE_MPS))


def legend(left: float, top: float) -> list[str]:
    """What colours and signs mean, its upper left corner at (left, top) [px]."""
    step = 240.0 / len(RAMP)
    parts = [text(left, top, "speed [m/s]", colour=FAINT, size=12)]
    for i, colour in enumerate(RAMP):
        x, label = left + i * step, f"{SHADE_MPS * i:.1f}" + "+" * (i == len(RAMP) - 1)
        parts += [f'<rect x="{x:.1f}" y="{top + 9:.1f}" width="{step + 0.5:.1f}" height="10" fill="{colour}"/>']
        parts += [text(x + step / 2, top + 34, label, anchor="middle", colour=FAINT, size=12)]
    return parts + signs(left + 290, top + 15)


def signs(x: float, y: float) -> list[str]:
    """What the signs of bodies and places mean, on a line from (x, y) [px]."""
    parts: list[str] = []
    for name, size in (("obstacle", 12), ("person", 12), ("structure", 5)):
        box = f'x="{x:.1f}" y="{y - size / 2:.1f}" width="{size}" height="{size}"'
        parts += [f"<rect {box} {body_style(name)}/>", text(x + 20, y + 4.5, name, size=12)]
        x += 48 + 7 * len(name)
    parts += [
        waypoint(x + 6, y, 7.0),
        text(x + 20, y + 4.5, "waypoint", size=12),
        text(x + 92, y + 4.5, "H", size=12, weight="bold"),
        text(x + 106, y + 4.5, "home", size=12),
    ]
    return parts


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
    parts = [text(MARGIN, 34, title, size=20, weight="bold"), text(MARGIN, 57, subtitle, colour=FAINT, size=14)]
    for number, (frame, track) in enumerate(zip(frames, tracks, strict=True)):
        parts += _panel(frame, scene, track, number)
        parts += _list(frame, track, list_top)
    parts += legend(MARGIN, legend_top)
    return svg(wide, high, title, parts, font_size=13)


def extent(scene: MapScene, more: Iterable[Point] = ()) -> tuple[float, float, float, float]:
    """The box x0, x1, y0, y1 around the scene and `more` points [m], rounded outwards to half metres."""
    drawn = ((*body.outline, *body.path) for body in scene.bodies)
    points = [scene.home, *scene.waypoints, *more, *chain(*scene.floor, *drawn, *scene.walls)]
    sides = ([point[axis] for point in points] for axis in (0, 1))
    (x0, x1), (y0, y1) = ((floor(2 * (min(ends) - 0.2)) / 2, ceil(2 * (max(ends) + 0.2)) / 2) for ends in sides)
    return x0, x1, y0, y1


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
    lines: list[Segment] = [((x, frame.y0), (x, frame.y1)) for x in _metres(frame.x0, frame.x1, every_m)]
    lines += [((frame.x0, y), (frame.x1, y)) for y in _metres(frame.y0, frame.y1, every_m)]
    return [
        f'<rect {_box(frame)} fill="{ROCK if scene.floor else FLOOR}"/>',
        f'<path d="{"".join(f"M{frame.all(outline)}Z" for outline in scene.floor)}" fill="{FLOOR}" {HOLES}/>',
        f'<path d="{_strokes(frame, lines)}" stroke="{INK}" stroke-opacity="0.08" fill="none"/>',
        f'<path d="{_strokes(frame, scene.walls)}" {LINE_STYLE} stroke="{INK}" stroke-width="1.6"/>',
        *_places(frame, scene),
        *(_body(frame, body) for body in scene.bodies),
    ]


def _box(frame: Frame) -> str:
    return f'x="{frame.left:.1f}" y="{frame.top:.1f}" width="{frame.width:.1f}" height="{frame.height:.1f}"'


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
    visited = dict.fromkeys(point for point in scene.waypoints if dist(point, scene.home) > 0.3)
    return [*parts, *(waypoint(*frame.pixel(point)) for point in visited)]


def _body(frame: Frame, body: BodyOutline) -> str:
    style = body_style(body.kind)
    outline = f'<polygon points="{frame.all(body.outline)}" {style}><title>{xml(body.kind)}</title></polygon>'
    if not body.path:
        return outline
    x, y = frame.pixel(body.path[-1])
    dashes = f'{LINE_STYLE} stroke="{INK}" stroke-width="1.6" stroke-dasharray="2 5"'
    return f'<polyline points="{frame.all(body.path)}" {dashes}/><circle cx="{x:.1f}" cy="{y:.1f}" r="3"/>{outline}'


def _path(frame: Frame, track: Track) -> list[str]:
    """A pale casing, then runs of one colour each, then a chevron every few metres to show the direction."""
    if len(track.points) < 2:
        return []
    parts = [f'<polyline points="{frame.all(track.points)}" {LINE_STYLE} stroke="#ffffff" stroke-width="6"/>']
    for tint, places in groupby(range(len(track.points)), lambda at: shade(track.speeds_mps[at])):
        first, *rest = places
        run = track.points[first : first + len(rest) + 2]
        parts += [f'<polyline points="{frame.all(run)}" {LINE_STYLE} stroke="{RAMP[tint]}" stroke-width="3.2"/>']
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
        inside = [spot for spot in spots if frame.left + 9 < spot[0] < frame.left + frame.width - 9]
        u, v = next((spot for spot in inside if all(dist(spot, other) > 20 for other in taken)), spots[0])
        taken.append((u, v))
        parts += [
            f'<path d="M{x:.1f},{y:.1f}L{u:.1f},{v:.1f}" stroke="{mark.colour}" stroke-width="1.2"/>',
            f'<circle cx="{x:.1f}" cy="{y:.1f}" r="3" fill="{mark.colour}" stroke="#ffffff"/>',
            *_disc(u, v, number, mark.colour),
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
        parts += [
            *_disc(frame.left + 9, y, number, mark.colour),
            text(frame.left + 80, y + 4.5, f"{mark.t_s:.2f} s", anchor="end", colour=FAINT),
            text(frame.left + 90, y + 4.5, mark.text),
        ]
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


VIOLATED = "#c1121f"
COLOURS = {"infection": "#b5179e", "contact": VIOLATED, "error": "#57534e"}
"""Of the marks of every flight by kind of event; those of beliefs bring their own."""
SAME_M = 1e-6
"""Corners of wall segments closer than this are one [m]."""


def scene_of(world: World) -> MapScene:
    """What stands in a world, cut at the height of flight."""
    walls = tuple(section(world.mine.wall.triangles, world.mission.altitude_m))
    corners = ([(float(x), float(y)) for x, y in body.mesh.vertices[:, :2]] for body in world.present)
    bodies = tuple(
        BodyOutline(body.role, hull(points), world.path_of(body), body.name)
        for body, points in zip(world.present, corners, strict=True)
    )
    waypoints = tuple((x, y) for x, y, _ in world.route)
    return MapScene(rings(walls), walls, bodies, waypoints, world.mission.home)


def track_of(log: FlightLog, outcome: Outcome, title: str) -> Track:
    """One flight's panel."""
    xs, ys = log.signals["x_m"].tolist(), log.signals["y_m"].tolist()
    points = tuple(zip(xs, ys, strict=True))
    counted = [violation for violation in outcome.violations if violation.kind is not Kind.REPORTED]
    struck_at_s = {round(v.t_s, 3) for v in counted if v.struck}
    marks = [
        Mark(event.t_s, points[log.at(event.t_s)], event.text, colour)
        for event in log.events
        if (colour := event.colour or COLOURS.get(event.kind)) and not (event.kind == "contact" and struck_at_s)
    ]
    for violation in counted:
        struck = f", strikes {violation.struck}" if violation.struck else ""
        words = f"{violation.requirement} violated{struck}"
        marks.append(Mark(violation.t_s, (violation.x, violation.y), words, VIOLATED))
    return Track(
        title=title,
        note=note(log, outcome),
        points=points,
        speeds_mps=tuple(log.signals["speed_mps"].tolist()),
        marks=tuple(sorted(marks, key=lambda mark: mark.t_s)),
    )


def note(log: FlightLog, outcome: Outcome) -> str:
    """How the flight ended and what it violates, in a line."""
    parts = [f"{log.ending.sentence} after {log.duration_s:.1f} s"]
    for compliance in (Compliance.VIOLATED, Compliance.HELD, Compliance.OPEN):
        told = [r.requirement for r in outcome.readings if r.compliance is compliance and r.kind is not Kind.REPORTED]
        parts += [f"{', '.join(told)} {compliance.value}"] if told else []
    return "; ".join(parts)


def rings(segments: Iterable[Segment]) -> tuple[tuple[Point, ...], ...]:
    """The closed outlines that segments make end to end; what does not close is left out.

    >>> rings([((0, 0), (1, 0)), ((1, 0), (0, 1)), ((0, 1), (0, 0)), ((5, 5), (6, 6))])
    (((0, 0), (1, 0), (0, 1)),)
    """
    ends = defaultdict[tuple[int, int], list[Point]](list)
    for a, b in segments:
        ends[_cell(a)].append(b)
        ends[_cell(b)].append(a)
    rings: list[tuple[Point, ...]] = []
    seen: set[tuple[int, int]] = set()
    for a, _ in segments:
        ring: list[Point] = []
        here: Point | None = a
        while here is not None and _cell(here) not in seen:
            seen.add(_cell(here))
            ring.append(here)
            here = next((other for other in ends[_cell(here)] if _cell(other) not in seen), None)
        if len(ring) > 2 and _cell(ring[0]) in map(_cell, ends[_cell(ring[-1])]):
            rings.append(tuple(ring))
    return tuple(rings)


def _cell(point: Point) -> tuple[int, int]:
    return round(point[0] / SAME_M), round(point[1] / SAME_M)


LARGEST_PX = 1100.0
"""Greatest width and height of the mine in the picture; a larger mine is drawn smaller [px]."""
PLAN_TOP, LETTER, ARROW_PX = 84.0, 6.9, 7.0
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
    frame = Frame(x0, x1, y0, y1, MARGIN, PLAN_TOP, scale)
    every_m = next(step for step in STEPS_M if step * scale >= 36.0 or step == STEPS_M[-1])
    lines = [*(f"{place} {happens.words}" for place, happens in enumerate(plan.happenings, 1)), *plan.facts]
    foot = PLAN_TOP + frame.height + 66
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
    for (ax, ay), (bx, by) in pairwise(map(frame.pixel, points)):
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
