"""Recent poses as the companion received them, looked up by time stamp."""

from __future__ import annotations

import math
from collections import deque

from scaloft_fi.stack.reference.messages import PoseEstimate


class PoseBuffer:
    """Poses of the last `span_s` seconds; interpolates between them, extrapolates up to `reach_s` past the newest."""

    def __init__(self, span_s: float, reach_s: float) -> None:
        self.span_s, self.reach_s = span_s, reach_s
        self._poses: deque[PoseEstimate] = deque()

    def add(self, pose: PoseEstimate) -> None:
        """Add a pose; a pose that is not newer than the last one is dropped, as in transform buffers."""
        if self._poses and pose.stamp_s <= self._poses[-1].stamp_s:
            return
        self._poses.append(pose)
        while pose.stamp_s - self._poses[0].stamp_s > self.span_s:
            self._poses.popleft()

    @property
    def newest(self) -> PoseEstimate | None:
        """The pose that was added last."""
        return self._poses[-1] if self._poses else None

    def at(self, stamp_s: float) -> PoseEstimate | None:
        """The pose at `stamp_s`; None when that is older than the buffer or beyond its reach."""
        if not self._poses or stamp_s < self._poses[0].stamp_s or stamp_s > self._poses[-1].stamp_s + self.reach_s:
            return None
        after = self._poses[-1]
        if stamp_s >= after.stamp_s:
            ahead_s = stamp_s - after.stamp_s
            return (
                after
                if ahead_s == 0.0
                else after._replace(stamp_s=stamp_s, position=after.position + ahead_s * after.velocity)
            )
        for before in reversed(self._poses):
            if before.stamp_s <= stamp_s:
                return _between(before, after, stamp_s)
            after = before
        return None


def _between(before: PoseEstimate, after: PoseEstimate, stamp_s: float) -> PoseEstimate:
    share = (stamp_s - before.stamp_s) / (after.stamp_s - before.stamp_s)
    if share < 1e-9:
        return before
    turned = math.remainder(after.yaw_rad - before.yaw_rad, 2.0 * math.pi)
    # Neighbours are 50 ms apart, so a normalised blend of the quaternions is within 1e-4 rad of the great circle.
    sign = 1.0 if float(before.attitude @ after.attitude) >= 0.0 else -1.0
    attitude = (1.0 - share) * before.attitude + share * sign * after.attitude
    return PoseEstimate(
        stamp_s,
        before.position + share * (after.position - before.position),
        before.velocity + share * (after.velocity - before.velocity),
        before.yaw_rad + share * turned,
        attitude / float(attitude @ attitude) ** 0.5,
    )
