"""Messages between sensors, stack and rotors, and the kinds of their fields, for which operators ask.

Frames: world = x east, y north, z up [m]; body = x forward, y left, z up.
`stamp_s` is the time of the measurement by the sender's clock [s]; the consumer compares it with its own clock.

A message is a `typing.NamedTuple`.  A field's kind follows from its annotation: `float`, `int`, `bool` and `str` are
plain; `Vector`, `Image` and `Stamp` carry a kind beside their type.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from copy import deepcopy
from dataclasses import dataclass, field
from enum import StrEnum
from functools import cache
from typing import Annotated, Any, Generic, NamedTuple, TypeVar, get_args, get_origin, get_type_hints

import numpy as np
from numpy.typing import NDArray

M = TypeVar("M")


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


class Pressure(NamedTuple):
    """Sample of a barometer: static pressure [hPa]."""

    stamp_s: Stamp
    pressure_hpa: float


class MagneticField(NamedTuple):
    """Sample of a magnetometer.  field: (3,) magnetic flux density [uT, body]."""

    stamp_s: Stamp
    field: Vector


EARTH_FIELD_UT = (21.0, 0.0, -42.0)
"""Magnetic field in the mine [uT, world], about that of central Europe (World Magnetic Model 2025: horizontal 21 uT, 42
uT down); its horizontal part points along x, which a firmware takes for north."""


def standard_hpa(altitude_m: float) -> float:
    """Pressure at an altitude above sea level [hPa], ISO 2533 standard atmosphere.

    >>> round(standard_hpa(0.0), 2), round(standard_hpa(1000.0), 1)
    (1013.25, 898.7)
    """
    return 1013.25 * math.pow(1.0 - 2.25577e-5 * altitude_m, 5.25588)


class Bumper(NamedTuple):
    """Touch sensor: contact at the hull, contact at the landing gear."""

    stamp_s: Stamp
    hull: bool
    gear: bool


class Thrust(NamedTuple):
    """Order to the rotors.  rotors: (4,) thrust of each [N]."""

    rotors: Array


class Entry(Generic[M]):
    """An attribute that is an entry of its owner, by name."""

    def __init__(self, name: str) -> None:
        self._name = name

    def __get__(self, owner: Any, _kind: type) -> M:
        entry: M = owner[self._name]
        return entry


@dataclass(frozen=True)
class SensorFrames:
    """All that the sensors deliver at one 20 Hz tick.

    Attributes:
        by_sensor: message by the sensor's name in `sensors.yaml`, None where nothing is due.
        fix, depth, detections, metering, battery: messages of the sensors that every study has.
        bumper: of the touch sensor, at every tick.
    """

    by_sensor: Mapping[str, Any]
    fix = Entry[Fix | None]("positioning")
    depth = Entry[DepthFrame | None]("depth")
    detections = Entry[Detections | None]("detector")
    metering = Entry[Metering | None]("metering")
    battery = Entry[Battery | None]("battery")
    bumper = Entry[Bumper]("bumper")

    def __getitem__(self, sensor: str) -> Any:
        return self.by_sensor[sensor]


Array = NDArray[np.float64]
Point = tuple[float, float, float]


class Kind(StrEnum):
    """The kind of a field, beside its type."""

    STAMP = "a time stamp"
    VECTOR = "a vector"
    IMAGE = "an image"


Stamp = Annotated[float, Kind.STAMP]
"""A time stamp [s]."""
Vector = Annotated[Array, Kind.VECTOR]
"""(3,) the components x, y, z."""
Image = Annotated[Array, Kind.IMAGE]
"""(H, W) one number for each pixel, 0 where the sensor saw nothing."""


def field_names(message: type) -> tuple[str, ...]:
    """All fields of a message."""
    return tuple(getattr(message, "_fields", ()))


def number_fields(message: type) -> tuple[str, ...]:
    """Fields that are a number, a tuple of numbers, or an array of numbers."""
    return _sorted(message)["numbers"]


def stamp_fields(message: type) -> tuple[str, ...]:
    """Fields that are time stamps."""
    return _sorted(message)["stamps"]


def image_fields(message: type) -> tuple[str, ...]:
    """Fields that are images."""
    return _sorted(message)["images"]


def vector_fields(message: type) -> tuple[str, ...]:
    """Fields with the components x, y, z."""
    return _sorted(message)["vectors"]


def sealed(sample: Any) -> Any:
    """A copy of a sample whose arrays cannot be written to."""
    copied = deepcopy(sample)
    for value in copied or ():
        if isinstance(value, np.ndarray):
            value.setflags(write=False)
    return copied


def misshapen(sent: Any, delivered: Any) -> str:
    """Which array of a delivered sample has another shape than the one that was sent; "" for none.

    A compiled consumer reads a smaller array beyond its end.  A table (N, ...) that is no image may have more rows or
    fewer, and a list of whole numbers is free.
    """
    message: type = type(sent)
    kinds = _sorted(message)
    for name in kinds["arrays"] if sent is not None and delivered is not None else ():
        array, due = getattr(delivered, name), getattr(sent, name)
        rows = due.ndim > 1 and name not in kinds["images"]
        shape = getattr(array, "shape", ())
        if array is not due and (len(shape) != due.ndim or shape[rows:] != due.shape[rows:]):
            return f"{name} has the shape {shape}, and {due.shape} was sent"
    return ""


def field_type(message: type, field: str) -> Any:
    """The annotated type of one field, without its kind."""
    return get_type_hints(message)[field]


@cache
def _sorted(message: type) -> Mapping[str, tuple[str, ...]]:
    """The fields of a message by kind, cached because operators look them up at every sample."""
    types, kinds = get_type_hints(message), get_type_hints(message, include_extras=True)

    def of(kind: Kind) -> tuple[str, ...]:
        return tuple(name for name in field_names(message) if kind in getattr(kinds[name], "__metadata__", ()))

    vectors, points = of(Kind.VECTOR), [name for name in types if types[name] == Point]
    return {
        "numbers": tuple(name for name in field_names(message) if _numeric(types[name])),
        "vectors": tuple(name for name in field_names(message) if name in (*vectors, *points)),
        "images": of(Kind.IMAGE),
        "stamps": of(Kind.STAMP),
        "arrays": tuple(name for name in field_names(message) if _array(types[name]) and "int" not in str(types[name])),
    }


def _array(hint: Any) -> bool:
    # from numpy 2.5 on the origin of `NDArray[...]` is `NDArray` itself
    return hint is np.ndarray or get_origin(hint) in (np.ndarray, NDArray)


def _numeric(hint: Any) -> bool:
    if hint in (float, int):
        return True
    if get_origin(hint) is tuple:
        return all(entry is float for entry in get_args(hint))
    return _array(hint) and "float64" in str(hint)


@dataclass(frozen=True, eq=False)
class DepthCamera:
    """A pinhole camera that looks along the body's x axis.

    Attributes:
        rays: (H, W, 3) per pixel the point at depth 1 m, (1, left, up) [m, body axes at the camera].
        ahead_m: how far the camera sits ahead of the vehicle's centre [m].
        column: slope (left/depth) of column 0, and its step per column.
        row: slope (up/depth) of row 0, and its step per row.

    Raises:
        ValueError: the rays are not those of a pinhole camera.
    """

    rays: Array
    ahead_m: float
    column: tuple[float, float] = field(init=False)
    row: tuple[float, float] = field(init=False)

    def __post_init__(self) -> None:
        rays = np.ascontiguousarray(self.rays, dtype=np.float64)
        left, up = rays[0, :, 1], rays[:, 0, 2]
        column = (float(left[0]), float(left[-1] - left[0]) / (len(left) - 1))
        row = (float(up[0]), float(up[-1] - up[0]) / (len(up) - 1))
        ideal = np.ones_like(rays)
        ideal[:, :, 1] = column[0] + column[1] * np.arange(len(left))
        ideal[:, :, 2] = (row[0] + row[1] * np.arange(len(up)))[:, None]
        if column[1] == 0 or row[1] == 0 or not np.allclose(rays, ideal, atol=1e-9):
            raise ValueError("rays must be those of a pinhole camera: (1, left, up), linear in column and row")
        rays.setflags(write=False)
        for name, value in (("rays", rays), ("column", column), ("row", row)):
            object.__setattr__(self, name, value)

    def __deepcopy__(self, memo: dict[int, Any]) -> DepthCamera:
        return self

    @classmethod
    def pinhole(cls, width: int, height: int, fov_rad: float, ahead_m: float) -> DepthCamera:
        """Camera of `width` x `height` square pixels, `fov_rad` wide, a ray through each pixel's centre."""
        pitch = 2.0 * math.tan(fov_rad / 2.0) / width
        rays = np.ones((height, width, 3))
        rays[:, :, 1] = ((width - 1) / 2.0 - np.arange(width)) * pitch
        rays[:, :, 2] = (((height - 1) / 2.0 - np.arange(height)) * pitch)[:, None]
        return cls(rays, ahead_m)
