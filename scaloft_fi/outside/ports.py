"""Ports: the samples that our simulator offers to stages outside, and those that it takes from them.

Frames: world = x east, y north, z up [m]; body = x forward, y left, z up.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import NamedTuple

from scaloft_fi.stack.declaration import STEP_HZ, TICK_HZ
from scaloft_fi.stack.messages import Battery, Bumper, DepthFrame, Detections, Imu, Point, Stamp, Vector
from scaloft_fi.stack.reference.messages import PoseEstimate, SpeedLimit


class CameraInfo(NamedTuple):
    """Geometry of the depth camera, with each image.  fx, fy: focal lengths; cx, cy: optical centre [pixel]."""

    stamp_s: Stamp
    width: int
    height: int
    fx: float
    fy: float
    cx: float
    cy: float


class Motion(NamedTuple):
    """A velocity command.  velocity: (3,) [m/s, in the frame of the topic]; turn_radps: rate of turn, left positive."""

    velocity: Vector
    turn_radps: float


class Goal(NamedTuple):
    """The place to fly to [m, world]."""

    point: Point


class Land(NamedTuple):
    """The order to land here and now."""

    stamp_s: Stamp


@dataclass(frozen=True)
class Port:
    """What a seam of a stage outside may carry.

    Attributes:
        message: type of the sample.
        outward: whether the simulator offers it; otherwise it takes it.
        meaning: in words.
        rate_hz: how often it is polled [Hz].
        units: of the fields whose name does not end in their unit.
    """

    message: type
    outward: bool
    meaning: str
    rate_hz: float = TICK_HZ
    units: Mapping[str, str] = field(default_factory=dict)


PORTS: Mapping[str, Port] = MappingProxyType(
    {
        "odometry": Port(
            PoseEstimate, True, "pose and velocity by the autopilot's estimate", TICK_HZ,
            {"position": "m", "velocity": "m/s"},
        ),
        "depth": Port(DepthFrame, True, "depth image", TICK_HZ, {"depth": "m"}),
        "camera_info": Port(CameraInfo, True, "geometry of the depth camera, with each image"),
        "inertial": Port(Imu, True, "angular rate and specific force", STEP_HZ, {"rate": "rad/s", "force": "m/s2"}),
        "detections": Port(Detections, True, "persons in a picture, if there are any"),
        "battery": Port(Battery, True, "charge and voltage"),
        "contacts": Port(Bumper, True, "whether hull and landing gear touch something"),
        "velocity": Port(Motion, False, "velocity command to flight control", TICK_HZ, {"velocity": "m/s"}),
        "goal": Port(Goal, False, "place to fly to, for our planner", TICK_HZ, {"point": "m"}),
        "speed_limit": Port(SpeedLimit, False, "speed limit of our planner"),
        "land": Port(Land, False, "order to land"),
    }
)  # fmt: skip
"""All ports by name."""
