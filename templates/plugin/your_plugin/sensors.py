"""A sensor: what the simulator measures for the stack.  The stack sees nothing of the flight but its sensors."""

from dataclasses import dataclass
from typing import Annotated, NamedTuple

import numpy as np
from scaloft_fi.api import SENSORS, Array, Bounds, SensorKind, Stamp, Table, Vector


class Pose(NamedTuple):
    """Where the vehicle is.

    position: (3,) [m, world]; velocity: (3,) [m/s, world]; attitude: (3, 3), the body's axes in the world as columns.
    """

    stamp_s: Stamp
    position: Vector
    velocity: Vector
    attitude: Array


def matrix(x, y, z, w):
    """The rotation matrix (3, 3) of a unit quaternion."""
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


@dataclass(frozen=True)
class TrackerConfig:
    """What sim/sensors.yaml says of the tracker; `scaloft-fi check` and an editor know it from here.

    Attributes:
        sigma_m: standard deviation of position and velocity [m, m/s].
    """

    sigma_m: Annotated[float, Bounds(least=0.0, most=1.0)]


class Tracker:
    """A laser tracker at the portal: position and velocity with noise, attitude without."""

    def __init__(self, config, flight):
        # Row `tick` of a table is the same in every flight of this situation and seed, whatever else is drawn.
        self._sigma_m, self._noise = config.sigma_m, Table(3, *flight.stream, "your_plugin_tracker")

    def measure(self, moment):
        """What is sent at this tick; None sends nothing."""
        state = moment.state  # (13,): position, quaternion x y z w, velocity, all in the world, and angular rate
        noise = self._sigma_m * self._noise.row(moment.tick)
        return Pose(moment.now_s, state[:3] + noise, state[7:10] + noise, matrix(*state[3:7]))


# A study without an entry of this name in sim/sensors.yaml flies without the sensor.
SENSORS.declare("your_plugin_tracker", SensorKind(Tracker, Pose, TrackerConfig))
