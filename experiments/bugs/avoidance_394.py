"""PX4-Avoidance pull request 394, "use correctly stamped tf for pointcloud" (2019), taken up by 435.

The local planner placed each point cloud with the newest transform instead of the one at the cloud's stamp, so that
points stand wrong by what the vehicle turned meanwhile.  The fix looks the transform up by the cloud's stamp; 435 keeps
a buffer for it.  In the copy depth frames are placed with the newest pose.
"""

from __future__ import annotations

from experiments.bugs.bug import Bug
from experiments.bugs.staged import Parts
from scaloft_fi.stack.declaration import Wire
from scaloft_fi.stack.reference.companion import Companion, CompanionConfig, PoseBuffer, Stages
from scaloft_fi.stack.reference.messages import PoseEstimate, Route


class NewestOnly(PoseBuffer):
    """Answers every stamp with the newest pose."""

    def at(self, stamp_s: float) -> PoseEstimate | None:
        """The newest pose, whatever the stamp."""
        return self.newest


class PlacesWithNewest(Companion):
    """Places depth frames with the newest pose."""

    defect = True

    def __init__(self, config: CompanionConfig, stages: Stages, wire: Wire, route: Route, yaw_rad: float) -> None:
        super().__init__(config, stages, wire, route, yaw_rad)
        if self.defect:
            self._poses = NewestOnly(config.pose_span_s, config.pose_reach_s)


BUG = Bug(
    key="avoidance-394",
    project="PX4/PX4-Avoidance",
    thread="https://github.com/PX4/PX4-Avoidance/pull/394",
    fixed_by="pull request 435",
    cell="PARTOF-clock",
    wrong="a point cloud is placed with the newest transform, not with the one at its stamp",
    fix="the transform is looked up at the cloud's stamp",
    written="depth frames, 0.15 s old, are placed with the newest pose",
    parts=Parts(companion=PlacesWithNewest),
)
