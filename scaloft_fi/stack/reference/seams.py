"""Where the reference stack can be patched."""

from __future__ import annotations

from typing import Any

import numpy as np

from scaloft_fi.stack import messages as m
from scaloft_fi.stack.rates import STEP_HZ, TICK_HZ
from scaloft_fi.stack.reference import messages as own
from scaloft_fi.stack.seam import Seam


def _reached(sample: own.GoalCheck) -> bool:
    return sample.reached


def _alarm(sample: own.Proximity) -> tuple[Any, ...]:
    """What the proximity monitor would conclude: which watched sectors are inside the trigger distance, the nearest.

    After a mere touch the nearest is taken of all that are watched and seen.
    """
    near = (sample.sectors < sample.trigger_m) & sample.watched
    seen = sample.watched & np.isfinite(sample.sectors) if sample.touched and not near.any() else near
    bearing_rad = sample.bearings[np.argmin(np.where(seen, sample.sectors, np.inf))] if seen.any() else 0.0
    return (sample.touched, *map(bool, near), float(bearing_rad))


def _forgotten(sample: own.Clearing) -> Any:
    return sample.forget


def _seen(sample: own.ObstacleMap) -> Any:
    """Points and inflation; how much nothing is inflated does not matter."""
    return (sample.points, sample.inflation if len(sample.points) else 1.0)


_POSE_UNITS = {"position": "m", "velocity": "m/s"}
_SECTOR_UNITS = {"sectors": "m", "bearings": "rad"}

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
    Seam(
        "pose",
        own.PoseEstimate,
        TICK_HZ,
        "estimator -> memory, mission, planner",
        units={"position": "m", "velocity": "m/s"},
    ),
    Seam(
        "proximity",
        own.Proximity,
        TICK_HZ,
        "proximity sectors -> proximity monitor",
        _alarm,
        units={"sectors": "m", "bearings": "rad"},
    ),
    Seam("collision", own.CollisionFlag, TICK_HZ, "proximity monitor -> recoil"),
    Seam("route", own.Route, TICK_HZ, "mission plan -> mission", units={"points": "m"}),
    Seam("goal", own.GoalCheck, TICK_HZ, "position -> goal test of the mission", _reached, units={"offset": "m"}),
    Seam("target", own.Target, TICK_HZ, "mission -> planner", units={"point": "m"}),
    Seam("speedlimit", own.SpeedLimit, TICK_HZ, "speed limit -> speed limiter"),
    Seam("clearing", own.Clearing, TICK_HZ, "view -> obstacle memory", _forgotten),
    Seam("map", own.ObstacleMap, TICK_HZ, "obstacle memory -> planner", _seen, {"points": "m", "origin": "m"}),
    Seam("velcmd", own.VelocityCommand, TICK_HZ, "planner, recoil -> flight control", units={"velocity": "m/s"}),
    Seam("thrust", m.Thrust, STEP_HZ, "flight control -> rotors", units={"rotors": "N"}),
)
