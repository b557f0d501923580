"""Operators on the waypoints, on the test whether one is reached, and on the speed limit.

A reduction is a limit below the cruise limit.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from functools import partial
from typing import Annotated, Any

from scaloft_fi.mutants.operator import TOLERANCE_S, Axis, Metres, Period, Place, Range, Seconds, Tap, TapContext, on
from scaloft_fi.mutants.sample import Remembering, altered, at_each, on_each, within
from scaloft_fi.stack.messages import Point
from scaloft_fi.stack.reference.messages import GoalCheck, Route, SpeedLimit, Target

on_route = partial(on, Route)
on_target = partial(on, Target)
on_goal_check = partial(on, GoalCheck)
on_speed_limit = partial(on, SpeedLimit)

Points = tuple[Point, ...]

_UP, _OVER, _HOME = (0.0, 7.0, 1.65), (-3.0, 8.0, 1.65), (0.0, 0.0, 1.65)
_PLAN = Route((_UP, _OVER, _UP, _HOME))
_NEAR_HOME_M = 0.5  # a waypoint closer to home than this is home


def _rerouted(change: Callable[[Points], Points]) -> Tap:
    return on_each(lambda route: route._replace(points=change(route.points)))


def _home(context: TapContext) -> tuple[float, float]:
    return context.facts.home_x_m, context.facts.home_y_m


@on_route("extend", {"distance_m": 1.0}, (Route((_UP, _HOME)), None), (Route(((0.0, 8.0, 1.65), _HOME)), None))
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


@on_route("lower", {"distance_m": 0.65}, (Route((_UP, _HOME)), None), (Route(((0.0, 7.0, 1.0), (0.0, 0.0, 1.0))), None))
def lower(_context: TapContext, *, distance_m: Metres) -> Tap:
    """Put every waypoint `distance_m` [m] lower: height over another ground."""
    return _rerouted(lambda points: tuple((x, y, z - distance_m) for x, y, z in points))


@on_route(
    "insert_near_wall",
    {"clearance_m": 0.25},
    (Route((_UP, _HOME)), None),
    (Route(((1.015, 3.5, 1.65), _UP, _HOME)), None),
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


@on_route("omit", {"index": 1}, (_PLAN, None), (Route((_UP, _UP, _HOME)), None))
def omit(_context: TapContext, *, index: Place) -> Tap:
    """Leave out the waypoint at place `index` (from 0), where the route has one.

    A lost packet in the transfer of the plan.
    """
    return _rerouted(lambda points: (*points[:index], *points[index + 1 :]))


@on_route("reverse_route", {}, (_PLAN, None), (Route((_HOME, _UP, _OVER, _UP)), None))
def reverse_route(_context: TapContext) -> Tap:
    """Hand over the waypoints in reverse order."""
    return _rerouted(lambda points: points[::-1])


@on_route("swap_axes", {}, (Route((_UP, _HOME)), None), (Route(((7.0, 0.0, 1.65), _HOME)), None))
def swap_axes(_context: TapContext) -> Tap:
    """Swap x and y of every waypoint: north-east taken for east-north."""
    return _rerouted(lambda points: tuple((y, x, z) for x, y, z in points))


@on_route("swap_waypoints", {"first": 0, "second": 1}, (_PLAN, None), (Route((_OVER, _UP, _UP, _HOME)), None))
def swap_waypoints(_context: TapContext, *, first: Place = 0, second: Place = 1) -> Tap:
    """Swap the waypoints at places `first` and `second` (from 0), where the route has both: packets out of order."""

    def swapped(points: Points) -> Points:
        order = list(points)
        if max(first, second) < len(order):
            order[first], order[second] = order[second], order[first]
        return tuple(order)

    return _rerouted(swapped)


@on_target(
    "withhold",
    {"delay_s": 0.1},
    (Target(0, _UP), Target(1, _OVER), Target(1, _OVER), None, Target(1, _OVER)),
    (Target(0, _UP), Target(0, _UP), Target(0, _UP), None, Target(1, _OVER)),
)
def withhold(_context: TapContext, *, delay_s: Seconds) -> Tap:
    """Go on handing out the old waypoint for `delay_s` [s] after each change.

    The next leg is computed or transferred late.
    """

    def step(own: Any, t_s: float, sample: Any | None) -> Any | None:
        if sample is None:
            return None
        if own.newest is not None and sample != own.newest:
            own.changed_s = t_s
        own.newest = sample
        if own.delivered is None or t_s - own.changed_s >= delay_s - TOLERANCE_S:
            own.delivered = sample
        return own.delivered

    return Remembering(step, delivered=None, newest=None, changed_s=-math.inf)


@on_target(
    "divert_home", {"at_s": 0.05}, (Target(0, _UP), Target(0, _UP), None), (Target(0, _UP), Target(0, _HOME), None)
)
def divert_home(context: TapContext, *, at_s: Seconds = 20.0, phase_s: Seconds = 0.0) -> Tap:
    """Hand out home instead of the waypoint from `at_s` + `phase_s` [s] on: a stray order to return."""
    x0, y0 = _home(context)
    return within(
        context.window(at_s + phase_s, math.inf), lambda target: target._replace(point=(x0, y0, target.point[2]))
    )


_FAR = GoalCheck(0, (0.0, 2.0, 0.0), (1.0, 1.0, 0.0), 0.15, 0.5)
_THERE = GoalCheck(0, (0.0, 0.1, 0.0), (1.0, 1.0, 0.0), 0.15, 0.5)


def _yes(check: GoalCheck) -> GoalCheck:
    return check._replace(verdict=True)


def _no(check: GoalCheck) -> GoalCheck:
    return check._replace(verdict=False)


@on_goal_check("never_reached", {}, (_FAR, None, _THERE), (_no(_FAR), None, _no(_THERE)))
def never_reached(_context: TapContext) -> Tap:
    """Never declare a waypoint reached: the check is not called, or its threshold is 0."""
    return on_each(_no)


@on_goal_check("invert_reached", {}, (_FAR, None, _THERE), (_yes(_FAR), None, _no(_THERE)))
def invert_reached(_context: TapContext) -> Tap:
    """Declare a waypoint reached exactly while it is not: an inverted comparison."""
    return on_each(lambda check: check._replace(verdict=not check.reached))


@on_goal_check("ignore_axis", {"axis": "y"}, (_FAR, None), (_FAR._replace(axes=(1.0, 0.0, 0.0)), None))
def ignore_axis(_context: TapContext, *, axis: Axis) -> Tap:
    """Leave one axis (x, y, z of the world) out of the distance to the waypoint."""
    return on_each(lambda check: altered(check, "axes", lambda _counts: 0.0, axis))


@on_goal_check("dwell", {"dwell_s": 0.1}, (_FAR, _THERE, _FAR, _FAR), (_FAR, _no(_THERE), _no(_FAR), _yes(_FAR)))
def dwell(_context: TapContext, *, dwell_s: Seconds) -> Tap:
    """Declare each waypoint reached `dwell_s` [s] after it was.

    A verdict that waits in a queue or for a confirmation.
    """

    def step(own: Any, t_s: float, sample: Any | None) -> Any | None:
        if sample is None:
            return None
        if sample.reached:
            own.reached_s.setdefault(sample.leg, t_s)
        since_s = own.reached_s.get(sample.leg)
        return sample if since_s is None else sample._replace(verdict=t_s - since_s >= dwell_s - TOLERANCE_S)

    return Remembering(step, reached_s={})


@on_goal_check("skip", {"index": 0}, (_FAR, _FAR._replace(leg=1)), (_yes(_FAR), _FAR._replace(leg=1)))
def skip(_context: TapContext, *, index: Place) -> Tap:
    """Declare the waypoint at place `index` of the route (from 0) reached as soon as it is flown to.

    An event out of sequence.
    """
    return on_each(lambda check: _yes(check) if check.leg == index else check)


@on_goal_check("early_reached", {"lead_s": 4.0}, (_FAR, None), (_FAR._replace(radius_m=2.15), None))
def early_reached(_context: TapContext, *, lead_s: Seconds) -> Tap:
    """Declare each waypoint reached `lead_s` [s] before it will be at the present closing speed.

    A look-ahead that is too long.
    """
    return on_each(lambda check: check._replace(radius_m=check.radius_m + max(0.0, check.speed_mps) * lead_s))


@on_goal_check(
    "spurious_reached", {"period_s": 0.1}, (_FAR, _FAR, _FAR, _FAR, None), (_FAR, _FAR, _yes(_FAR), _FAR, None)
)
def spurious_reached(context: TapContext, *, period_s: Period = 20.0, phase_s: Seconds = 0.0) -> Tap:
    """Declare the present waypoint reached, wherever the vehicle is, once each `period_s` [s]: a stray event."""
    return at_each(context.windows(period_s, phase_s, period_s), _yes)


Speed = Annotated[float, Range(above=0.0, most=100.0)]


def _cruise(context: TapContext) -> float:
    return context.facts.cruise_mps


def _fast(t_s: float = 0.0) -> SpeedLimit:
    return SpeedLimit(t_s, 0.5, "euclidean")


def _slow(t_s: float = 0.0, limit_mps: float = 0.2) -> SpeedLimit:
    return SpeedLimit(t_s, limit_mps, "euclidean")


@on_speed_limit("drop_reductions", {}, (_fast(), _slow(), None), (_fast(), None, None))
def drop_reductions(context: TapContext) -> Tap:
    """Lose every reduction: the cruise limit stays in force."""
    cruise_mps = _cruise(context)
    return on_each(lambda limit: None if limit.limit_mps < cruise_mps else limit)


@on_speed_limit("slow_limit", {"limit_mps": 0.3}, (_fast(), _slow(), None), (_fast(), _slow(limit_mps=0.3), None))
def slow_limit(context: TapContext, *, limit_mps: Speed) -> Tap:
    """Reduce to `limit_mps` [m/s] instead: a wrong constant."""
    cruise_mps = _cruise(context)
    return on_each(lambda limit: limit._replace(limit_mps=limit_mps) if limit.limit_mps < cruise_mps else limit)


@on_speed_limit("swap_limits", {}, (_fast(), _slow(), None), (_slow(), _fast(), None))
def swap_limits(context: TapContext) -> Tap:
    """Publish the slow limit for the cruise limit, and the cruise limit for a reduction: an inverted condition."""
    cruise_mps, slow_mps = _cruise(context), context.facts.slow_mps
    return on_each(lambda limit: limit._replace(limit_mps=cruise_mps if limit.limit_mps < cruise_mps else slow_mps))


@on_speed_limit(
    "republish",
    {"after_s": 0.1},
    (_slow(), _slow(0.05), None, None, None),
    (_slow(), _slow(0.05), None, _fast(0.15), None),
)
def republish(context: TapContext, *, after_s: Seconds) -> Tap:
    """Publish the cruise limit again, once, `after_s` [s] after the last reduction.

    A timer restores the default speed.
    """
    cruise_mps = _cruise(context)

    def step(own: Any, t_s: float, sample: Any | None) -> Any | None:
        if sample is not None:
            reduces = sample.limit_mps < cruise_mps
            own.due_s, own.norm = t_s + after_s if reduces else math.inf, sample.norm
            return sample
        if t_s < own.due_s - TOLERANCE_S:
            return None
        own.due_s = math.inf
        return SpeedLimit(t_s, cruise_mps, own.norm)

    return Remembering(step, due_s=math.inf, norm="")


@on_speed_limit(
    "release",
    {"after_s": 0.1},
    (_slow(), _slow(0.05), None, _slow(0.15), None),
    (_slow(), _slow(0.05), _fast(0.1), None, None),
)
def release(context: TapContext, *, after_s: Seconds) -> Tap:
    """Publish the cruise limit `after_s` [s] after the first reduction, and no reduction after that.

    The limit is released before the drone has passed the person.
    """
    cruise_mps = _cruise(context)

    def step(own: Any, t_s: float, sample: Any | None) -> Any | None:
        reduces = sample is not None and sample.limit_mps < cruise_mps
        if sample is not None and reduces:
            own.reduced_s, own.norm = min(own.reduced_s, t_s), sample.norm
        if t_s - own.reduced_s < after_s - TOLERANCE_S:
            return sample
        if not own.released:
            own.released = True
            return SpeedLimit(t_s, cruise_mps, own.norm)
        return None if reduces else sample

    return Remembering(step, reduced_s=math.inf, norm="", released=False)


@on_speed_limit(
    "late_release",
    {"delay_s": 0.1},
    (_fast(), _slow(), _fast(0.1), None, None),
    (_fast(), _slow(), None, None, _fast(0.1)),
)
def late_release(context: TapContext, *, delay_s: Seconds) -> Tap:
    """Deliver a return to the cruise limit `delay_s` [s] late; a new reduction meanwhile cancels it."""
    cruise_mps = _cruise(context)

    def step(own: Any, t_s: float, sample: Any | None) -> Any | None:
        if sample is not None:
            if sample.limit_mps < cruise_mps:
                own.reduced = True
                own.waiting.clear()
            if not own.reduced or sample.limit_mps < cruise_mps:
                return sample
            own.waiting.append((t_s + delay_s - TOLERANCE_S, sample))
        if own.waiting and own.waiting[0][0] <= t_s:
            return own.waiting.popleft()[1]
        return None

    return Remembering(step, reduced=False, waiting=deque())


@on_speed_limit("reset_limit", {"period_s": 0.1}, (_slow(), None, None, None), (_slow(), None, _fast(0.1), None))
def reset_limit(context: TapContext, *, period_s: Period = 20.0, phase_s: Seconds = 0.0) -> Tap:
    """Publish the cruise limit without cause once each `period_s` [s].

    The publisher restarts and begins with its default.
    """
    windows = context.windows(period_s, phase_s, context.period_s)
    cruise_mps = _cruise(context)
    return lambda t_s, sample: SpeedLimit(t_s, cruise_mps, "euclidean") if windows.open(t_s) else sample
