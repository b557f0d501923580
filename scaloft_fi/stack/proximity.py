"""Proximity monitor: the stack's own collision flag, from the depth image and the bumper."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from scaloft_fi.stack.camera import DepthCamera
from scaloft_fi.stack.kernel import jit
from scaloft_fi.stack.messages import Bumper, CollisionFlag, DepthFrame, PoseEstimate, Proximity


class ProximityConfig(NamedTuple):
    """Settings of the proximity monitor.

    Attributes:
        sectors: how many equal bearing sectors share the camera's view.
        trigger_m: horizontal range from the vehicle's centre that raises the flag [m]; the hull's side is at 0.235 m
            and the camera is blind nearer than 0.4 m.
        band_m: half height of the band around the flight level that is watched [m]: half the hull and 0.1 m.
        min_pixels: pixels of a sector that must be in the band to count; its range is that of the min_pixels-nearest.
    """

    sectors: int = 8
    trigger_m: float = 0.45
    band_m: float = 0.155
    min_pixels: int = 3


class ProximityMonitor:
    """Least range per bearing sector, and the flag it raises; keeps nothing between frames."""

    def __init__(self, config: ProximityConfig, camera: DepthCamera) -> None:
        slope = np.arctan(camera.rays[0, :, 1])
        half = np.abs(slope).max() * (1.0 + 1e-9)
        self.config, self.camera = config, camera
        self._width = 2.0 * half / config.sectors
        self._bearings = half - (np.arange(config.sectors) + 0.5) * self._width
        self._watched = np.ones(config.sectors, np.bool_)
        for array in (self._bearings, self._watched):
            array.setflags(write=False)

    def sectors(
        self, stamp_s: float, frame: DepthFrame | None, pose: PoseEstimate | None, bumper: Bumper | None
    ) -> Proximity:
        """Least range in each sector of `frame` (None: nothing seen), joined with the hull's touch sensor.

        Raises:
            ValueError: a frame came without the pose from which it was taken.
        """
        c = self.config
        if frame is None:
            least = np.full(c.sectors, np.inf)
        elif pose is None:
            raise ValueError("a depth frame needs the pose from which it was taken")
        else:
            least = _least(
                frame.depth, self.camera.rays, self.camera.ahead_m, pose.attitude,
                c.sectors, self._width, c.band_m, c.min_pixels,
            )  # fmt: skip
        touched = bumper is not None and bumper.hull
        return Proximity(stamp_s, least, self._watched, self._bearings, c.trigger_m, touched)


def flag(proximity: Proximity) -> CollisionFlag | None:
    """The flag raised by `proximity`: bearing of the nearest triggered sector; of a mere touch, of the nearest seen."""
    near = (proximity.sectors < proximity.trigger_m) & proximity.watched
    if not near.any():
        if not proximity.touched:
            return None
        near = np.isfinite(proximity.sectors) & proximity.watched
        if not near.any():
            return CollisionFlag(proximity.stamp_s, 0.0)
    nearest = int(np.argmin(np.where(near, proximity.sectors, math.inf)))
    return CollisionFlag(proximity.stamp_s, float(proximity.bearings[nearest]))


@jit
def _least(depth, rays, ahead_m, attitude, sectors, width, band_m, min_pixels):  # type: ignore[no-untyped-def]
    """Range of the min_pixels-nearest pixel of each sector within the band, inf where there are fewer."""
    x, y, z, w = attitude[0], attitude[1], attitude[2], attitude[3]
    up_x, up_y, up_z = 2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)
    nearest = np.full((sectors, min_pixels), np.inf)
    for r in range(depth.shape[0]):
        for k in range(depth.shape[1]):
            d = depth[r, k]
            if not d > 0.0:
                continue
            forward, left, up = ahead_m + d, rays[r, k, 1] * d, rays[r, k, 2] * d
            rise = up_x * forward + up_y * left + up_z * up
            if abs(rise) > band_m:
                continue
            reach = math.sqrt(max(forward * forward + left * left + up * up - rise * rise, 0.0))
            bearing = math.atan2(rays[r, k, 1], 1.0)
            s = min(max(int((0.5 * sectors * width - bearing) / width), 0), sectors - 1)
            i = min_pixels
            while i > 0 and reach < nearest[s, i - 1]:
                if i < min_pixels:
                    nearest[s, i] = nearest[s, i - 1]
                i -= 1
            if i < min_pixels:
                nearest[s, i] = reach
    return nearest[:, min_pixels - 1].copy()
