"""Operators on the stack's collision flag and on its inputs, bumper and proximity sectors."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from scaloft_fi.mutants.operator import Degrees, Example, Hold, Period, Seconds, Share, Tap, TapContext, operator, the
from scaloft_fi.mutants.sample import on_each
from scaloft_fi.stack.messages import Bumper
from scaloft_fi.stack.reference.messages import CollisionFlag, Proximity

_FLAG = CollisionFlag(0.0, 0.2)
_SECTORS = Proximity(
    0.0, np.array([1.0, 0.2, 0.3, 2.0]), np.full(4, True), np.array([0.6, 0.2, -0.2, -0.6]), 0.4, touched=False
)


@operator(
    "gear_as_hull",
    need=the(Bumper),
    example=Example(
        Bumper,
        {},
        (Bumper(0.0, hull=False, gear=True), Bumper(0.05, hull=False, gear=False), None),
        (Bumper(0.0, hull=True, gear=True), Bumper(0.05, hull=False, gear=False), None),
    ),
)
def gear_as_hull(_context: TapContext) -> Tap:
    """Report contact of the landing gear as contact of the hull: one switch for both (seen in the published log)."""
    return on_each(lambda bumper: bumper._replace(hull=bumper.hull or bumper.gear))


@operator(
    "watch",
    need=the(Proximity),
    example=Example(
        Proximity,
        {"share": 0.5},
        (_SECTORS, None),
        (_SECTORS._replace(watched=np.array([True, True, False, False])), None),
    ),
)
def watch(_context: TapContext, *, share: Share) -> Tap:
    """Watch only the first `share` (0..1) of the sectors, from the left: one of several sensors is not read."""

    def partly(proximity: Proximity) -> Proximity:
        kept = np.arange(len(proximity.watched)) < round(share * len(proximity.watched))
        return proximity._replace(watched=proximity.watched & kept)

    return on_each(partly)


@operator(
    "invert_flag",
    need=the(CollisionFlag),
    example=Example(CollisionFlag, {}, (None, _FLAG), (CollisionFlag(0.0, 0.0), None)),
)
def invert_flag(_context: TapContext, *, bearing_deg: Degrees = 0.0) -> Tap:
    """Raise the flag at `bearing_deg` [deg, left positive] while it is not raised, and hide it while it is.

    Wrong polarity.
    """
    bearing_rad = math.radians(bearing_deg)
    return lambda t_s, sample: CollisionFlag(t_s, bearing_rad) if sample is None else None


@operator(
    "false_flag",
    need=the(CollisionFlag),
    example=Example(
        CollisionFlag,
        {"hold_s": 0.05, "period_s": 0.1, "bearing_deg": 180.0},
        (None, None, None, _FLAG),
        (None, None, CollisionFlag(0.1, math.pi), _FLAG),
    ),
)
def false_flag(
    context: TapContext,
    *,
    hold_s: Hold = 0.5,
    period_s: Period = 20.0,
    phase_s: Seconds = 0.0,
    bearing_deg: Degrees = 0.0,
) -> Tap:
    """Raise the flag at `bearing_deg` [deg, left positive] without cause for `hold_s` [s] each `period_s` [s].

    Dust, an electrical glitch.  A flag that is raised with cause passes as it is.
    """
    windows = context.windows(period_s, phase_s, max(hold_s, context.period_s))
    bearing_rad = math.radians(bearing_deg)

    def tap(t_s: float, sample: Any | None) -> Any | None:
        return CollisionFlag(t_s, bearing_rad) if sample is None and windows.open(t_s) else sample

    return tap
