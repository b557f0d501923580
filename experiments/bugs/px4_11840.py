"""PX4-Autopilot issue 11840, "distance_sensor timestamp from MAVLink OPTICAL_FLOW_RAD is wrong" (2019), fixed by 11852.

The receiver stamped a range with the duration over which the sensor had integrated, instead of a time; on the ground
that is zero, and the estimator never uses the range.  The fix stamps it as the optical flow of the same message.  In
the copy the receiver stamps depth frames with the camera's integration time, one period.
"""

from __future__ import annotations

from experiments.bugs.bug import Bug
from experiments.bugs.staged import Parts, Receiver
from scaloft_fi.stack.declaration import TICK_HZ
from scaloft_fi.stack.messages import SensorFrames

INTEGRATED_S = 1.0 / TICK_HZ
"""Integration time of a depth frame [s]."""


class StampedWithDuration(Receiver):
    """Stamps depth frames with their integration time."""

    defect = True

    def receive(self, frames: SensorFrames) -> SensorFrames:
        """The messages of a tick; the stamp of a depth frame is a duration."""
        if not self.defect or frames.depth is None:
            return frames
        return SensorFrames({**frames.by_sensor, "depth": frames.depth._replace(stamp_s=INTEGRATED_S)})


BUG = Bug(
    key="px4-11840",
    project="PX4/PX4-Autopilot",
    thread="https://github.com/PX4/PX4-Autopilot/issues/11840",
    fixed_by="pull request 11852",
    cell="NO-clock",
    wrong="a range is stamped with the duration of its integration instead of a time",
    fix="it is stamped with the time of the message that it came in",
    written="depth frames are stamped with the camera's integration time",
    parts=Parts(receiver=StampedWithDuration),
)
