"""The reference stack behind the contract `Stack`: estimator and flight control below, the companion computer above.

One call of `Companion.tick` runs its stages once, at 20 Hz, in the order of the data flow: perception, memory, mission
and planner, with time-outs for stale inputs.  Every edge between two stages crosses the wire.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from scaloft_fi.marks import Bounds, Count, NotNegative, Share
from scaloft_fi.stack.declaration import FastPath, Task, Wire
from scaloft_fi.stack.messages import Array, Bumper, DepthFrame, Exposure, Imu, Metering, SensorFrames, Stamps, Thrust
from scaloft_fi.stack.reference import messages as own
from scaloft_fi.stack.reference.estimator import Estimator, EstimatorConfig
from scaloft_fi.stack.reference.flight_control import ControlConfig, FailsafeConfig, FlightControl, MakeFlightControl
from scaloft_fi.stack.reference.memory import MemoryConfig, ObstacleMemory
from scaloft_fi.stack.reference.messages import (
    NOBODY_M,
    PoseEstimate,
    Proximity,
    Route,
    SpeedLimit,
    Target,
    VelocityCommand,
)
from scaloft_fi.stack.reference.mission import (
    BatteryConfig,
    BatteryMonitor,
    Mission,
    MissionConfig,
    SpeedLimitConfig,
    SpeedLimitStage,
)
from scaloft_fi.stack.reference.planner import (
    PUBLISHED,
    LocalPlan,
    NavigatorConfig,
    Planner,
    PlannerConfig,
    SpeedLaw,
    shape_velocity,
)
from scaloft_fi.stack.reference.proximity import ProximityConfig, ProximityMonitor, Recoil, RecoilConfig


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
        if stamp_s > after.stamp_s:
            return after._replace(stamp_s=stamp_s, position=after.position + (stamp_s - after.stamp_s) * after.velocity)
        for before in reversed(self._poses):
            if before.stamp_s <= stamp_s:
                return before if before is after else _between(before, after, stamp_s)
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
    attitude /= float(attitude @ attitude) ** 0.5
    position = before.position + share * (after.position - before.position)
    velocity = before.velocity + share * (after.velocity - before.velocity)
    return PoseEstimate(stamp_s, position, velocity, before.yaw_rad + share * turned, attitude)


@dataclass(frozen=True)
class ExposureConfig:
    """Settings of the exposure loop.

    Attributes:
        gain: share of the metered error corrected per tick.
        limit_ev: the loop stays within +- this [EV].
        gain_from_ev: above this the sensor gain doubles with every EV.
    """

    gain: Share
    limit_ev: Annotated[float, Bounds(least=0.0, most=100.0)]
    gain_from_ev: Annotated[float, Bounds(least=-100.0, most=100.0)]


class ExposureControl:
    """An integrating loop on the light meter's error."""

    def __init__(self, config: ExposureConfig) -> None:
        self.config = config
        self._ev = 0.0

    def meter(self, metering: Metering | None) -> Exposure:
        """The order to the camera; without a message of the light meter the order stays."""
        config = self.config
        if metering is not None:
            self._ev = min(config.limit_ev, max(-config.limit_ev, self._ev + config.gain * metering.error_ev))
        return Exposure(self._ev, 2.0 ** max(0.0, self._ev - config.gain_from_ev), 0.0)


@dataclass(frozen=True)
class CompanionConfig:
    """Time-outs and rates of the companion computer.

    Attributes:
        depth_hover_s: depth older than this: hover (PX4-Avoidance timeout_critical 0.5 s).
        depth_land_s: depth older than this: land (PX4-Avoidance timeout_termination 15 s).
        pose_hover_s: pose older than this: hover.
        pose_span_s: how long poses are kept, for late frames [s].
        pose_reach_s: how far poses are extrapolated, for frames with a stamp in the future [s].
        plan_every: ticks from plan to plan (2 = 10 Hz).
        hover_p: gain that holds the position of a hover [1/s].
        told_s: how long a person counts as reported after each message [s].
    """

    depth_hover_s: NotNegative
    depth_land_s: NotNegative
    pose_hover_s: NotNegative
    pose_span_s: NotNegative
    pose_reach_s: NotNegative
    plan_every: Count
    hover_p: NotNegative
    told_s: NotNegative


