"""From a world and a flight log to what the map draws."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.judge.requirement import Compliance, Kind
from scaloft_fi.views.pictures.map import BodyOutline, MapScene, Mark, Segment, Track
from scaloft_fi.views.pictures.picture import Point

if TYPE_CHECKING:
    from scaloft_fi.sim.log import FlightLog
    from scaloft_fi.sim.mesh import Mesh
    from scaloft_fi.sim.world import World

VIOLATED = "#c1121f"
COLOURS = {"infection": "#b5179e", "contact": VIOLATED, "error": "#57534e"}
"""Of the marks of every flight by kind of event; those of beliefs bring their own."""
SAME_M = 1e-6
"""Corners of wall segments closer than this are one [m]."""


def scene_of(world: World) -> MapScene:
    """What stands in a world, cut at the height of flight."""
    from scaloft_fi.sim.mesh import section

    walls = tuple(section(world.mine.wall.triangles, world.mission.altitude_m))
    bodies = tuple(
        BodyOutline(body.role, hull(_level(body.mesh)), world.path_of(body), body.name) for body in world.present
    )
    waypoints = tuple((x, y) for x, y, _ in world.route)
    return MapScene(rings(walls), walls, bodies, waypoints, world.mission.home)


def _level(mesh: Mesh) -> list[Point]:
    return [(float(x), float(y)) for x, y in mesh.vertices[:, :2]]


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
        marks.append(
            Mark(violation.t_s, (violation.x, violation.y), f"{violation.requirement} violated{struck}", VIOLATED)
        )
    return Track(
        title=title,
        note=note(log, outcome),
        points=points,
        speeds_mps=tuple(log.signals["speed_mps"].tolist()),
        marks=tuple(sorted(marks, key=lambda mark: mark.t_s)),
    )


def note(log: FlightLog, outcome: Outcome) -> str:
    """How the flight ended and what it violates, in a line."""
    parts = []
    for compliance in (Compliance.VIOLATED, Compliance.HELD, Compliance.OPEN):
        readings = [r for r in outcome.readings if r.compliance is compliance and r.kind is not Kind.REPORTED]
        if readings:
            parts.append(f"{', '.join(reading.requirement for reading in readings)} {compliance.value}")
    return "; ".join([f"{log.ending.sentence} after {log.duration_s:.1f} s", *parts])


def rings(segments: Iterable[Segment]) -> tuple[tuple[Point, ...], ...]:
    """The closed outlines that segments make end to end; what does not close is left out.

    >>> rings([((0, 0), (1, 0)), ((1, 0), (0, 1)), ((0, 1), (0, 0)), ((5, 5), (6, 6))])
    (((0, 0), (1, 0), (0, 1)),)
    """
    ends: dict[tuple[int, int], list[Point]] = {}
    for a, b in segments:
        ends.setdefault(_cell(a), []).append(b)
        ends.setdefault(_cell(b), []).append(a)
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


def hull(points: Sequence[Point]) -> tuple[Point, ...]:
    """The convex hull of points in the plane, counter-clockwise (Andrew's monotone chain).

    >>> hull([(0, 0), (2, 0), (1, 1), (2, 2), (0, 2), (1, 0)])
    ((0, 0), (2, 0), (2, 2), (0, 2))
    """
    ordered = sorted(set(points))
    if len(ordered) < 3:
        return tuple(ordered)

    def half(along: Iterable[Point]) -> list[Point]:
        chain: list[Point] = []
        for point in along:
            while len(chain) > 1 and _turn(chain[-2], chain[-1], point) <= 0:
                chain.pop()
            chain.append(point)
        return chain

    return tuple(half(ordered)[:-1] + half(reversed(ordered))[:-1])


def _turn(a: Point, b: Point, c: Point) -> float:
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
