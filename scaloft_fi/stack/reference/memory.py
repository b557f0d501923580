"""Obstacle memory: the cells of space that were seen occupied, also outside the present field of view.

Like the local planner of PX4-Avoidance it keeps points outside the field of view up to a maximum age and trusts the
newest frame inside it: a pixel that sees farther than a cell, or that sees nothing, clears that cell.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from scaloft_fi.stack.camera import DepthCamera
from scaloft_fi.stack.config import Bounds, Count, NotNegative
from scaloft_fi.stack.fields import Array
from scaloft_fi.stack.messages import DepthFrame
from scaloft_fi.stack.reference import voxels
from scaloft_fi.stack.reference.messages import Clearing, ObstacleMap, PoseEstimate
from scaloft_fi.stack.reference.voxels import Cells

_NOTHING: Cells = np.empty(0, np.int64)


@dataclass(frozen=True)
class MemoryConfig:
    """Settings of the obstacle memory.

    Attributes:
        voxel_m: edge of a cell [m].
        max_age_s: how long a cell outside the view is kept [s] (PX4-Avoidance max_point_age_s).
        min_range_m: smaller depths are not used [m].
        max_range_m: greater depths are not used [m].
        min_pixels: pixels of one frame that must fall into a cell to mark it.
        clear_margin_m: how much farther than a cell's centre a pixel must see to clear it [m].
        local_radius_m: the map holds the cells within this distance of the vehicle [m].
    """

    voxel_m: Annotated[float, Bounds(least=0.01, most=100.0)]
    max_age_s: float
    min_range_m: NotNegative
    max_range_m: NotNegative
    min_pixels: Count
    clear_margin_m: float
    local_radius_m: NotNegative


class ObstacleMemory:
    """Sparse set of occupied cells, in the order in which they were first seen.

    Cells are indices of an unbounded grid of edge `voxel_m` aligned with the world's origin; see `voxels.cells_at`.
    """

    def __init__(self, config: MemoryConfig, camera: DepthCamera) -> None:
        self.config = config
        self.camera = camera
        self._cells: Cells = np.empty(0, np.int64)
        self._seen_s: Array = np.empty(0)
        self._frame_s = -math.inf
        self._fresh: Cells = np.empty(0, np.int64)  # cells that the newest frame marks
        self._places: Cells = np.empty(0, np.int64)  # their places in _cells, or -1

    def __len__(self) -> int:
        return len(self._cells)

    def observe(self, frame: DepthFrame, pose: PoseEstimate) -> Clearing:
        """The cells to forget after `frame`, taken from `pose`: cells that it sees through, and cells that are too old.

        Keeps the cells that the frame marks until `update`; none of them is forgotten.
        """
        c, camera = self.config, self.camera
        self._fresh, self._places, forget = voxels.observe(
            np.ascontiguousarray(frame.depth), camera.ahead_m, camera.column, camera.row, pose.position, pose.attitude,
            c.voxel_m, (c.min_range_m, c.max_range_m), c.min_pixels, c.clear_margin_m,
            self._cells, self._seen_s, frame.stamp_s - c.max_age_s,
        )  # fmt: skip
        self._frame_s = frame.stamp_s
        return Clearing(frame.stamp_s, forget, self._cells)

    def update(self, delivered: Clearing | None) -> None:
        """Forget the cells that were `delivered` (None: no cell), then insert the cells that the last frame marked."""
        forget = np.ascontiguousarray(delivered.forget) if delivered is not None else _NOTHING
        self._cells, self._seen_s = voxels.update(
            self._cells, self._seen_s, forget, self._fresh, self._places, self._frame_s
        )
        self._fresh = self._places = _NOTHING

    def map(self, pose: PoseEstimate) -> ObstacleMap:
        """The occupied cells' centres around `pose`, stamped with the newest frame's stamp."""
        points = voxels.centres(self._cells, pose.position, self.config.voxel_m, self.config.local_radius_m)
        return ObstacleMap(self._frame_s, points, 1.0, pose.position)
