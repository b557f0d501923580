"""What a log's signals can read, and a formula that uses each: what their declarations do not say."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

from scaloft_fi.judge.bounds import ANY, SIGHT_M, TRUTH
from scaloft_fi.sim.log import FAR_M


@dataclass(frozen=True)
class SignalFact:
    """What a signal can read.

    Attributes:
        example: a formula that uses it: `always( ... )` for a requirement, `eventually( ... )` for a predicate.
        unknown: what it reads where there is nothing to measure, in words; "" where there always is.
        least, most: between which numbers it is measured; None where nothing bounds it.
        elsewhere: the number that it reads there, where that is not in its range.
    """

    example: str
    unknown: str = ""
    least: float | None = None
    most: float | None = None
    elsewhere: float | None = None


_SPEED = "always(abs(NAME) <= 2)"
_QUATERNION = SignalFact("always(NAME >= 0)")

FACTS: Mapping[str, SignalFact] = {
    "elapsed_s": SignalFact("always(elapsed_s >= 30 implies waypoints_left < 3)"),
    "remaining_s": SignalFact("always(remaining_s < 0.05 implies landed >= 0.5)"),
    "x_m": SignalFact("eventually(x_m < -1)"),
    "y_m": SignalFact("eventually(y_m > 5)"),
    "z_m": SignalFact("always(z_m <= 2.5)"),
    "vx_mps": SignalFact(_SPEED),
    "vy_mps": SignalFact(_SPEED),
    "vz_mps": SignalFact("always(vz_mps >= -1)"),
    "qx": _QUATERNION,
    "qy": _QUATERNION,
    "qz": _QUATERNION,
    "qw": _QUATERNION,
    "yaw_rad": SignalFact("eventually(yaw_rad > 1.5)"),
    "speed_mps": SignalFact("always(speed_mps / 0.8 <= 1)"),
    "clearance_m": SignalFact("always(clearance_m > 0)"),
    "person_range_m": SignalFact("always(person_range_m > 0.5)", f"{FAR_M:g} without a person"),
    "person_sight_m": SignalFact(
        "always(person_sight_m / 3 <= 1 implies speed_mps / 0.25 <= 1)",
        f"{FAR_M:g} without a person in sight within {SIGHT_M:g} m",
    ),
    "waypoints_left": SignalFact("always(landed >= 0.5 implies waypoints_left < 0.5)"),
    "home_m": SignalFact("always(landed >= 0.5 implies home_m <= 1)"),
    "landed": SignalFact("always(remaining_s < 0.05 implies landed >= 0.5)"),
    "light": SignalFact("always(light <= 0.05)"),
    "obstacle_pixels": SignalFact("eventually(obstacle_pixels >= 1)", "0 without an obstacle in view"),
    "waypoint_wall_m": SignalFact(
        "eventually(waypoint_wall_m <= 0.5)",
        f"{FAR_M:g} farther than 0.5 m from every waypoint but home",
    ),
    "mass_kg": SignalFact("always(mass_kg > 1.7)"),
    "takeoff_charge": SignalFact("eventually(takeoff_charge < 0.3)"),
    "wind_x_mps": SignalFact("eventually(abs(NAME) > 1)"),
    "wind_y_mps": SignalFact("eventually(abs(NAME) > 1)"),
    "wind_z_mps": SignalFact("eventually(abs(NAME) > 1)"),
    "haze_per_m": SignalFact("eventually(haze_per_m >= 0.1)"),
    "drift_x_m": SignalFact("eventually(abs(NAME) > 0.2)"),
    "drift_y_m": SignalFact("eventually(abs(NAME) > 0.2)"),
    "drift_z_m": SignalFact("eventually(abs(NAME) > 0.2)"),
}
"""By name of the signal; `NAME` in an example stands for it."""

MEANINGS: Mapping[str, str] = {
    "person_sight_m": f"as person_range_m, where a straight line to the person is free; {FAR_M:g} otherwise",
    "wind_x_mps": "velocity of the air, world",
    "wind_y_mps": "velocity of the air, world",
    "wind_z_mps": "velocity of the air, world",
    "haze_per_m": "extinction of light by dust; the distance of sight is 3 / haze_per_m",
    "drift_x_m": "error of the localisation that happenings bring, world",
    "drift_y_m": "error of the localisation that happenings bring, world",
    "drift_z_m": "error of the localisation that happenings bring, world",
}
"""Of signals whose declarations do not say it, or only beside another signal."""


def fact_of(name: str) -> SignalFact | None:
    """The facts of a signal; None for one that a study or a plugin brings."""
    fact = FACTS.get(name)
    if fact is None:
        return None
    (least, _), *_, (far, most) = (spans := TRUTH.get(name, ANY))[0], spans[-1]
    apart = len(spans) > 1 and far == most == FAR_M
    if apart:
        most = spans[-2][1]
    ends = [end if math.isfinite(end) else None for end in (least, most)]
    example = fact.example.replace("NAME", name)
    return replace(fact, example=example, least=ends[0], most=ends[1], elsewhere=FAR_M if apart else None)
