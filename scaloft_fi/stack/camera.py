"""The geometry of the depth camera, as its consumers know it."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from scaloft_fi.stack.fields import Array


@dataclass(frozen=True, eq=False)
class DepthCamera:
    """A pinhole camera that looks along the body's x axis.

    Attributes:
        rays: (H, W, 3) per pixel the point at depth 1 m, (1, left, up) [m, body axes at the camera].
        ahead_m: how far the camera sits ahead of the vehicle's centre [m].
        column: slope (left/depth) of column 0, and its step per column.
        row: slope (up/depth) of row 0, and its step per row.

    Raises:
        ValueError: the rays are not those of a pinhole camera.
    """

    rays: Array
    ahead_m: float
    column: tuple[float, float] = field(init=False)
    row: tuple[float, float] = field(init=False)

    def __post_init__(self) -> None:
        rays = np.ascontiguousarray(self.rays, dtype=np.float64)
        left, up = rays[0, :, 1], rays[:, 0, 2]
        column = (float(left[0]), float(left[-1] - left[0]) / (len(left) - 1))
        row = (float(up[0]), float(up[-1] - up[0]) / (len(up) - 1))
        ideal = np.ones_like(rays)
        ideal[:, :, 1] = column[0] + column[1] * np.arange(len(left))
        ideal[:, :, 2] = (row[0] + row[1] * np.arange(len(up)))[:, None]
        if column[1] == 0 or row[1] == 0 or not np.allclose(rays, ideal, atol=1e-9):
            raise ValueError("rays must be those of a pinhole camera: (1, left, up), linear in column and row")
        rays.setflags(write=False)
        for name, value in (("rays", rays), ("column", column), ("row", row)):
            object.__setattr__(self, name, value)

    def __deepcopy__(self, memo: dict[int, Any]) -> DepthCamera:
        return self

    @classmethod
    def pinhole(cls, width: int, height: int, fov_rad: float, ahead_m: float) -> DepthCamera:
        """Camera of `width` x `height` square pixels, `fov_rad` wide, a ray through each pixel's centre."""
        pitch = 2.0 * math.tan(fov_rad / 2.0) / width
        rays = np.ones((height, width, 3))
        rays[:, :, 1] = ((width - 1) / 2.0 - np.arange(width)) * pitch
        rays[:, :, 2] = (((height - 1) / 2.0 - np.arange(height)) * pitch)[:, None]
        return cls(rays, ahead_m)
