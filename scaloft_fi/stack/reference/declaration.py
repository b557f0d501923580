"""What the reference stack declares: seams, claims, and how it is made."""

from __future__ import annotations

from types import ModuleType
from typing import Any

import numpy as np

from scaloft_fi.stack import messages as m
from scaloft_fi.stack.declaration import STEP_HZ, TICK_HZ, Claim, Declaration, Instant, Seam, Stack, Task, Wire
from scaloft_fi.stack.messages import Array
from scaloft_fi.stack.reference import messages as own
from scaloft_fi.stack.reference.messages import BELIEFS


def _alarm(sample: own.Proximity) -> tuple[Any, ...]:
    """What the proximity monitor would conclude: which watched sectors are inside the trigger distance, the nearest.

    After a mere touch the nearest is taken of all that are watched and seen.
    """
    near = (sample.sectors < sample.trigger_m) & sample.watched
    seen = sample.watched & np.isfinite(sample.sectors) if sample.touched and not near.any() else near
    bearing_rad = sample.bearings[np.argmin(np.where(seen, sample.sectors, np.inf))] if seen.any() else 0.0
    return (sample.touched, *map(bool, near), float(bearing_rad))


def _seen(sample: own.ObstacleMap) -> Any:
    """Points and inflation; how much nothing is inflated does not matter."""
    return (sample.points, sample.inflation if len(sample.points) else 1.0)


_POSE_UNITS, _SECTOR_UNITS = {"position": "m", "velocity": "m/s"}, {"sectors": "m", "bearings": "rad"}

SEAMS = (
    Seam("imu", m.Imu, STEP_HZ, "inertial sensor -> estimator", units={"rate": "rad/s", "force": "m/s2"}),
    Seam("stamps", m.Stamps, TICK_HZ, "sensor clocks -> message stamps"),
    Seam("fix", m.Fix, TICK_HZ, "positioning -> estimator", units={"position": "m"}),
    Seam("depth", m.DepthFrame, TICK_HZ, "depth camera -> memory, proximity monitor", units={"depth": "m"}),
    Seam("metering", m.Metering, TICK_HZ, "colour camera's light meter -> exposure control"),
    Seam("exposure", m.Exposure, TICK_HZ, "exposure control -> colour camera", units={"ev": "EV"}),
    Seam("person", m.Detections, TICK_HZ, "person detector -> speed limit"),
    Seam("battery", m.Battery, TICK_HZ, "battery -> battery monitor"),
    Seam("failsafe", own.Failsafe, TICK_HZ, "battery monitor -> mission"),
    Seam("bumper", m.Bumper, TICK_HZ, "touch sensor -> proximity monitor"),
    Seam("pose", own.PoseEstimate, TICK_HZ, "estimator -> memory, mission, planner", units=_POSE_UNITS),
    Seam("proximity", own.Proximity, TICK_HZ, "proximity sectors -> proximity monitor", _alarm, _SECTOR_UNITS),
    Seam("collision", own.CollisionFlag, TICK_HZ, "proximity monitor -> recoil"),
    Seam("route", own.Route, TICK_HZ, "mission plan -> mission", units={"points": "m"}),
    Seam("goal", own.GoalCheck, TICK_HZ, "position -> goal test of the mission", lambda s: s.reached, {"offset": "m"}),
    Seam("target", own.Target, TICK_HZ, "mission -> planner", units={"point": "m"}),
    Seam("speedlimit", own.SpeedLimit, TICK_HZ, "speed limit -> speed limiter"),
    Seam("clearing", own.Clearing, TICK_HZ, "view -> obstacle memory", lambda sample: sample.forget),
    Seam("map", own.ObstacleMap, TICK_HZ, "obstacle memory -> planner", _seen, {"points": "m", "origin": "m"}),
    Seam("velcmd", own.VelocityCommand, TICK_HZ, "planner, recoil -> flight control", units={"velocity": "m/s"}),
    Seam("thrust", m.Thrust, STEP_HZ, "flight control -> rotors", units={"rotors": "N"}),
)


SIGHT_M = 4.5
"""Persons beyond this range are not acted on [m]: `speed_limit.max_range_m` of the reference study."""


HULL_M = 0.33
"""From the centre of the vehicle to a corner of its hull, level [m]."""


UNMAPPED_M = 1.0
"""Greatest error of the obstacle map [m]; the planner gives obstacles farther away than this little weight."""


def _apart(now: Instant, vector: str) -> float:
    """How far an estimate is from the truth, a vector whose signals have this name with an axis for `*`."""
    names = [vector.replace("*", axis) for axis in "xyz"]
    return float(np.linalg.norm([now.signals[f"est_{name}"][-1] - now.signals[name][-1] for name in names]))


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
    # the radius in which a waypoint counts as reached
    Claim("position estimate", "m", 0.15, lambda now: _apart(now, "*_m")),
    # some three standard deviations in a clean flight
    Claim("velocity estimate", "m/s", 0.1, lambda now: _apart(now, "v*_mps")),
    Claim("person detection", "m", 0.5, _person, about=("person_sight_m", "person_range_m")),
    Claim("obstacle map", "m", 0.2, _obstacles, seam="map"),  # half the diagonal of a cell, and the walls' roughness
)


def _module() -> ModuleType:
    from scaloft_fi.stack.reference import stack

    return stack


def _make(task: Task, wire: Wire) -> Stack:
    made: Stack = _module().ReferenceStack(task, wire)
    return made


def _settings() -> type:
    kind: type = _module().ReferenceConfig
    return kind


def _kernels(task: Task) -> None:
    _module().call_kernels(task)


REFERENCE = Declaration(
    name="reference",
    seams=SEAMS,
    beliefs=BELIEFS,
    make=_make,
    settings=_settings,
    canaries=("velcmd", "pose", "imu", "goal"),
    operators=("scaloft_fi.mutants.reference",),
    kernels=_kernels,
)
