"""What travels between the stages of the stack."""

from typing import NamedTuple

from scaloft_fi.api import Stamp, Vector


class Height(NamedTuple):
    """Height above the floor [m]."""

    stamp_s: Stamp
    height_m: float


class Range(NamedTuple):
    """Distance to the nearest thing ahead [m]."""

    stamp_s: Stamp
    ahead_m: float


class Drive(NamedTuple):
    """Velocity [m/s, world] and heading [rad] to fly."""

    stamp_s: Stamp
    velocity: Vector
    yaw_rad: float
