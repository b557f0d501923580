"""The mission and what changes it: waypoints one at a time, the speed limit for people, the battery fail-safe."""

from __future__ import annotations

from dataclasses import dataclass

from scaloft_fi.marks import NotNegative, Positive, Share
from scaloft_fi.stack.messages import Battery, Detections, Person, Point
from scaloft_fi.stack.reference.messages import Failsafe, GoalCheck, PoseEstimate, Route, SpeedLimit, Target


@dataclass(frozen=True)
class SpeedLimitConfig:
    """The rule of the published mission script, with the distance of requirement SR2.

    Attributes:
        label: class of box that counts.
        min_score: least confidence that counts.
        max_range_m: farthest person that counts [m].
    """

    label: str
    min_score: Share
    max_range_m: Positive


class SpeedLimitStage:
    """Publishes the limit at the start, and the slow limit with every message that shows a person.

    Attributes:
        cruise_mps: limit without a person [m/s].
        slow_mps: limit from the first person on [m/s].
    """

    def __init__(self, config: SpeedLimitConfig, cruise_mps: float, slow_mps: float) -> None:
        self.config = config
        self.cruise_mps, self.slow_mps = cruise_mps, slow_mps
        self._published = False

    def update(self, now_s: float, detections: Detections | None) -> tuple[SpeedLimit | None, Person | None]:
        """The limit to publish at this tick, and the nearest person that counts; None for each that there is not."""
        person = self._nearest(detections) if detections is not None else None
        if person is not None:
            self._published = True
            return SpeedLimit(now_s, self.slow_mps, "euclidean"), person
        if not self._published:
            self._published = True
            return SpeedLimit(now_s, self.cruise_mps, "euclidean"), None
        return None, None

    def _nearest(self, detections: Detections) -> Person | None:
        config = self.config
        sure = [p for p in detections.persons if p.label == config.label and p.score >= config.min_score]
        near = [p for p in sure if p.range_m <= config.max_range_m]
        return min(near, key=lambda p: p.range_m, default=None)


@dataclass(frozen=True)
class BatteryConfig:
    """Thresholds of the battery monitor.

    Attributes:
        low_charge: state of charge at which to return (PX4 BAT_LOW_THR 0.15).  Where take-off has no more, the
            request comes before the route, which replaces it: the drone flies the whole mission.
        critical_charge: state of charge at which to land (PX4 BAT_CRIT_THR 0.07).  Where take-off has no more,
            the drone stays on the ground.
        empty_cell_v: voltage of an empty cell [V]; below it the pack counts as empty, whatever the gauge reads.
        lost_s: after this time without telemetry the pack counts as empty [s].
    """

    low_charge: Share
    critical_charge: Share
    empty_cell_v: NotNegative
    lost_s: NotNegative


class BatteryMonitor:
    """Watches the telemetry and requests each action once."""

    def __init__(self, config: BatteryConfig) -> None:
        self.config = config
        self._received_s = 0.0
        self._requested = ""

    def update(self, now_s: float, battery: Battery | None) -> Failsafe | None:
        """Process the telemetry of one tick; returns a new request to the mission, None when there is none."""
        config = self.config
        action = ""
        if battery is not None:
            self._received_s = now_s
            cell_v = battery.voltage_v / max(1, battery.cells)
            if cell_v < config.empty_cell_v or battery.charge <= config.critical_charge:
                action = "land"
            elif battery.charge <= config.low_charge:
                action = "return"
        elif now_s - self._received_s > config.lost_s:
            action = "land"
        if not action or action == self._requested or self._requested == "land":
            return None
        self._requested = action
        return Failsafe(now_s, action)


@dataclass(frozen=True)
class MissionConfig:
    """The mission script's constants.

    Attributes:
        goal_radius_m: a waypoint closer than this counts as reached [m]; published 0.15.
        goal_axes: which axes of the distance count (x, y, z); published: not z.
        settled_m: take-off ends within this distance of the altitude [m].
        dwell_s: pause after take-off before the first waypoint [s].
    """

    goal_radius_m: Positive
    goal_axes: tuple[Share, Share, Share]
    settled_m: Positive
    dwell_s: NotNegative


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
