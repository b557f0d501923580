"""Operators on the waypoints: their list (message `Route`) and the present one (message `Target`)."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from scaloft_fi.mutants.operator import TOLERANCE_S, Example, Metres, Place, Seconds, Tap, TapContext, operator, the
from scaloft_fi.mutants.sample import on_each, within
from scaloft_fi.stack.messages import Point
from scaloft_fi.stack.reference.messages import Route, Target

Points = tuple[Point, ...]

_UP, _OVER, _HOME = (0.0, 7.0, 1.65), (-3.0, 8.0, 1.65), (0.0, 0.0, 1.65)
_PLAN = Route((_UP, _OVER, _UP, _HOME))
_NEAR_HOME_M = 0.5  # a waypoint closer to home than this is home


def _rerouted(change: Callable[[Points], Points]) -> Tap:
    return on_each(lambda route: route._replace(points=change(route.points)))


def _home(context: TapContext) -> tuple[float, float]:
    return context.facts.home_x_m, context.facts.home_y_m


@operator(
    "extend",
    need=the(Route),
    example=Example(Route, {"distance_m": 1.0}, (Route((_UP, _HOME)), None), (Route(((0.0, 8.0, 1.65), _HOME)), None)),
)
def extend(context: TapContext, *, distance_m: Metres) -> Tap:
    """Move every waypoint but home `distance_m` [m] farther from home: a survey with a wrong datum."""
    x0, y0 = _home(context)

    def farther(point: Point) -> Point:
        away_m = math.hypot(point[0] - x0, point[1] - y0)
        if away_m < _NEAR_HOME_M:
            return point
        share = distance_m / away_m
        return point[0] + share * (point[0] - x0), point[1] + share * (point[1] - y0), point[2]

    return _rerouted(lambda points: tuple(map(farther, points)))


@operator(
    "lower",
    need=the(Route),
    example=Example(
        Route, {"distance_m": 0.65}, (Route((_UP, _HOME)), None), (Route(((0.0, 7.0, 1.0), (0.0, 0.0, 1.0))), None)
    ),
)
def lower(_context: TapContext, *, distance_m: Metres) -> Tap:
    """Put every waypoint `distance_m` [m] lower: height over another ground."""
    return _rerouted(lambda points: tuple((x, y, z - distance_m) for x, y, z in points))


@operator(
    "insert_near_wall",
    need=the(Route),
    example=Example(
        Route,
        {"clearance_m": 0.25},
        (Route((_UP, _HOME)), None),
        (Route(((1.015, 3.5, 1.65), _UP, _HOME)), None),
    ),
)
def insert_near_wall(context: TapContext, *, clearance_m: Metres) -> Tap:
    """Insert a waypoint halfway to the first one, where the hull is `clearance_m` [m] off the wall on the right.

    A leftover of an older plan, a point added by hand.
    """
    facts = context.facts
    x0, y0 = _home(context)

    def inserted(points: Points) -> Points:
        for place, point in enumerate(points):
            if facts.wall_m and math.hypot(point[0] - x0, point[1] - y0) >= _NEAR_HOME_M:
                (x, y), (nx, ny) = facts.wall_m, facts.inward
                x, y = x + nx * facts.half_width_m, y + ny * facts.half_width_m
                extra = (x + nx * clearance_m, y + ny * clearance_m, point[2])
                return (*points[:place], extra, *points[place:])
        return points

    return _rerouted(inserted)


@operator(
    "omit", need=the(Route), example=Example(Route, {"index": 1}, (_PLAN, None), (Route((_UP, _UP, _HOME)), None))
)
def omit(_context: TapContext, *, index: Place) -> Tap:
    """Leave out the waypoint at place `index` (from 0), where the route has one.

    A lost packet in the transfer of the plan.
    """
    return _rerouted(lambda points: (*points[:index], *points[index + 1 :]))


@operator(
    "reverse_route", need=the(Route), example=Example(Route, {}, (_PLAN, None), (Route((_HOME, _UP, _OVER, _UP)), None))
)
def reverse_route(_context: TapContext) -> Tap:
    """Hand over the waypoints in reverse order."""
    return _rerouted(lambda points: points[::-1])


@operator(
    "swap_axes",
    need=the(Route),
    example=Example(Route, {}, (Route((_UP, _HOME)), None), (Route(((7.0, 0.0, 1.65), _HOME)), None)),
)
def swap_axes(_context: TapContext) -> Tap:
    """Swap x and y of every waypoint: north-east taken for east-north."""
    return _rerouted(lambda points: tuple((y, x, z) for x, y, z in points))


@operator(
    "swap_waypoints",
    need=the(Route),
    example=Example(Route, {"first": 0, "second": 1}, (_PLAN, None), (Route((_OVER, _UP, _UP, _HOME)), None)),
)
def swap_waypoints(_context: TapContext, *, first: Place = 0, second: Place = 1) -> Tap:
    """Swap the waypoints at places `first` and `second` (from 0), where the route has both: packets out of order."""

    def swapped(points: Points) -> Points:
        order = list(points)
        if max(first, second) < len(order):
            order[first], order[second] = order[second], order[first]
        return tuple(order)

    return _rerouted(swapped)


@dataclass
class _Withhold:
    delay_s: float
    delivered: Any | None = None
    newest: Any | None = None
    changed_s: float = -math.inf

    def __call__(self, t_s: float, sample: Any | None) -> Any | None:
        if sample is None:
            return None
        if self.newest is not None and sample != self.newest:
            self.changed_s = t_s
        self.newest = sample
        if self.delivered is None or t_s - self.changed_s >= self.delay_s - TOLERANCE_S:
            self.delivered = sample
        return self.delivered


@operator(
    "withhold",
    need=the(Target),
    example=Example(
        Target,
        {"delay_s": 0.1},
        (Target(0, _UP), Target(1, _OVER), Target(1, _OVER), None, Target(1, _OVER)),
        (Target(0, _UP), Target(0, _UP), Target(0, _UP), None, Target(1, _OVER)),
    ),
)
def withhold(_context: TapContext, *, delay_s: Seconds) -> Tap:
    """Go on handing out the old waypoint for `delay_s` [s] after each change.

    The next leg is computed or transferred late.
    """
    return _Withhold(delay_s)


@operator(
    "divert_home",
    need=the(Target),
    example=Example(
        Target, {"at_s": 0.05}, (Target(0, _UP), Target(0, _UP), None), (Target(0, _UP), Target(0, _HOME), None)
    ),
)
def divert_home(context: TapContext, *, at_s: Seconds = 20.0, phase_s: Seconds = 0.0) -> Tap:
    """Hand out home instead of the waypoint from `at_s` + `phase_s` [s] on: a stray order to return."""
    x0, y0 = _home(context)
    return within(
        context.window(at_s + phase_s, math.inf), lambda target: target._replace(point=(x0, y0, target.point[2]))
    )
