"""The stack's own collision flag, from depth image and bumper, and its answer: a short blind retreat, a pause."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from scaloft_fi.marks import Count, NotNegative, Positive
from scaloft_fi.stack.kernel import jit
from scaloft_fi.stack.messages import Array, DepthCamera, DepthFrame
from scaloft_fi.stack.reference.messages import CollisionFlag, PoseEstimate, Proximity


@dataclass(frozen=True)
class ProximityConfig:
    """Settings of the proximity monitor.

    Attributes:
        sectors: how many equal bearing sectors share the camera's view.
        trigger_m: horizontal range from the vehicle's centre that raises the flag [m]; the hull's side is at 0.235 m
            and the camera is blind nearer than 0.4 m.
        band_m: half height of the band around the flight level that is watched [m]: half the hull and 0.1 m.
        min_pixels: pixels of a sector that must be in the band; the sector's range is that of the min_pixels-nearest.
    """

    sectors: Count
    trigger_m: Positive
    band_m: Positive
    min_pixels: Count


class ProximityMonitor:
    """Measures the least range of each bearing sector and raises the flag; it has no memory between frames."""

    def __init__(self, config: ProximityConfig, camera: DepthCamera) -> None:
        bearing = np.arctan(camera.rays[0, :, 1])
        half = float(np.abs(bearing).max()) + 1e-9
        width = 2.0 * half / config.sectors
        self.config, self.camera = config, camera
        self._sector_of_column = ((half - bearing) / width).astype(np.int64)
        self._bearings = (half - (np.arange(config.sectors) + 0.5) * width).astype(np.float64)
        self._watched = np.ones(config.sectors, np.bool_)
        self._left, self._up = np.ascontiguousarray(camera.rays[0, :, 1]), np.ascontiguousarray(camera.rays[:, 0, 2])
        for array in (self._sector_of_column, self._bearings, self._watched):
            array.setflags(write=False)

    def sectors(self, frame: DepthFrame, pose: PoseEstimate, *, touched: bool = False) -> Proximity:
        """Least range in each sector of `frame`, taken from `pose`, beside what the touch sensor says."""
        c, camera = self.config, self.camera
        least = _least(
            np.ascontiguousarray(frame.depth), self._left, self._up, camera.ahead_m, pose.attitude,
            self._sector_of_column, c.sectors, c.band_m, c.min_pixels,
        )  # fmt: skip
        return Proximity(frame.stamp_s, least, self._watched, self._bearings, c.trigger_m, touched)

    def blind(self, stamp_s: float, *, touched: bool) -> Proximity:
        """Input of the monitor at a tick without a depth image."""
        nothing = np.full(self.config.sectors, np.inf)
        return Proximity(stamp_s, nothing, self._watched, self._bearings, self.config.trigger_m, touched)

    def flag(self, now_s: float, proximity: Proximity | None) -> CollisionFlag | None:
        """The flag that `proximity` raises.

        Its bearing is that of the nearest triggered sector.  After a touch without a triggered sector it is that of the
        nearest sector that sees something, or straight ahead.
        """
        if proximity is None:
            return None
        ranges = proximity.sectors.tolist()
        if not proximity.touched and min(ranges) >= proximity.trigger_m:
            return None
        ranges = [r if w else math.inf for r, w in zip(ranges, proximity.watched.tolist(), strict=True)]
        near = [r for r in ranges if r < proximity.trigger_m]
        if not near:
            if not proximity.touched:
                return None
            near = [r for r in ranges if math.isfinite(r)]
            if not near:
                return CollisionFlag(now_s, 0.0)
        return CollisionFlag(now_s, float(proximity.bearings[ranges.index(min(near))]))


@jit
def _least(depth, lefts, ups, ahead_m, attitude, sector_of_column, sectors, band_m, min_pixels):  # type: ignore[no-untyped-def]
    """Horizontal range of the min_pixels-nearest pixel of each sector within the band, inf where there are fewer."""
    x, y, z, w = attitude[0], attitude[1], attitude[2], attitude[3]
    up_x, up_y, up_z = 2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)
    nearest = np.full((sectors, min_pixels), np.inf)
    square, within = np.empty(len(lefts)), np.empty(len(lefts), np.bool_)
    for r in range(len(ups)):
        line = depth[r]
        for k in range(len(lefts)):  # a loop without branches, which is vectorised
            d = line[k]
            left, up = lefts[k] * d, ups[r] * d
            rise = up_x * (ahead_m + d) + up_y * left + up_z * up
            within[k] = (d > 0.0) & (abs(rise) <= band_m)
            square[k] = (ahead_m + d) ** 2 + left * left + up * up - rise * rise
        for k in range(len(lefts)):
            if not within[k]:
                continue
            s = sector_of_column[k]
            i = min_pixels
            while i > 0 and square[k] < nearest[s, i - 1]:
                if i < min_pixels:
                    nearest[s, i] = nearest[s, i - 1]
                i -= 1
            if i < min_pixels:
                nearest[s, i] = square[k]
    return np.sqrt(nearest[:, min_pixels - 1])


@dataclass(frozen=True)
class RecoilConfig:
    """Settings of the retreat.

    Attributes:
        speed_mps: speed of the retreat, capped by the speed limit [m/s].
        distance_m: greatest length of the retreat [m].
        timeout_s: greatest duration of the retreat [s].
        pause_s: duration of the hover after it [s].
        refractory_s: how long flags are ignored after the pause [s].
        accel_mps2: greatest change of velocity while retreating [m/s2].
    """

    speed_mps: NotNegative
    distance_m: NotNegative
    timeout_s: NotNegative
    pause_s: NotNegative
    refractory_s: NotNegative
    accel_mps2: Positive


class Recoil:
    """Backs off from the obstacle that the flag reports; nothing watches the way back."""

    def __init__(self, config: RecoilConfig) -> None:
        self.config = config
        self._away = np.zeros(3)
        self._start = np.zeros(3)
        self._until_s = self._pause_until_s = self._ignore_until_s = -1.0
        self._yaw_rad = 0.0

    def trigger(self, now_s: float, flag: CollisionFlag | None, pose: PoseEstimate) -> None:
        """Begin a retreat if the flag is raised and flags are not ignored."""
        if flag is None or now_s < self._ignore_until_s:
            return
        bearing_rad = pose.yaw_rad + flag.bearing_rad
        self._away[:] = -math.cos(bearing_rad), -math.sin(bearing_rad), 0.0
        self._start[:] = pose.position
        self._yaw_rad = pose.yaw_rad
        self._until_s = now_s + self.config.timeout_s
        self._pause_until_s = self._until_s + self.config.pause_s
        self._ignore_until_s = self._pause_until_s + self.config.refractory_s

    def order(self, now_s: float, pose: PoseEstimate, limit_mps: float) -> tuple[Array, float] | None:
        """Velocity [m/s, world] and heading [rad] of the retreat or the pause; None when neither is under way."""
        if now_s >= self._pause_until_s:
            return None
        if now_s < self._until_s:
            moved = pose.position - self._start
            if float(moved[0] * self._away[0] + moved[1] * self._away[1]) < self.config.distance_m:
                return self._away * min(self.config.speed_mps, limit_mps), self._yaw_rad
            self._until_s = now_s
            self._pause_until_s = now_s + self.config.pause_s
            self._ignore_until_s = self._pause_until_s + self.config.refractory_s
        return np.zeros(3), self._yaw_rad
