"""PX4-Autopilot pull request 23047, "Lightware SF45 fix to orientation offsets for scaled yaw" (merged in 2024).

The driver of a scanning range finder added the angle of its mounting, in degrees, to a raw angle in hundredths of a
degree.  Facing left, right or aft the obstacles so stand in the wrong bins of the obstacle map; facing forward the
offset is zero.  The fix adds the offset to the scaled angle.  In the copy the proximity monitor's sensor counts its
angles from the tail, as one that is mounted facing aft, so that the driver must add 180 degrees and adds 1.8.
"""

from __future__ import annotations

import math

from experiments.bugs.bug import Bug
from experiments.bugs.staged import Parts
from scaloft_fi.stack.messages import DepthFrame
from scaloft_fi.stack.reference.messages import PoseEstimate, Proximity
from scaloft_fi.stack.reference.proximity import ProximityMonitor

MOUNTED_RAD = math.pi
"""Angle from the nose to the direction in which the sensor's own zero lies [rad]."""
RAW_PER_DEG = 100.0
"""Raw units of the sensor in a degree."""


class MountedAft(ProximityMonitor):
    """Adds the angle of the mounting to the sensor's raw angle, in the wrong unit."""

    defect = True

    def sectors(self, frame: DepthFrame, pose: PoseEstimate) -> Proximity:
        """Least range in each sector; the bearings are wrong by the angle of the mounting."""
        seen = super().sectors(frame, pose)
        if not self.defect:
            return seen
        own = seen.bearings - MOUNTED_RAD
        return seen._replace(bearings=own + MOUNTED_RAD / RAW_PER_DEG)


BUG = Bug(
    key="px4-23047",
    project="PX4/PX4-Autopilot",
    thread="https://github.com/PX4/PX4-Autopilot/pull/23047",
    fixed_by="the same pull request",
    cell="OTHERTHAN-collision",
    wrong="the mounting angle is added to the raw yaw, which is in hundredths of a degree",
    fix="the mounting angle is added to the scaled yaw",
    written="the sensor of the proximity monitor counts from the tail, and 1.8 degrees are added instead of 180",
    parts=Parts(proximity=MountedAft),
)
