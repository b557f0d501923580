"""What travels between the stages of the stack.  Every message is a tuple and is never written to after it was sent.

Frames: world = x east, y along the corridor, z up [m]; body = x forward, y left, z up.
`stamp_s` is the sender's clock when the thing was measured [s]; the consumer compares it with its own clock.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Point = tuple[float, float, float]


class Imu(NamedTuple):
    """Inertial sample.  rate: (3,) angular rate [rad/s, body]; force: (3,) specific force [m/s2, body]."""

    stamp_s: float
    rate: Array
    force: Array


class Fix(NamedTuple):
    """Position fix of the mine's positioning system.  position: (3,) [m, world]; yaw_rad: heading [rad, world]."""

    stamp_s: float
    position: Array
    yaw_rad: float


class DepthFrame(NamedTuple):
    """Depth image.  depth: (H, W) distance along the optical axis [m], 0 where the sensor saw nothing."""

    stamp_s: float
    depth: Array


class Person(NamedTuple):
    """One detected box: class label, confidence 0..1, bearing from the optical axis [rad, left positive], range [m]."""

    label: str
    score: float
    bearing_rad: float
    range_m: float


class Detections(NamedTuple):
    """The boxes of one image; sent only when there is at least one."""

    stamp_s: float
    persons: tuple[Person, ...]


class Metering(NamedTuple):
    """The colour camera's light meter: how far the image is under (+) or over (-) exposed [EV]."""

    stamp_s: float
    error_ev: float


class Exposure(NamedTuple):
    """Order to the colour camera: exposure [EV], sensor gain factor, share of the image that is saturated (0..1)."""

    ev: float
    gain: float
    saturated: float


class Stamps(NamedTuple):
    """What the sensors' clocks say now [s]; each sensor stamps its messages with its own entry."""

    fix_s: float
    depth_s: float
    person_s: float


class Battery(NamedTuple):
    """Battery telemetry: state of charge 0..1, terminal voltage [V], cells in series."""

    stamp_s: float
    charge: float
    voltage_v: float
    cells: int


class Bumper(NamedTuple):
    """Touch sensor: contact at the hull, contact at the landing gear."""

    stamp_s: float
    hull: bool
    gear: bool


class PoseEstimate(NamedTuple):
    """The estimator's word to the companion stages.

    position: (3,) [m, world]; velocity: (3,) [m/s, world]; yaw_rad: heading [rad]; attitude: (4,) x, y, z, w.
    """

    stamp_s: float
    position: Array
    velocity: Array
    yaw_rad: float
    attitude: Array


class Proximity(NamedTuple):
    """Input of the proximity monitor.

    sectors: (S,) least range seen in each bearing sector, left to right [m], inf where nothing was seen;
    watched: (S,) which sectors the monitor looks at; bearings: (S,) sector centres [rad, body, left positive].
    """

    stamp_s: float
    sectors: Array
    watched: NDArray[np.bool_]
    bearings: Array
    trigger_m: float
    touched: bool


class CollisionFlag(NamedTuple):
    """The stack's own collision flag; sent only while raised.  bearing_rad: where from [rad, body, left positive]."""

    stamp_s: float
    bearing_rad: float


class GoalCheck(NamedTuple):
    """Input of the goal test.

    leg: place of the waypoint in the route; offset: (3,) waypoint minus position [m, world];
    axes: (3,) 1.0 for each axis that counts; speed_mps: closing speed [m/s];
    verdict: None = by distance, else what a fault says.
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
        return float(sum((o * a) ** 2 for o, a in zip(self.offset, self.axes, strict=True)) ** 0.5)

    @property
    def reached(self) -> bool:
        """Whether the waypoint counts as reached."""
        return self.distance_m < self.radius_m if self.verdict is None else self.verdict


class Route(NamedTuple):
    """The waypoints of the mission in order, the last one home [m, world]."""

    points: tuple[Point, ...]


class Target(NamedTuple):
    """The waypoint the planner flies to: place in the route, position [m, world]."""

    leg: int
    point: Point


class SpeedLimit(NamedTuple):
    """Speed limit [m/s]; `norm` says of what: "euclidean" (the speed) or "per_axis" (each axis by itself)."""

    stamp_s: float
    limit_mps: float
    norm: str


class Clearing(NamedTuple):
    """What the obstacle memory is about to forget.

    forget: (N,) cells to erase; occupied: (M,) all occupied cells (indices of the memory's grid).
    """

    stamp_s: float
    forget: NDArray[np.int64]
    occupied: NDArray[np.int64]


class ObstacleMap(NamedTuple):
    """What the memory tells the planner.

    points: (N, 3) centres of occupied cells [m, world]; inflation: factor on the planner's obstacle dilation;
    origin: (3,) where the vehicle believes to be [m, world].
    """

    stamp_s: float
    points: Array
    inflation: float
    origin: Array


class VelocityCommand(NamedTuple):
    """Order to flight control.  velocity: (3,) [m/s, world]; yaw_rad: heading to take [rad, world]."""

    stamp_s: float
    velocity: Array
    yaw_rad: float


class Thrust(NamedTuple):
    """Order to the rotors.  rotors: (4,) thrust of each [N]."""

    rotors: Array


class Failsafe(NamedTuple):
    """What the battery monitor asks of the mission: "return" (fly home and land) or "land" (here and now)."""

    stamp_s: float
    action: str


@dataclass(frozen=True)
class SensorFrames:
    """All that the sensors deliver at one 20 Hz tick.

    Attributes:
        by_sensor: message by the sensor's name in `sensors.yaml`, None where nothing is due.
    """

    by_sensor: Mapping[str, Any]

    def __getitem__(self, sensor: str) -> Any:
        return self.by_sensor[sensor]

    @property
    def fix(self) -> Fix | None:
        """Of the positioning system."""
        fix: Fix | None = self.by_sensor["positioning"]
        return fix

    @property
    def depth(self) -> DepthFrame | None:
        """Of the depth camera."""
        frame: DepthFrame | None = self.by_sensor["depth"]
        return frame

    @property
    def detections(self) -> Detections | None:
        """Of the person detector."""
        detections: Detections | None = self.by_sensor["detector"]
        return detections

    @property
    def metering(self) -> Metering | None:
        """Of the colour camera's light meter."""
        metering: Metering | None = self.by_sensor["metering"]
        return metering

    @property
    def battery(self) -> Battery | None:
        """Of the battery."""
        battery: Battery | None = self.by_sensor["battery"]
        return battery

    @property
    def bumper(self) -> Bumper:
        """Of the touch sensor, at every tick."""
        bumper: Bumper = self.by_sensor["bumper"]
        return bumper
