"""Operators: each turns the samples of a seam into faulty ones.

`scaloft-fi operators` lists those that exist already; `scaloft-fi seams` lists where they fit.
"""

import numpy as np
from scaloft_fi.api import Example, Number, operator, the

from your_plugin.sensors import Pose

HERE = Pose(0.0, np.zeros(3), np.zeros(3), np.eye(3))
THERE = HERE._replace(position=np.array([0.05, 0.0, 0.0]))


# The example is a test: the samples HERE, HERE, which are 1/20 s apart, must become HERE, THERE.
@operator("your_plugin_creep", need=the(Pose), example=Example(Pose, {"rate_mps": 1.0}, (HERE, HERE), (HERE, THERE)))
def creep(_context, *, rate_mps: Number):
    """Move the reported position along x by `rate_mps` [m/s]: a tracker whose tripod slips."""

    def tap(t_s, sample):
        """Called at each poll with the time since take-off and the sample, None where nothing is sent."""
        if sample is None:
            return None
        return sample._replace(position=sample.position + np.array([rate_mps * t_s, 0.0, 0.0]))

    return tap
