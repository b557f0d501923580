"""What the stack does when its collision flag is raised: a short blind retreat, then a pause."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from scaloft_fi.stack.fields import Array
from scaloft_fi.stack.reference.messages import CollisionFlag, PoseEstimate


@dataclass(frozen=True)
class RecoilConfig:
    """The retreat.

    Attributes:
        speed_mps: speed of the retreat, capped by the speed limit [m/s].
        distance_m: how far [m]. timeout_s: or how long [s].
        pause_s: hover after it [s].
        refractory_s: flags are ignored for so long after the pause [s].
        accel_mps2: greatest change of velocity while retreating [m/s2].
    """

    speed_mps: float
    distance_m: float
    timeout_s: float
    pause_s: float
    refractory_s: float
    accel_mps2: float


class Recoil:
    """Backs off, away from where the flag says the obstacle is; nothing watches the way back."""

    def __init__(self, config: RecoilConfig) -> None:
        self.config = config
        self._away = np.zeros(3)
        self._start = np.zeros(3)
        self._until_s = self._pause_until_s = self._deaf_until_s = -1.0
        self._yaw_rad = 0.0

    def hear(self, now_s: float, flag: CollisionFlag | None, pose: PoseEstimate) -> None:
        """Begin a retreat if the flag is raised and none is under way."""
        if flag is None or now_s < self._deaf_until_s:
            return
        bearing_rad = pose.yaw_rad + flag.bearing_rad
        self._away[:] = -math.cos(bearing_rad), -math.sin(bearing_rad), 0.0
        self._start[:] = pose.position
        self._yaw_rad = pose.yaw_rad
        self._until_s = now_s + self.config.timeout_s
        self._pause_until_s = self._until_s + self.config.pause_s
        self._deaf_until_s = self._pause_until_s + self.config.refractory_s

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
            self._deaf_until_s = self._pause_until_s + self.config.refractory_s
        return np.zeros(3), self._yaw_rad