@dataclass(frozen=True)
class Stages:
    """The stages that a companion runs."""

    memory: ObstacleMemory
    proximity: ProximityMonitor
    speed_limit: SpeedLimitStage
    exposure: ExposureControl
    battery: BatteryMonitor
    mission: Mission
    planner: Planner
    recoil: Recoil
    speed_law: SpeedLaw | None = None


class Companion:
    """Runs the stages; its public attributes are its beliefs.

    Attributes:
        exposure: last order to the colour camera.
        limit: speed limit in force.
        told_until_s, told_range_m: until when a person counts as reported, and the person's range.
        flagged: whether the collision flag arrived at this tick.
        map_points: occupied cells in the planner's last map.
        order: last velocity command that flight control received.
    """

    def __init__(self, config: CompanionConfig, stages: Stages, wire: Wire, route: Route, yaw_rad: float) -> None:
        self.config = config
        self.stages = stages
        self.exposure = Exposure(0.0, 1.0, 0.0)
        self.limit = SpeedLimit(0.0, stages.speed_limit.cruise_mps, "euclidean")
        self.told_until_s, self.told_range_m = -1.0, math.inf
        self.flagged = False
        self.map_points = 0
        self.order: VelocityCommand | None = None
        self._wire = wire
        self._route: Route | None = route
        self._poses = PoseBuffer(config.pose_span_s, config.pose_reach_s)
        self._pose_s = self._depth_s = 0.0
        self._plan: LocalPlan | None = None
        self._target: Target | None = None
        self._hover: Array | None = None
        self._yaw_rad = yaw_rad
        self._ticks = 0

    def tick(self, now_s: float, frames: SensorFrames, pose: PoseEstimate, control: FlightControl) -> None:
        """Run every stage once."""
        cross = self._wire.cross
        delivered_pose = cross("pose", now_s, pose)
        if delivered_pose is not None:
            self._poses.add(delivered_pose)
            self._pose_s = now_s
        self._see(now_s, frames)
        self._look_for_people(now_s, frames)
        order = cross("exposure", now_s, self.stages.exposure.meter(cross("metering", now_s, frames.metering)))
        if order is not None:
            self.exposure = order

        mission = self.stages.mission
        telemetry = cross("battery", now_s, frames.battery)
        mission.follow(cross("failsafe", now_s, self.stages.battery.update(now_s, telemetry)))
        mission.plan(cross("route", now_s, self._route))
        self._route = None
        believed = self._poses.newest
        if believed is None:
            return
        mission.climb(now_s, believed)
        mission.advance(cross("goal", now_s, mission.check(believed)))
        self._target = cross("target", now_s, mission.target())
        self._replan(now_s, believed)
        if mission.phase == "land" or now_s - self._depth_s > self.config.depth_land_s:
            control.land(self.limit.limit_mps)
        delivered = cross("velcmd", now_s, self._command(now_s, believed) if mission.phase == "fly" else None)
        if delivered is not None:
            self.order = delivered
            recoiling = self.stages.recoil.order(now_s, believed, self.limit.limit_mps) is not None
            limits: RecoilConfig | ControlConfig = self.stages.recoil.config if recoiling else control.config
            control.command(now_s, delivered, limits.accel_mps2)

    def _see(self, now_s: float, frames: SensorFrames) -> None:
        """Feed depth image and bumper into memory and proximity monitor."""
        cross, stages = self._wire.cross, self.stages
        frame, pose, clearing = cross("depth", now_s, frames.depth), None, None
        bumper = cross("bumper", now_s, frames.bumper)
        # a frame whose stamp is too old or too far in the future is not used
        if frame is not None and -self.config.pose_reach_s <= now_s - frame.stamp_s <= self.config.depth_hover_s:
            pose = self._poses.at(frame.stamp_s)
        if frame is not None and pose is not None:
            self._depth_s = frame.stamp_s
            clearing = stages.memory.observe(frame, pose)
        stages.memory.update(cross("clearing", now_s, clearing))
        flying = stages.mission.phase == "fly"
        proximity = cross("proximity", now_s, self._near(frame, pose, bumper) if flying else None)
        flag = cross("collision", now_s, stages.proximity.flag(now_s, proximity))
        self.flagged = flag is not None
        believed = self._poses.newest
        if believed is not None and flying:
            stages.recoil.trigger(now_s, flag, believed)

    def _near(self, frame: DepthFrame | None, pose: PoseEstimate | None, bumper: Bumper | None) -> Proximity | None:
        """Input of the proximity monitor: the frame's sectors joined with the touch sensor."""
        touched = bumper is not None and bumper.hull
        if frame is not None and pose is not None:
            return self.stages.proximity.sectors(frame, pose, touched=touched)
        return self.stages.proximity.blind(bumper.stamp_s, touched=True) if bumper is not None and touched else None

    def _look_for_people(self, now_s: float, frames: SensorFrames) -> None:
        limit, person = self.stages.speed_limit.update(now_s, self._wire.cross("person", now_s, frames.detections))
        if person is not None:
            self.told_until_s, self.told_range_m = now_s + self.config.told_s, person.range_m
        delivered = self._wire.cross("speedlimit", now_s, limit)
        if delivered is not None:
            self.limit = delivered

    def _replan(self, now_s: float, pose: PoseEstimate) -> None:
        due = self._ticks % self.config.plan_every == 0
        self._ticks += 1
        sent = self.stages.memory.map(pose) if due and self._target is not None else None
        obstacles = self._wire.cross("map", now_s, sent)
        if self._target is None:
            self._plan = None
        elif obstacles is not None:
            self.map_points = len(obstacles.points)
            plan = self.stages.planner.plan(obstacles, self._target.point, pose)
            if not (isinstance(plan, LocalPlan) and math.isfinite(sum(plan.direction))):
                raise ValueError(f"the planner returns {plan!r}, not a LocalPlan with a finite direction")
            self._plan = plan
            if self.stages.speed_law is not None:
                self.stages.speed_law.look(obstacles, self._plan, pose)
        elif self._plan is None:
            self.map_points = 0

    def _command(self, now_s: float, pose: PoseEstimate) -> VelocityCommand:
        retreat = self.stages.recoil.order(now_s, pose, self.limit.limit_mps)
        law = self.stages.speed_law
        if retreat is not None:
            if law is not None:
                law.rest()
            self._yaw_rad = retreat[1]
            return VelocityCommand(now_s, *retreat)
        stale = now_s - self._depth_s > self.config.depth_hover_s or now_s - self._pose_s > self.config.pose_hover_s
        if stale or self._plan is None or self._target is None:
            if law is not None:
                law.rest()
            return self._hover_order(now_s, pose)
        self._hover = None
        if law is None:
            velocity, self._yaw_rad = shape_velocity(self._plan, pose, self.limit, self.stages.planner.config)
        else:
            velocity, self._yaw_rad = law.order(self._plan, self._target.point, pose, self.limit)
        return VelocityCommand(now_s, velocity, self._yaw_rad)

    def _hover_order(self, now_s: float, pose: PoseEstimate) -> VelocityCommand:
        """The command that holds the position at which the hover began."""
        if self._hover is None:
            self._hover = pose.position.copy()
        back = self.config.hover_p * (self._hover - pose.position)
        speed = float(np.linalg.norm(back))
        if speed > self.limit.limit_mps:
            back *= self.limit.limit_mps / speed
        return VelocityCommand(now_s, back, self._yaw_rad)

    def beliefs(self, now_s: float) -> tuple[float, ...]:
        """The companion's beliefs: person reported, its range, speed limit, flag, leg, map points, command (4)."""
        reported = now_s <= self.told_until_s
        order = self.order
        command = (0.0, 0.0, 0.0, 0.0) if order is None else (*order.velocity.tolist(), order.yaw_rad)
        person = (float(reported), self.told_range_m if reported else NOBODY_M, self.limit.limit_mps)
        return (*person, float(self.flagged), float(self.stages.mission.index), float(self.map_points), *command)


