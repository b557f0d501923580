"""mavros issue 838, "Timesync issue when using Snapdragon Flight with mavros" (2017).

Poses of a vision system reach the autopilot with stamps of another epoch: the thread prints a difference of
1508529766613423 us, wall-clock time against time since start.  The estimator declares every pose timed out.  What
mends it is one time base on both sides.  In the copy the stamps of position fixes are off by that difference.
"""

from __future__ import annotations

from experiments.bugs.bug import Bug
from experiments.bugs.staged import Parts, Receiver
from scaloft_fi.stack.messages import SensorFrames

EPOCH_S = 1508529766.613423
"""The difference of the two time bases that the thread prints [s]."""


class AnotherEpoch(Receiver):
    """Hands position fixes on with wall-clock stamps."""

    defect = True

    def receive(self, frames: SensorFrames) -> SensorFrames:
        """The messages of a tick; the stamp of a fix is of another epoch."""
        fix = frames.fix
        if not self.defect or fix is None:
            return frames
        return SensorFrames({**frames.by_sensor, "positioning": fix._replace(stamp_s=fix.stamp_s + EPOCH_S)})


BUG = Bug(
    key="mavros-838",
    project="mavlink/mavros",
    thread="https://github.com/mavlink/mavros/issues/838",
    fixed_by="the thread names no change of code",
    cell="OTHERTHAN-clock",
    wrong="poses arrive with stamps of another epoch",
    fix="both sides use one time base",
    written="position fixes carry wall-clock stamps",
    parts=Parts(receiver=AnotherEpoch),
)
