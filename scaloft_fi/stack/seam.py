"""The seams: named, typed edges between two stages, or a setting where a stage uses it.  Faults are patched in here."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol, TypeVar

import numpy as np

from scaloft_fi.stack import messages as m
from scaloft_fi.stack.rates import STEP_HZ, TICK_HZ

S = TypeVar("S")


class Wire(Protocol):
    """What carries samples over the seams."""

    def listens(self, seam: str) -> bool:
        """Whether it matters that samples cross `seam`; where not, they need not be sent."""
        ...

    def cross(self, seam: str, t_s: float, sample: S | None) -> S | None:
        """Carry `sample` (None = nothing is sent at this tick) over `seam`; returns what arrives."""
        ...


class PlainWire:
    """Carries every sample as it is."""

    def listens(self, seam: str) -> bool:
        """Nowhere."""
        return False

    def cross(self, seam: str, t_s: float, sample: S | None) -> S | None:
        """Return `sample`."""
        return sample


def _whole(sample: Any) -> Any:
    return sample


def _reached(sample: m.GoalCheck) -> bool:
    return sample.reached


def _alarm(sample: m.Proximity) -> tuple[Any, ...]:
    """What the proximity monitor would conclude: which watched sectors are inside the trigger distance, the nearest.

    After a mere touch the nearest is taken of all that are watched and seen.
    """
    near = (sample.sectors < sample.trigger_m) & sample.watched
    seen = sample.watched & np.isfinite(sample.sectors) if sample.touched and not near.any() else near
    bearing_rad = sample.bearings[np.argmin(np.where(seen, sample.sectors, np.inf))] if seen.any() else 0.0
    return (sample.touched, *map(bool, near), float(bearing_rad))


def _forgotten(sample: m.Clearing) -> Any:
    return sample.forget


def _seen(sample: m.ObstacleMap) -> Any:
    """Points and inflation; how much nothing is inflated does not matter."""
    return (sample.points, sample.inflation if len(sample.points) else 1.0)


@dataclass(frozen=True)
class Seam:
    """One place where a fault can be patched in.

    Attributes:
        name: unique name.
        message: type of the sample.
        rate_hz: how often the seam is polled [Hz].
        edge: from which stage to which.
        effect: what of a sample its consumer acts on; a setting differs only where this does.
    """

    name: str
    message: type
    rate_hz: float
    edge: str
    effect: Callable[[Any], Any] = _whole

    def differ(self, original: Any, delivered: Any) -> bool:
        """Whether the consumer is told something else than the producer said."""
        if original is delivered:
            return False
        if original is None or delivered is None:
            return True
        return not _equal(self.effect(original), self.effect(delivered))


def _equal(a: Any, b: Any) -> bool:
    if a is b:
        return True
    if isinstance(a, tuple) and isinstance(b, tuple):
        return len(a) == len(b) and all(map(_equal, a, b))
    if isinstance(a, np.ndarray) or isinstance(b, np.ndarray):
        return _equal_arrays(np.asarray(a), np.asarray(b))
    return bool(a == b)


def _equal_arrays(a: np.ndarray[Any, Any], b: np.ndarray[Any, Any]) -> bool:
    """`numpy.array_equal(a, b, equal_nan=True)` in half the time."""
    if a.shape != b.shape:
        return False
    if a.size <= _FEW:
        return all(map(_same, a.ravel().tolist(), b.ravel().tolist()))
    return bool((a == b).all() or _same(a, b).all())


def _same(a: Any, b: Any) -> Any:
    """Whether two numbers, or each pair of those in two arrays, are equal or both NaN."""
    return (a == b) | ((a != a) & (b != b))


_FEW = 16
"""So many numbers are sooner compared one by one than as an array."""

SEAMS: dict[str, Seam] = {
    seam.name: seam
    for seam in (
        Seam("imu", m.Imu, STEP_HZ, "inertial sensor -> estimator"),
        Seam("stamps", m.Stamps, TICK_HZ, "sensor clocks -> message stamps"),
        Seam("fix", m.Fix, TICK_HZ, "positioning -> estimator"),
        Seam("depth", m.DepthFrame, TICK_HZ, "depth camera -> memory, proximity monitor"),
        Seam("metering", m.Metering, TICK_HZ, "colour camera's light meter -> exposure control"),
        Seam("exposure", m.Exposure, TICK_HZ, "exposure control -> colour camera"),
        Seam("person", m.Detections, TICK_HZ, "person detector -> speed limit"),
        Seam("battery", m.Battery, TICK_HZ, "battery -> battery monitor"),
        Seam("failsafe", m.Failsafe, TICK_HZ, "battery monitor -> mission"),
        Seam("bumper", m.Bumper, TICK_HZ, "touch sensor -> proximity monitor"),
        Seam("pose", m.PoseEstimate, TICK_HZ, "estimator -> memory, mission, planner"),
        Seam("proximity", m.Proximity, TICK_HZ, "proximity sectors -> proximity monitor", _alarm),
        Seam("collision", m.CollisionFlag, TICK_HZ, "proximity monitor -> recoil"),
        Seam("route", m.Route, TICK_HZ, "mission plan -> mission"),
        Seam("goal", m.GoalCheck, TICK_HZ, "position -> goal test of the mission", _reached),
        Seam("target", m.Target, TICK_HZ, "mission -> planner"),
        Seam("speedlimit", m.SpeedLimit, TICK_HZ, "speed limit -> speed limiter"),
        Seam("clearing", m.Clearing, TICK_HZ, "view -> obstacle memory", _forgotten),
        Seam("map", m.ObstacleMap, TICK_HZ, "obstacle memory -> planner", _seen),
        Seam("velcmd", m.VelocityCommand, TICK_HZ, "planner, recoil -> flight control"),
        Seam("thrust", m.Thrust, STEP_HZ, "flight control -> rotors"),
    )
}
