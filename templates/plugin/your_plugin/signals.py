"""A signal: ground truth that requirements and axes may speak of.  No stack sees it."""

import math

from scaloft_fi.api import signal


@signal("your_plugin_tilt_deg", "deg", "angle between the body's z axis and the vertical", most=180.0)
def tilt(_scenario):
    """Called once a flight, with its situation, world and sensors; returns what is called at 20 Hz."""

    def measure(state):
        """The value in the true state (13,): position, quaternion x y z w, velocity, angular rate."""
        return math.degrees(math.acos(max(-1.0, 1.0 - 2.0 * (state[3] ** 2 + state[4] ** 2))))

    return measure
