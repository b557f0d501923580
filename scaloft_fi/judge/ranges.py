"""What each signal of a study's flights can read, and with it what a formula can yield: always true, always false."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING

from scaloft_fi.judge.caps import SIGHT_M
from scaloft_fi.sim.measures import SIGNALS
from scaloft_fi.sim.signals import CLEARANCE_CAP_M, FAR_M, truth_signals
from scaloft_fi.stack.declaration import TICK_S

if TYPE_CHECKING:
    from scaloft_fi.sim.world import World
    from scaloft_fi.stack.declaration import Belief

Span = tuple[float, float]
"""Least and greatest number, either may be infinite."""
Ranges = Mapping[str, tuple[Span, ...]]
"""By name of a signal the spans that hold everything that it can read, in order."""

ANY: tuple[Span, ...] = ((-math.inf, math.inf),)
NEVER_BELOW_0: tuple[Span, ...] = ((0.0, math.inf),)
SHARE: tuple[Span, ...] = ((0.0, 1.0),)
_SIGNED: tuple[Span, ...] = ((-1.0, 1.0),)
CLEARANCE: tuple[Span, ...] = ((-math.inf, CLEARANCE_CAP_M),)
TRUTH: Ranges = {
    "elapsed_s": NEVER_BELOW_0,
    "remaining_s": ((-TICK_S, math.inf),),
    "qx": _SIGNED,
    "qy": _SIGNED,
    "qz": _SIGNED,
    "qw": _SIGNED,
    "yaw_rad": ((-math.pi, math.pi),),
    "speed_mps": NEVER_BELOW_0,
    "clearance_m": CLEARANCE,
    "person_range_m": ((0.0, FAR_M),),
    "person_sight_m": ((0.0, SIGHT_M), (FAR_M, FAR_M)),
    "waypoints_left": NEVER_BELOW_0,
    "home_m": NEVER_BELOW_0,
    "landed": ((0.0, 0.0), (1.0, 1.0)),
    "light": SHARE,
    "obstacle_pixels": NEVER_BELOW_0,
    "waypoint_wall_m": (*CLEARANCE, (FAR_M, FAR_M)),
    "mass_kg": NEVER_BELOW_0,
    "takeoff_charge": SHARE,
    "haze_per_m": NEVER_BELOW_0,
}
"""The signals of the package that something bounds in every study; a flight may outlast its limit by part of a tick."""
_NOBODY: tuple[Span, ...] = ((FAR_M, FAR_M),)


def ranges_of(world: World, beliefs: Iterable[Belief], names: Iterable[str]) -> Ranges:
    """What the signals of a study can read.

    Args:
        world: the study's world.
        beliefs: of the stack.
        names: names of the signals; those of which nothing is known can read any number.
    """
    known = {signal.name: CLEARANCE for signal in truth_signals(world.surfaces) if signal.name.startswith("clearance_")}
    known |= {signal.name: ((-math.inf, signal.most),) for signal in SIGNALS.values()}
    known |= TRUTH
    for belief in beliefs:
        marks = belief.mark.values if belief.mark else ()
        known[belief.name] = ((0.0, len(marks) - 1.0),) if marks else ((-math.inf, belief.most),)
    return {name: known.get(name, ANY) for name in names}


def without(world: World) -> Ranges:
    """What signals read in a study that has nobody, and no obstacle, that they could measure."""
    from scaloft_fi.sim.roles import ROLES

    roles = [ROLES[body.role] for body in world.bodies.values()]
    empty: dict[str, tuple[Span, ...]] = {}
    if not any(role.is_person for role in roles):
        empty |= {"person_range_m": _NOBODY, "person_sight_m": _NOBODY}
    if not any(role.is_obstacle for role in roles):
        empty["obstacle_pixels"] = ((0.0, 0.0),)
    return empty


def within_rock(world: World) -> Ranges:
    """Where the centre of a vehicle can be in the mine [m]."""
    corners = world.mine.wall.vertices, world.mine.ground.vertices
    low = [min(float(part[:, axis].min()) for part in corners) for axis in range(3)]
    high = [max(float(part[:, axis].max()) for part in corners) for axis in range(3)]
    return {name: ((low[axis], high[axis]),) for axis, name in enumerate(("x_m", "y_m", "z_m"))}
