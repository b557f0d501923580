"""The mission: take off, fly the waypoints, come home, land.  The planner gets one waypoint at a time."""

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
        settled_m: take-off ends within this distance of the altitude [m].
        dwell_s: pause after take-off before the first waypoint [s].
    """

    goal_radius_m: float
    goal_axes: tuple[float, float, float]
    settled_m: float
    dwell_s: float


class Mission:
    """State machine of the mission.

    Attributes:
        home: position of take-off, at the altitude of the flight [m, world].
        phase: "takeoff", "fly" or "land".
        index: place in the route of the present waypoint.
    """

    def __init__(self, config: MissionConfig, home: Point) -> None:
        self.config = config
        self.home = home
        self.phase = "takeoff"
        self.index = 0
        self._route: tuple[Point, ...] = ()
        self._settled_s: float | None = None

    def plan(self, route: Route | None) -> None:
        """Replace the waypoints when a route arrives."""
        if route is not None:
            self._route = route.points

    def follow(self, failsafe: Failsafe | None) -> None:
        """Follow a request of the battery monitor, which ends the mission."""
        if failsafe is None:
            return
        if failsafe.action == "land":
            self.phase = "land"
        else:
            self._route, self.index = (self.home,), 0

    def climb(self, now_s: float, pose: PoseEstimate) -> None:
        """End the take-off when the altitude was held for `dwell_s`."""
        if self.phase != "takeoff" or abs(pose.position[2] - self.home[2]) > self.config.settled_m:
            return
        if self._settled_s is None:
            self._settled_s = now_s
        if now_s - self._settled_s >= self.config.dwell_s:
            self.phase = "fly"

    def check(self, pose: PoseEstimate) -> GoalCheck | None:
        """Input of the goal test for the present waypoint; None when there is none."""
        if self.phase != "fly" or self.index >= len(self._route):
            return None
        point = self._route[self.index]
        x, y, z = pose.position.tolist()
        vx, vy, _ = pose.velocity.tolist()
        dx, dy, dz = float(point[0] - x), float(point[1] - y), float(point[2] - z)
        distance_m = (dx * dx + dy * dy) ** 0.5
        closing_mps = (dx * vx + dy * vy) / distance_m if distance_m > 1e-6 else 0.0
        return GoalCheck(self.index, (dx, dy, dz), self.config.goal_axes, self.config.goal_radius_m, closing_mps)

    def advance(self, check: GoalCheck | None) -> None:
        """Go on to the next waypoint when `check` has the present one reached; after the last one, land."""
        if check is None or not check.reached:
            return
        self.index += 1
        if self.index >= len(self._route):
            self.phase = "land"

    def target(self) -> Target | None:
        """The waypoint for the planner; None when there is none."""
        if self.phase != "fly" or self.index >= len(self._route):
            return None
        return Target(self.index, self._route[self.index])
