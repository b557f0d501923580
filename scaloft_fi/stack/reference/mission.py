"""The mission: take off, fly the waypoints, come home, land.  It hands out one waypoint at a time."""

from __future__ import annotations

from dataclasses import dataclass

from scaloft_fi.stack.fields import Point
from scaloft_fi.stack.reference.messages import Failsafe, GoalCheck, PoseEstimate, Route, Target


@dataclass(frozen=True)
class MissionConfig:
    """The mission script's constants.

    Attributes:
        goal_radius_m: a waypoint closer than this counts as reached [m]; published 0.15.
        goal_axes: which axes of the distance count (x, y, z); published: not z.
        settled_m: take-off is over within this of the altitude [m].
        dwell_s: pause after take-off before the first waypoint [s].
    """

    goal_radius_m: float
    goal_axes: tuple[float, float, float]
    settled_m: float
    dwell_s: float


class Mission:
    """State machine of the mission.

    Attributes:
        home: where it takes off, at the height of flight [m, world].
        phase: "takeoff", "fly" or "land".
        index: place in the route of the waypoint flown to.
    """

    def __init__(self, config: MissionConfig, home: Point) -> None:
        self.config = config
        self.home = home
        self.phase = "takeoff"
        self.index = 0
        self._route: tuple[Point, ...] = ()
        self._settled_s: float | None = None

    def plan(self, route: Route | None) -> None:
        """Take the list of waypoints when it comes."""
        if route is not None:
            self._route = route.points

    def obey(self, failsafe: Failsafe | None) -> None:
        """Follow the battery monitor: give up the mission."""
        if failsafe is None:
            return
        if failsafe.action == "land":
            self.phase = "land"
        else:
            self._route, self.index = (self.home,), 0

    def climb(self, now_s: float, pose: PoseEstimate) -> None:
        """Leave the take-off once the altitude was held for the dwell."""
        if self.phase != "takeoff" or abs(pose.position[2] - self.home[2]) > self.config.settled_m:
            return
        if self._settled_s is None:
            self._settled_s = now_s
        if now_s - self._settled_s >= self.config.dwell_s:
            self.phase = "fly"

    def check(self, pose: PoseEstimate) -> GoalCheck | None:
        """The question whether the present waypoint is reached, if there is one."""
        if self.phase != "fly" or self.index >= len(self._route):
            return None
        point = self._route[self.index]
        x, y, z = pose.position.tolist()
        vx, vy, _ = pose.velocity.tolist()
        dx, dy, dz = float(point[0] - x), float(point[1] - y), float(point[2] - z)
        distance_m = (dx * dx + dy * dy) ** 0.5
        closing_mps = (dx * vx + dy * vy) / distance_m if distance_m > 1e-6 else 0.0
        return GoalCheck(self.index, (dx, dy, dz), self.config.goal_axes, self.config.goal_radius_m, closing_mps)

    def settle(self, check: GoalCheck | None) -> None:
        """Go on to the next waypoint when the answer is yes; after the last one, land."""
        if check is None or not check.reached:
            return
        self.index += 1
        if self.index >= len(self._route):
            self.phase = "land"

    def target(self) -> Target | None:
        """The waypoint for the planner; None when there is none to fly to."""
        if self.phase != "fly" or self.index >= len(self._route):
            return None
        return Target(self.index, self._route[self.index])
