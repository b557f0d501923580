"""The stack's answer to its collision flag: a short blind retreat, then a pause."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from scaloft_fi.stack.fields import Array
from scaloft_fi.stack.reference.messages import CollisionFlag, PoseEstimate


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

    speed_mps: float
    distance_m: float
    timeout_s: float
    pause_s: float
    refractory_s: float
    accel_mps2: float


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