@dataclass(frozen=True)
class ReferenceConfig:
    """All settings of the reference stack, as in `sim/stack.yaml`."""

    estimator: EstimatorConfig
    control: ControlConfig
    failsafe: FailsafeConfig
    companion: CompanionConfig
    memory: MemoryConfig
    planner: PlannerConfig
    proximity: ProximityConfig
    mission: MissionConfig
    speed_limit: SpeedLimitConfig
    recoil: RecoilConfig
    exposure: ExposureConfig
    battery: BatteryConfig
    navigator: NavigatorConfig | None = None


class ReferenceStack:
    """Estimator and flight control below, companion computer above.

    Attributes:
        planner_kind: class of the planner; a stack with another planner derives from this one and names it here.
        fast_path: `step`, compiled, for steps in which the wire listens on neither `imu` nor `thrust`.
    """

    planner_kind: type[Planner] = Planner

    def __init__(self, task: Task, wire: Wire, flight_control: MakeFlightControl = FlightControl) -> None:
        config: ReferenceConfig = task.settings
        self._wire = wire
        self._estimator = Estimator(config.estimator, np.array(task.home), task.yaw_rad)
        self._control = flight_control(config.control, config.failsafe, self._estimator, task.yaw_rad)
        self._companion = Companion(
            config.companion,
            Stages(
                ObstacleMemory(config.memory, task.camera),
                ProximityMonitor(config.proximity, task.camera),
                SpeedLimitStage(config.speed_limit, task.cruise_mps, task.slow_mps),
                ExposureControl(config.exposure),
                BatteryMonitor(config.battery),
                Mission(config.mission, (task.home[0], task.home[1], task.altitude_m)),
                self.planner_kind(config.planner),
                Recoil(config.recoil),
                SpeedLaw(config.navigator) if config.navigator and config.navigator.law == PUBLISHED else None,
            ),
            wire,
            Route(task.route),
            task.yaw_rad,
        )
        self._control.take_off(task.altitude_m)
        self.fast_path: FastPath | None = self._control.fast_path
        self._pose = self._estimator.tick(0.0, None)
        self._last_stamps = Stamps(0.0, 0.0, 0.0)

    @property
    def exposure(self) -> Exposure:
        """The order in force for the colour camera."""
        return self._companion.exposure

    def stamps(self, now_s: float) -> Stamps:
        """Read the sensors' clocks; clocks without a new reading keep the last one."""
        self._last_stamps = self._wire.cross("stamps", now_s, Stamps(now_s, now_s, now_s)) or self._last_stamps
        return self._last_stamps

    def autopilot(self, now_s: float, frames: SensorFrames) -> None:
        """Correct the estimate and check flight control's time-outs."""
        self._pose = self._estimator.tick(now_s, self._wire.cross("fix", now_s, frames.fix))
        self._control.watch(now_s)
        self._control.deliver(now_s, frames)

    def companion(self, now_s: float, frames: SensorFrames) -> None:
        """Run the companion's stages on the estimate of this tick."""
        self._companion.tick(now_s, frames, self._pose, self._control)

    def step(self, now_s: float, imu: Imu) -> Thrust | None:
        """One step of flight control."""
        cross = self._wire.cross
        return cross("thrust", now_s, self._control.step(now_s, cross("imu", now_s, imu), imu))

    def close(self) -> None:
        """End flight control."""
        self._control.close()

    def beliefs(self, now_s: float) -> Array:
        """The values of the declared beliefs."""
        mode = float(own.MODES.index(self._control.mode))
        return np.array((*self._companion.beliefs(now_s), *self._estimator.state[:6].tolist(), mode))


def call_kernels(task: Task) -> None:
    """Call the kernels that see and plan, with an empty picture."""
    config: ReferenceConfig = task.settings
    nothing = np.zeros(3)
    frame = DepthFrame(0.0, np.zeros(task.camera.rays.shape[:2]))
    pose = PoseEstimate(0.0, nothing, nothing, 0.0, np.array([0.0, 0.0, 0.0, 1.0]))
    memory = ObstacleMemory(config.memory, task.camera)
    memory.update(memory.observe(frame, pose))
    ProximityMonitor(config.proximity, task.camera).sectors(frame, pose)
    Planner(config.planner).plan(memory.map(pose), (2.0 * config.planner.straight_in_m, 0.0, 0.0), pose)
