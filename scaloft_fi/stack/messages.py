"""Messages between sensors, stack and rotors.  A message is a tuple; nobody writes to it after it was sent.

Frames: world = x east, y north, z up [m]; body = x forward, y left, z up.
`stamp_s` is the time of the measurement by the sender's clock [s]; the consumer compares it with its own clock.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

from scaloft_fi.stack.fields import Array, Image, Stamp, Vector


class Imu(NamedTuple):
    """Inertial sample.  rate: (3,) angular rate [rad/s, body]; force: (3,) specific force [m/s2, body]."""

    stamp_s: Stamp
    rate: Vector
    force: Vector


class Fix(NamedTuple):
    """Position fix of the mine's positioning system.  position: (3,) [m, world]; yaw_rad: heading [rad, world]."""

    stamp_s: Stamp
    position: Vector
    yaw_rad: float


class DepthFrame(NamedTuple):
    """Depth image.  depth: (H, W) distance along the optical axis [m], 0 where the sensor saw nothing."""

    stamp_s: Stamp
    depth: Image


class Person(NamedTuple):
    """One detected box: class label, confidence 0..1, bearing from the optical axis [rad, left positive], range [m]."""

    label: str
    score: float
    bearing_rad: float
    range_m: float


class Detections(NamedTuple):
    """The boxes of one image; sent only when there is at least one."""

    stamp_s: Stamp
    persons: tuple[Person, ...]


class Metering(NamedTuple):
    """The colour camera's light meter: how far the image is under (+) or over (-) exposed [EV]."""

    stamp_s: Stamp
    error_ev: float


class Exposure(NamedTuple):
    """Order to the colour camera: exposure [EV], sensor gain factor, share of the image that is saturated (0..1)."""

    ev: float
    gain: float
    saturated: float


class Stamps(NamedTuple):
    """Readings of the sensors' clocks [s]; each sensor stamps its messages with its own entry."""

    fix_s: Stamp
    depth_s: Stamp
    person_s: Stamp


class Battery(NamedTuple):
    """Battery telemetry: state of charge 0..1, terminal voltage [V], cells in series."""

    stamp_s: Stamp
    charge: float
    voltage_v: float
    cells: int


class Bumper(NamedTuple):
    """Touch sensor: contact at the hull, contact at the landing gear."""

    stamp_s: Stamp
    hull: bool
    gear: bool


class Thrust(NamedTuple):
    """Order to the rotors.  rotors: (4,) thrust of each [N]."""

    rotors: Array


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
