"""Signals that follow from others, where a record lacks them."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from scaloft_fi.sim.signals import clearance_name
from scaloft_fi.stack.messages import Array, Point

PASS_M = 0.5
"""A waypoint counts as passed within this horizontal distance [m]."""
AIRBORNE_M = 0.3
"""Waypoints count only after the vehicle has been this high above the start [m]."""

Signals = Mapping[str, Array]


@dataclass(frozen=True)
class Known:
    """What is known of a flight beside its record.

    Attributes:
        surfaces: surfaces of the world.
        home: where the flight starts and ends [m, world].
        route: waypoints of the situation, home last; None where the situation is not known.
        limit_s: time limit of the flight [s]; None where it is not known.
    """

    surfaces: tuple[str, ...]
    home: tuple[float, float]
    route: tuple[Point, ...] | None = None
    limit_s: float | None = None


@dataclass(frozen=True)
class Derived:
    """A signal that follows from others.

    Attributes:
        needs: names of the others, by what is known of the flight.
        value: the signal (T,), from these and `elapsed_s`.
        lacking: what must be known of the flight, in words; "" when it is known.
    """

    needs: Callable[[Known], tuple[str, ...]]
    value: Callable[[Signals, Known], Array]
    lacking: Callable[[Known], str] = lambda _: ""


def _remaining(signals: Signals, known: Known) -> Array:
    assert known.limit_s is not None
    return known.limit_s - signals["elapsed_s"]


def _speed(signals: Signals, _: Known) -> Array:
    return np.sqrt(signals["vx_mps"] ** 2 + signals["vy_mps"] ** 2 + signals["vz_mps"] ** 2)


def _home(signals: Signals, known: Known) -> Array:
    return np.hypot(signals["x_m"] - known.home[0], signals["y_m"] - known.home[1])


def _yaw(signals: Signals, _: Known) -> Array:
    x, y, z, w = (signals[name] for name in ("qx", "qy", "qz", "qw"))
    return np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))


def _clearance(signals: Signals, known: Known) -> Array:
    least: Array = np.min(np.array([signals[name] for name in _clearances(known)], np.float64), axis=0)
    return least


def _clearances(known: Known) -> tuple[str, ...]:
    return tuple(map(clearance_name, known.surfaces))


def _waypoints_left(signals: Signals, known: Known) -> Array:
    assert known.route is not None
    left, passed, airborne = [], 0, False
    start_m = float(signals["z_m"][0])
    for x_m, y_m, z_m in zip(*(signals[name].tolist() for name in ("x_m", "y_m", "z_m")), strict=True):
        airborne |= z_m - start_m > AIRBORNE_M
        while airborne and passed < len(known.route):
            if math.hypot(x_m - known.route[passed][0], y_m - known.route[passed][1]) > PASS_M:
                break
            passed += 1
        left.append(float(len(known.route) - passed))
    return np.array(left)


def _situation(known: Known) -> str:
    return "" if known.route is not None else "the situation of the flight"


def _limit(known: Known) -> str:
    return "" if known.limit_s is not None else "the situation of the flight"


DERIVED: Mapping[str, Derived] = MappingProxyType(
    {
        "remaining_s": Derived(lambda _: (), _remaining, _limit),
        "speed_mps": Derived(lambda _: ("vx_mps", "vy_mps", "vz_mps"), _speed),
        "home_m": Derived(lambda _: ("x_m", "y_m"), _home),
        "yaw_rad": Derived(lambda _: ("qx", "qy", "qz", "qw"), _yaw),
        "clearance_m": Derived(_clearances, _clearance),
        "waypoints_left": Derived(lambda _: ("x_m", "y_m", "z_m"), _waypoints_left, _situation),
    }
)
"""The derived signals by name."""
