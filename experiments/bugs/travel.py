"""A companion whose velocity on the way along a plan is made in a method of its own, for bugs that stand there."""

from __future__ import annotations

from scaloft_fi.stack.messages import Array
from scaloft_fi.stack.reference.companion import Companion
from scaloft_fi.stack.reference.messages import PoseEstimate, VelocityCommand
from scaloft_fi.stack.reference.planner import LocalPlan, shape_velocity


class Travel(Companion):
    """The reference companion; `shaped` says how fast it follows a plan."""

    def shaped(self, plan: LocalPlan, pose: PoseEstimate) -> tuple[Array, float]:
        """Velocity (3,) [m/s, world] and heading [rad, world] to follow `plan`."""
        return shape_velocity(plan, pose, self.limit, self.stages.planner.config)

    def _command(self, now_s: float, pose: PoseEstimate) -> VelocityCommand:
        retreat = self.stages.recoil.order(now_s, pose, self.limit.limit_mps)
        if retreat is not None:
            self._yaw_rad = retreat[1]
            return VelocityCommand(now_s, *retreat)
        stale = now_s - self._depth_s > self.config.depth_hover_s or now_s - self._pose_s > self.config.pose_hover_s
        if stale or self._plan is None or self._target is None:
            return self._hover_order(now_s, pose)
        self._hover = None
        velocity, self._yaw_rad = self.shaped(self._plan, pose)
        return VelocityCommand(now_s, velocity, self._yaw_rad)
