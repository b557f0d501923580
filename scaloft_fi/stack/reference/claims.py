"""What the stages of the reference stack believe of the world."""

from __future__ import annotations

import numpy as np

from scaloft_fi.stack.claim import Claim, Instant
from scaloft_fi.stack.fields import Array

SIGHT_M = 4.5
"""Persons beyond this range are not acted on [m]: `speed_limit.max_range_m` of the reference study."""
HULL_M = 0.33
"""From the centre of the vehicle to a corner of its hull, level [m]."""
UNMAPPED_M = 1.0
"""Greatest error of the obstacle map [m]; the planner gives obstacles farther away than this little weight."""


def _position(now: Instant) -> float:
    return _apart(now, ("est_x_m", "est_y_m", "est_z_m"), ("x_m", "y_m", "z_m"))


def _velocity(now: Instant) -> float:
    return _apart(now, ("est_vx_mps", "est_vy_mps", "est_vz_mps"), ("vx_mps", "vy_mps", "vz_mps"))


def _apart(now: Instant, believed: tuple[str, ...], true: tuple[str, ...]) -> float:
    offsets = [now.signals[one][-1] - now.signals[other][-1] for one, other in zip(believed, true, strict=True)]
    return float(np.linalg.norm(offsets))


def _person(now: Instant) -> float:
    """The range that is reported against the true one; a speed limit that was lowered says that a person is there."""
    signals = now.signals
    true_m = min(float(signals["person_sight_m"][-1]), SIGHT_M)
    if signals["told_person"][-1] > 0.5:
        return abs(min(float(signals["told_range_m"][-1]), SIGHT_M) - true_m)
    lowered = signals["limit_mps"][-1] < signals["limit_mps"][0]
    return 0.0 if lowered else SIGHT_M - true_m


def _obstacles(now: Instant) -> float:
    """How far from the hull, where it strikes something, the nearest obstacle of the map is."""
    if now.struck in ("", "ground"):  # the map has no ground
        return 0.0
    points: Array = np.empty((0, 3)) if now.sample is None else now.sample.points
    nearest_m = min(np.linalg.norm(points - np.asarray(now.place), axis=1).tolist(), default=np.inf)
    return float(np.clip(nearest_m - HULL_M, 0.0, UNMAPPED_M))


CLAIMS = (
    Claim("position estimate", "m", 0.15, _position),  # the radius in which a waypoint counts as reached
    Claim("velocity estimate", "m/s", 0.1, _velocity),  # some three standard deviations in a clean flight
    Claim("person detection", "m", 0.5, _person, about=("person_sight_m", "person_range_m")),
    Claim("obstacle map", "m", 0.2, _obstacles, seam="map"),  # half the diagonal of a cell, and the walls' roughness
)
