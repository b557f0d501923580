"""A sensor: what the simulator measures for the stack.  The stack sees nothing of the flight but its sensors."""

from typing import NamedTuple

import numpy as np
from scaloft_fi.sim.sensors.sensor import SENSORS, SensorKind
from scaloft_fi.stack.messages import Array, Stamp, Vector
from scaloft_fi.streams import Table


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


class Tracker:
    """A laser tracker at the portal: position and velocity with noise, attitude without."""

    def __init__(self, sigma_m, flight):
        # Row `tick` of a table is the same in every flight of this situation and seed, whatever else is drawn.
        self._sigma_m, self._noise = sigma_m, Table(3, *flight.stream, "your_plugin_tracker")

    def measure(self, moment):
        """What is sent at this tick; None sends nothing."""
        state = moment.state  # (13,): position, quaternion x y z w, velocity, all in the world, and angular rate
        noise = self._sigma_m * self._noise.row(moment.tick)
        return Pose(moment.now_s, state[:3] + noise, state[7:10] + noise, matrix(*state[3:7]))


# `read` takes the entry of sim/sensors.yaml; a study without the entry flies without the sensor.
SENSORS.declare(
    "your_plugin_tracker", SensorKind(Tracker, Pose, read=lambda item: item.need("sigma_m").number(least=0.0, most=1.0))
)
