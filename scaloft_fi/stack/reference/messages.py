"""Messages between the stages of the reference stack, and its beliefs; those of sensors: `stack.messages`."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from scaloft_fi.stack.declaration import Belief, Mark
from scaloft_fi.stack.messages import Array, Point, Stamp, Vector


class PoseEstimate(NamedTuple):
    """The estimate that the companion's stages receive.

    position: (3,) [m, world]; velocity: (3,) [m/s, world]; yaw_rad: heading [rad]; attitude: (4,) x, y, z, w.
    """

    stamp_s: Stamp
    position: Vector
    velocity: Vector
    yaw_rad: float
    attitude: Array


class Proximity(NamedTuple):
    """Input of the proximity monitor.

    sectors: (S,) least range seen in each bearing sector, left to right [m], inf where nothing was seen;
    watched: (S,) which sectors the monitor looks at; bearings: (S,) sector centres [rad, body, left positive].
    """

    stamp_s: Stamp
    sectors: Array
    watched: NDArray[np.bool_]
    bearings: Array
    trigger_m: float
    touched: bool


class CollisionFlag(NamedTuple):
    """The stack's own collision flag; sent only while raised.

    bearing_rad: direction of the obstacle [rad, body, left positive].
    """

    stamp_s: Stamp
    bearing_rad: float


class GoalCheck(NamedTuple):
    """Input of the goal test.

    leg: place of the waypoint in the route; offset: (3,) waypoint minus position [m, world];
    axes: (3,) 1.0 for each axis that counts; speed_mps: closing speed [m/s];
    verdict: None = the distance decides; a fault may set it.
    """

    leg: int
    offset: Point
    axes: Point
    radius_m: float
    speed_mps: float
    verdict: bool | None = None

    @property
    def distance_m(self) -> float:
        """Distance over the axes that count [m]."""
        (x, y, z), (along_x, along_y, along_z) = self.offset, self.axes
        return float(((x * along_x) ** 2 + (y * along_y) ** 2 + (z * along_z) ** 2) ** 0.5)

    @property
    def reached(self) -> bool:
        """Whether the waypoint counts as reached."""
        return self.distance_m < self.radius_m if self.verdict is None else self.verdict


class Route(NamedTuple):
    """The waypoints of the mission in order, the last one home [m, world]."""

    points: tuple[Point, ...]


class Target(NamedTuple):
    """The waypoint that the planner flies to: place in the route, position [m, world]."""

    leg: int
    point: Point


class SpeedLimit(NamedTuple):
    """Speed limit [m/s]; `norm`: what it limits, "euclidean" (the speed) or "per_axis" (each component)."""

    stamp_s: Stamp
    limit_mps: float
    norm: str


class Clearing(NamedTuple):
    """The cells that the obstacle memory is about to forget.

    forget: (N,) cells to erase; occupied: (M,) all occupied cells (indices of the memory's grid).
    """

    stamp_s: Stamp
    forget: NDArray[np.int64]
    occupied: NDArray[np.int64]


class ObstacleMap(NamedTuple):
    """The obstacle map that the planner receives.

    points: (N, 3) centres of occupied cells [m, world]; inflation: factor on the planner's obstacle dilation;
    origin: (3,) believed position of the vehicle [m, world].
    """

    stamp_s: Stamp
    points: Array
    inflation: float
    origin: Vector


class VelocityCommand(NamedTuple):
    """Order to flight control.  velocity: (3,) [m/s, world]; yaw_rad: heading to take [rad, world]."""

    stamp_s: Stamp
    velocity: Vector
    yaw_rad: float


class Failsafe(NamedTuple):
    """Request of the battery monitor to the mission: "return" (fly home and land) or "land" (here and now)."""

    stamp_s: Stamp
    action: str


MODES = ("takeoff", "offboard", "hold", "land", "level", "stopped")
"""Modes of flight control; the belief `mode` is a place in this list."""
NOBODY_M = 100.0
"""The belief `told_range_m` while no person counts as reported."""

_SEEN = Mark("person", "a person is reported", first=True)
_RAISED = Mark("recoil", "the collision flag is raised", colour="#b45309")
_CHANGED = Mark("mode", "flight control: {}", values=MODES, colour="")

BELIEFS = (
    Belief("told_person", "", "1 while the stack counts a person as reported", 0.0, _SEEN),
    Belief("told_range_m", "m", "range of that person; 100 without one", NOBODY_M, most=NOBODY_M),
    Belief("limit_mps", "m/s", "speed limit in force"),
    Belief("collision_flag", "", "1 while the stack's own collision flag is up", 0.0, _RAISED),
    Belief("target_index", "", "place in the route of the waypoint flown to"),
    Belief("map_points", "", "occupied cells the planner knows of"),
    *(Belief(f"cmd_v{axis}_mps", "m/s", "ordered velocity, world") for axis in "xyz"),
    Belief("cmd_yaw_rad", "rad", "ordered heading, world"),
    *(Belief(f"est_{axis}_m", "m", "estimated position, world") for axis in "xyz"),
    *(Belief(f"est_v{axis}_mps", "m/s", "estimated velocity, world") for axis in "xyz"),
    Belief("mode", "", "what flight control does, by number", mark=_CHANGED),
)
