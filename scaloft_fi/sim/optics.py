"""Plain data of rendering: the camera, the triangles of the scene, the rendered view."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Faces = NDArray[np.int64]
Segments = NDArray[np.int16]


@dataclass(frozen=True)
class Camera:
    """A pinhole camera that looks along body x.

    Attributes:
        width, height: size of the picture [pixels].
        fov_rad: horizontal angle of view [rad].
        ahead_m: distance of the camera from the vehicle's centre along body x [m].
    """

    width: int
    height: int
    fov_rad: float
    ahead_m: float

    @property
    def pitch(self) -> float:
        """Distance of neighbouring pixels at depth 1 m [m]."""
        return 2.0 * math.tan(0.5 * self.fov_rad) / self.width

    @property
    def rays(self) -> Array:
        """(H, W, 3) point of each pixel's ray at depth 1 m, (1, left, up) [m, body axes at the camera]."""
        rays = np.ones((self.height, self.width, 3))
        rays[:, :, 1] = (0.5 * self.width - 0.5 - np.arange(self.width)) * self.pitch
        rays[:, :, 2] = ((0.5 * self.height - 0.5 - np.arange(self.height)) * self.pitch)[:, None]
        return rays


@dataclass(frozen=True, eq=False)
class Scene:
    """All triangles of a world.

    Attributes:
        vertices: (V, 3) [m, world].
        faces: (F, 3) indices of vertices.
        owner: (F,) index of the body of each face.
        names: names of the bodies.
        reflectivity: (B,) reflectivity of the bodies, 0..1.
    """

    vertices: Array
    faces: Faces
    owner: Segments
    names: tuple[str, ...]
    reflectivity: Array


@dataclass(frozen=True, eq=False)
class View:
    """A rendered picture without sensor errors.

    Attributes:
        depth: (H, W) depth along the optical axis [m]; inf where no triangle is.
        segments: (H, W) index of the body in the names of the scene; -1 where no triangle is.
    """

    depth: Array
    segments: Segments
