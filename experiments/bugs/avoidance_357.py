"""PX4-Avoidance issue 357, "Memory not working in real flight due to blind spot" (2019), fixed by pull request 358.

The local planner took the camera's view for slightly wider than it is.  A point at the edge is no longer in the
picture while the planner still counts it as in view, and what is in view and not in the picture is forgotten; so no
point ever reaches the memory.  The fix keeps the view that the camera has.  The thread gives no angle: a tenth is this
copy's assumption.
"""

from __future__ import annotations

import numpy as np

from experiments.bugs.bug import Bug
from experiments.bugs.staged import Parts
from scaloft_fi.stack.messages import DepthFrame
from scaloft_fi.stack.reference import estimator, memory
from scaloft_fi.stack.reference.memory import ObstacleMemory
from scaloft_fi.stack.reference.messages import Clearing, PoseEstimate

WIDER = 1.1
"""Width and height of the assumed view, as a multiple of the camera's."""


class ViewTooWide(ObstacleMemory):
    """Forgets what lies in the assumed view and is not in the picture."""

    defect = True

    def observe(self, frame: DepthFrame, pose: PoseEstimate) -> Clearing:
        """The cells to forget: those of the reference stack, and those beside the picture."""
        clearing = super().observe(frame, pose)
        if not self.defect:
            return clearing
        lost = np.isin(self._cells, clearing.forget) | self._beside_the_picture(pose)
        lost[self._places[self._places >= 0]] = False
        return clearing._replace(forget=self._cells[lost])

    def _beside_the_picture(self, pose: PoseEstimate) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
        """Which cells lie in the assumed view, but beside the camera's."""
        c, camera, turn = self.config, self.camera, np.empty((3, 3))
        estimator.rotation(pose.attitude, turn)
        eye = pose.position + camera.ahead_m * turn[:, 0]
        centres = memory.centres(self._cells, eye, c.voxel_m, np.inf)
        ahead, left, up = ((centres - eye) @ turn).T
        in_range = (ahead > c.min_range_m) & (ahead < c.max_range_m)
        side, height = (abs(first) + 0.5 * abs(step) for first, step in (camera.column, camera.row))
        in_view = (abs(left) <= side * ahead) & (abs(up) <= height * ahead)
        assumed = (abs(left) <= WIDER * side * ahead) & (abs(up) <= WIDER * height * ahead)
        beside: np.ndarray[tuple[int], np.dtype[np.bool_]] = in_range & assumed & ~in_view
        return beside


BUG = Bug(
    key="avoidance-357",
    project="PX4/PX4-Avoidance",
    thread="https://github.com/PX4/PX4-Avoidance/issues/357",
    fixed_by="pull request 358",
    cell="PARTOF-map",
    wrong="the view is taken for wider than it is; points at its edge are forgotten before they leave it",
    fix="the view is the camera's",
    written="cells beside the picture, in a view a tenth wider and higher, are forgotten",
    parts=Parts(memory=ViewTooWide),
)
