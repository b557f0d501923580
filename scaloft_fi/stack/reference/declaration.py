"""What the reference stack declares: its seams, its beliefs, its settings, how it is made."""

from __future__ import annotations

from typing import Any

import numpy as np

from scaloft_fi.stack import messages as m
from scaloft_fi.stack.belief import Belief, Mark
from scaloft_fi.stack.contract import Stack, Task
from scaloft_fi.stack.declaration import Declaration
from scaloft_fi.stack.rates import STEP_HZ, TICK_HZ
from scaloft_fi.stack.reference import messages as own
from scaloft_fi.stack.seam import Seam, Wire

MODES = ("takeoff", "offboard", "hold", "land", "level", "stopped")
"""What flight control does, by the number that the belief `mode` has."""
NOBODY_M = 100.0
"""Range of a person of whom the stack was not told."""


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

BELIEFS = (
    Belief(
        "told_person",
        "",
        "1 while the stack counts a person as reported",
        0.0,
        Mark("person", "a person is reported", first=True),
    ),
    Belief("told_range_m", "m", "range of that person; 100 without one", NOBODY_M, most=NOBODY_M),
    Belief("limit_mps", "m/s", "speed limit in force"),
    Belief(
        "collision_flag",
        "",
        "1 while the stack's own collision flag is up",
        0.0,
        Mark("flag", "the collision flag is raised"),
    ),
    Belief("target_index", "", "place in the route of the waypoint flown to"),
    Belief("map_points", "", "occupied cells the planner knows of"),
    Belief("cmd_vx_mps", "m/s", "ordered velocity, world"),
    Belief("cmd_vy_mps", "m/s", "ordered velocity, world"),
    Belief("cmd_vz_mps", "m/s", "ordered velocity, world"),
    Belief("cmd_yaw_rad", "rad", "ordered heading, world"),
    Belief("est_x_m", "m", "estimated position, world"),
    Belief("est_y_m", "m", "estimated position, world"),
    Belief("est_z_m", "m", "estimated position, world"),
    Belief("est_vx_mps", "m/s", "estimated velocity, world"),
    Belief("est_vy_mps", "m/s", "estimated velocity, world"),
    Belief("est_vz_mps", "m/s", "estimated velocity, world"),
    Belief("mode", "", "what flight control does, by number", mark=Mark("mode", "flight control: {}", values=MODES)),
)


def _make(task: Task, wire: Wire) -> Stack:
    from scaloft_fi.stack.reference.stack import ReferenceStack

    return ReferenceStack(task, wire)


def _settings() -> type:
    from scaloft_fi.stack.reference.stack import ReferenceConfig

    return ReferenceConfig


REFERENCE = Declaration(
    name="reference",
    seams=SEAMS,
    beliefs=BELIEFS,
    make=_make,
    settings=_settings,
    canaries=("velcmd", "pose", "imu", "goal"),
    operators=("scaloft_fi.mutants.reference",),
)
