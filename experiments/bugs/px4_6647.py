"""PX4-Autopilot pull request 6647, "Legacy vision interface timestamp hotfix" (merged in 2017).

The receiver of the legacy vision message did not fill in a time stamp, which stays zero.  The fix fills it in.  In the
copy the receiver of position fixes, the stack's vision, leaves the stamp at zero.
"""

from __future__ import annotations

from experiments.bugs.bug import Bug
from experiments.bugs.staged import Parts, Receiver
from scaloft_fi.stack.messages import SensorFrames


class Unstamped(Receiver):
    """Leaves the stamp of position fixes at zero."""

    defect = True

    def receive(self, frames: SensorFrames) -> SensorFrames:
        """The messages of a tick; the stamp of a fix is zero."""
        if not self.defect or frames.fix is None:
            return frames
        return SensorFrames({**frames.by_sensor, "positioning": frames.fix._replace(stamp_s=0.0)})


BUG = Bug(
    key="px4-6647",
    project="PX4/PX4-Autopilot",
    thread="https://github.com/PX4/PX4-Autopilot/pull/6647",
    fixed_by="the same pull request",
    cell="NO-clock",
    wrong="the time stamp of a vision message is never filled in",
    fix="it is filled in",
    written="the stamp of position fixes stays zero",
    parts=Parts(receiver=Unstamped),
)
