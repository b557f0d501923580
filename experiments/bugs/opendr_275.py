"""opendr issue 275, "ROS nodes delay" (2022).

The nodes that detect persons and objects kept ten pictures waiting (`queue_size=10`).  A detector slower than its
camera takes the oldest of them each time, so that its answer is about a past picture.  The fix is a queue of one.  In
the copy what the detector sees comes out of a queue of ten pictures of the 20 Hz camera.
"""

from __future__ import annotations

from collections import deque

from experiments.bugs.bug import Bug
from experiments.bugs.staged import Parts, Receiver
from scaloft_fi.stack.messages import Detections, SensorFrames

QUEUE_SIZE = 10
"""Pictures that wait, of a camera that sends one a tick."""


class TenPicturesWaiting(Receiver):
    """Hands on the detections of the oldest picture in the queue."""

    defect = True

    def __init__(self) -> None:
        self._waiting: deque[Detections | None] = deque()

    def receive(self, frames: SensorFrames) -> SensorFrames:
        """The messages of a tick, with the detections of ten ticks before."""
        if not self.defect:
            return frames
        self._waiting.append(frames.detections)
        oldest = self._waiting.popleft() if len(self._waiting) > QUEUE_SIZE else None
        return SensorFrames({**frames.by_sensor, "detector": oldest})


BUG = Bug(
    key="opendr-275",
    project="opendr-eu/opendr",
    thread="https://github.com/opendr-eu/opendr/issues/275",
    fixed_by="the issue's solution, a queue of one",
    cell="LATE-human",
    wrong="ten pictures wait for a slow detector, which answers about the oldest",
    fix="one picture waits, the newest",
    written="detections pass a queue of ten pictures at 20 Hz, half a second",
    parts=Parts(receiver=TenPicturesWaiting),
)
