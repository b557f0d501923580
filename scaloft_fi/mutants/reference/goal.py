"""Operators on the mission's test whether a waypoint is reached (message `GoalCheck`)."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from scaloft_fi.mutants.operator import (
    TOLERANCE_S,
    Axis,
    Example,
    Period,
    Place,
    Seconds,
    Tap,
    TapContext,
    operator,
    the,
)
from scaloft_fi.mutants.sample import AtEach, altered, on_each
from scaloft_fi.stack.reference.messages import GoalCheck

_FAR = GoalCheck(0, (0.0, 2.0, 0.0), (1.0, 1.0, 0.0), 0.15, 0.5)
_THERE = GoalCheck(0, (0.0, 0.1, 0.0), (1.0, 1.0, 0.0), 0.15, 0.5)


def _decided(check: GoalCheck, *, verdict: bool) -> GoalCheck:
    return check._replace(verdict=verdict)


@operator(
    "never_reached",
    need=the(GoalCheck),
    example=Example(
        GoalCheck, {}, (_FAR, None, _THERE), (_decided(_FAR, verdict=False), None, _decided(_THERE, verdict=False))
    ),
)
def never_reached(_context: TapContext) -> Tap:
    """Never declare a waypoint reached: the check is not called, or its threshold is 0."""
    return on_each(lambda check: _decided(check, verdict=False))


@operator(
    "invert_reached",
    need=the(GoalCheck),
    example=Example(
        GoalCheck, {}, (_FAR, None, _THERE), (_decided(_FAR, verdict=True), None, _decided(_THERE, verdict=False))
    ),
)
def invert_reached(_context: TapContext) -> Tap:
    """Declare a waypoint reached exactly while it is not: an inverted comparison."""
    return on_each(lambda check: _decided(check, verdict=not check.reached))


@operator(
    "ignore_axis",
    need=the(GoalCheck),
    example=Example(GoalCheck, {"axis": "y"}, (_FAR, None), (_FAR._replace(axes=(1.0, 0.0, 0.0)), None)),
)
def ignore_axis(_context: TapContext, *, axis: Axis) -> Tap:
    """Leave one axis (x, y, z of the world) out of the distance to the waypoint."""
    return on_each(lambda check: altered(check, "axes", lambda _counts: 0.0, axis))


@dataclass
class _Dwell:
    dwell_s: float
    reached_s: dict[int, float] = field(default_factory=dict)

    def __call__(self, t_s: float, sample: Any | None) -> Any | None:
        if sample is None:
            return None
        if sample.reached:
            self.reached_s.setdefault(sample.leg, t_s)
        since_s = self.reached_s.get(sample.leg)
        return sample if since_s is None else _decided(sample, verdict=t_s - since_s >= self.dwell_s - TOLERANCE_S)


@operator(
    "dwell",
    need=the(GoalCheck),
    example=Example(
        GoalCheck,
        {"dwell_s": 0.1},
        (_FAR, _THERE, _FAR, _FAR),
        (_FAR, _decided(_THERE, verdict=False), _decided(_FAR, verdict=False), _decided(_FAR, verdict=True)),
    ),
)
def dwell(_context: TapContext, *, dwell_s: Seconds) -> Tap:
    """Declare each waypoint reached `dwell_s` [s] after it was.

    A verdict that waits in a queue or for a confirmation.
    """
    return _Dwell(dwell_s)


@operator(
    "skip",
    need=the(GoalCheck),
    example=Example(
        GoalCheck, {"index": 0}, (_FAR, _FAR._replace(leg=1)), (_decided(_FAR, verdict=True), _FAR._replace(leg=1))
    ),
)
def skip(_context: TapContext, *, index: Place) -> Tap:
    """Declare the waypoint at place `index` of the route (from 0) reached as soon as it is flown to.

    An event out of sequence.
    """
    return on_each(lambda check: _decided(check, verdict=True) if check.leg == index else check)


@operator(
    "early_reached",
    need=the(GoalCheck),
    example=Example(GoalCheck, {"lead_s": 4.0}, (_FAR, None), (_FAR._replace(radius_m=2.15), None)),
)
def early_reached(_context: TapContext, *, lead_s: Seconds) -> Tap:
    """Declare each waypoint reached `lead_s` [s] before it will be at the present closing speed.

    A look-ahead that is too long.
    """
    return on_each(lambda check: check._replace(radius_m=check.radius_m + max(0.0, check.speed_mps) * lead_s))


@operator(
    "spurious_reached",
    need=the(GoalCheck),
    example=Example(
        GoalCheck,
        {"period_s": 0.1},
        (_FAR, _FAR, _FAR, _FAR, None),
        (_FAR, _FAR, _decided(_FAR, verdict=True), _FAR, None),
    ),
)
def spurious_reached(context: TapContext, *, period_s: Period = 20.0, phase_s: Seconds = 0.0) -> Tap:
    """Declare the present waypoint reached, wherever the vehicle is, once each `period_s` [s]: a stray event."""
    windows = context.windows(period_s, phase_s, period_s)
    return AtEach(windows, lambda check: _decided(check, verdict=True))
