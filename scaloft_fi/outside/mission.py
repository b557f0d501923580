"""The stages of the reference companion that take their orders from a mission outside."""

from __future__ import annotations

from scaloft_fi.outside.ports import Goal
from scaloft_fi.stack.messages import Detections, Person, Point
from scaloft_fi.stack.reference.messages import Failsafe, GoalCheck, PoseEstimate, Route, SpeedLimit, Target
from scaloft_fi.stack.reference.mission import Mission, SpeedLimitStage


class GoalMission(Mission):
    """The mission is outside: its newest goal is the planner's target, until it orders to land.

    Attributes:
        goal: the newest goal [m, world]; None before the first one, so the drone holds its place.
    """

    goal: Point | None = None
    _returns = False

    def fly_to(self, goal: Goal | None) -> None:
        """Take a goal, if one came; each goal at another place is another leg."""
        if goal is None or self._returns or goal.point == self.goal:
            return
        self.index += self.goal is not None
        self.goal = goal.point

    def land(self) -> None:
        """Follow the order to land here."""
        self.phase = "land"

    def plan(self, route: Route | None) -> None:
        """Take no route: the mission outside has its own."""

    def follow(self, failsafe: Failsafe | None) -> None:
        """Follow our battery monitor, which overrules the mission outside."""
        if failsafe is not None and failsafe.action == "land":
            self.land()
        elif failsafe is not None:
            self.goal, self._returns = self.home, True

    def check(self, pose: PoseEstimate) -> GoalCheck | None:
        """Return None: the mission outside tests itself whether a goal is reached."""
        return None

    def target(self) -> Target | None:
        """The newest goal, for the planner."""
        return Target(self.index, self.goal) if self.phase == "fly" and self.goal is not None else None


class TakenLimit(SpeedLimitStage):
    """The speed limit comes from outside; cruise speed holds until the first one comes."""

    newest: SpeedLimit | None = None

    def update(self, now_s: float, detections: Detections | None) -> tuple[SpeedLimit | None, Person | None]:
        """The limit that came at this tick; at the first tick cruise speed."""
        limit, self.newest = self.newest, None
        if limit is None and not self._published:
            limit = SpeedLimit(now_s, self.cruise_mps, "euclidean")
        self._published = True
        return limit, None
