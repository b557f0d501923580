"""Real bugs of flight software, each written into a copy of the reference stack as its fix shows it.

A copy is the reference stack with one exchanged stage; without the defect it is the reference stack, bit for bit.
What was wrong, the fix and how it stands in the copy are told in `results/published/bugs.md`.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from scaloft_fi.sim.load import SimConfig
from scaloft_fi.sim.stacks import STACKS, declare_stack
from scaloft_fi.stack.declaration import TICK_HZ, Declaration, Stack, Task, Wire
from scaloft_fi.stack.messages import Array, DepthFrame, Detections, Imu, SensorFrames
from scaloft_fi.stack.reference import estimator, memory
from scaloft_fi.stack.reference.declaration import REFERENCE
from scaloft_fi.stack.reference.estimator import RATE_BIAS, Estimator, EstimatorConfig
from scaloft_fi.stack.reference.flight_control import FlightControl
from scaloft_fi.stack.reference.memory import ObstacleMemory
from scaloft_fi.stack.reference.messages import Clearing, GoalCheck, PoseEstimate, Proximity, Route, VelocityCommand
from scaloft_fi.stack.reference.mission import BatteryMonitor, Mission, SpeedLimitStage
from scaloft_fi.stack.reference.planner import LocalPlan, Planner, shape_velocity
from scaloft_fi.stack.reference.proximity import ProximityMonitor, Recoil
from scaloft_fi.stack.reference.stack import (
    Companion,
    CompanionConfig,
    ExposureControl,
    PoseBuffer,
    ReferenceConfig,
    ReferenceStack,
    Stages,
)
from scaloft_fi.study import Study


class Receiver:
    """The stage that takes messages off the sensors' links; this one hands them on as they are."""

    def receive(self, frames: SensorFrames) -> SensorFrames:
        """The messages of a tick as the other stages get them; called once a tick."""
        return frames


@dataclass(frozen=True)
class Parts:
    """The classes of the stages.

    Attributes:
        receiver, estimator, memory, proximity, mission, companion: class of each stage.
        compiled: whether the 240 Hz part may run compiled; not where a defect stands in the Python code of that part.
    """

    receiver: type[Receiver] = Receiver
    estimator: type[Estimator] = Estimator
    memory: type[ObstacleMemory] = ObstacleMemory
    proximity: type[ProximityMonitor] = ProximityMonitor
    mission: type[Mission] = Mission
    companion: type[Companion] = Companion
    compiled: bool = True


class StagedStack(ReferenceStack):
    """The reference stack, built from the stages that `parts` names."""

    def __init__(self, task: Task, wire: Wire, parts: Parts) -> None:
        super().__init__(task, wire)
        config: ReferenceConfig = task.settings
        self._receiver = parts.receiver()
        self._estimator = parts.estimator(config.estimator, np.array(task.home), task.yaw_rad)
        self._control = FlightControl(config.control, config.failsafe, self._estimator, task.yaw_rad)
        self._companion = parts.companion(
            config.companion,
            Stages(
                parts.memory(config.memory, task.camera),
                parts.proximity(config.proximity, task.camera),
                SpeedLimitStage(config.speed_limit, task.cruise_mps, task.slow_mps),
                ExposureControl(config.exposure),
                BatteryMonitor(config.battery),
                parts.mission(config.mission, (task.home[0], task.home[1], task.altitude_m)),
                Planner(config.planner),
                Recoil(config.recoil),
            ),
            wire,
            Route(task.route),
            task.yaw_rad,
        )
        self._control.take_off(task.altitude_m)
        self.fast_path = self._control if parts.compiled else None
        self._pose = self._estimator.tick(0.0, None)
        self._received: SensorFrames | None = None

    def autopilot(self, now_s: float, frames: SensorFrames) -> None:
        """Receive the messages of the tick; then as the reference stack."""
        self._received = self._receiver.receive(frames)
        super().autopilot(now_s, self._received)

    def companion(self, now_s: float, frames: SensorFrames) -> None:
        """As the reference stack, with the messages that `autopilot` received."""
        super().companion(now_s, self._received or frames)


def changed(frames: SensorFrames, **messages: object) -> SensorFrames:
    """The messages of a tick with others from some sensors, each by the sensor's name."""
    return SensorFrames({**frames.by_sensor, **messages})


def declaration(name: str, parts: Parts) -> Declaration:
    """The declaration of a staged stack: that of the reference stack under another name."""

    def make(task: Task, wire: Wire) -> Stack:
        return StagedStack(task, wire, parts)

    return replace(REFERENCE, name=name, make=make)


# The reference study with another stack, so that a flight of its baseline is a flight of that stack.


@dataclass(frozen=True)
class StackStudy(Study):
    """A study that flies another stack than its `sim/stack.yaml` names, with the same settings.

    Attributes:
        stack_name: name of a declared stack.
    """

    stack_name: str = "reference"

    @cached_property
    def stack(self) -> Declaration:
        """The declaration of that stack."""
        own = super().stack
        return STACKS[self.stack_name] if self.stack_name != own.name else own

    @cached_property
    def sim(self) -> SimConfig:
        """Mine, vehicle, sensors and situations of the study, and that stack."""
        own = super().sim
        return replace(own, stack=replace(own.stack, name=self.stack_name))


# A companion whose velocity on the way along a plan is made in a method of its own, for bugs that stand there.


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


# A bug: where it was found, what was wrong, what its fix changed, and the stages that have it.


@dataclass(frozen=True)
class Bug:
    """A bug of a public project.

    Attributes:
        key: of the bug, and name of its stack, such as `px4-11866`: project and number of the thread that tells it.
        cell: the cell that reads like it.
        parts: the stages, one of which has the defect.
    """

    key: str
    cell: str
    parts: Parts


WIDER = 1.1
"""Width and height of the assumed view, as a multiple of the camera's."""


class ViewTooWide(ObstacleMemory):
    """Forgets what lies in the assumed view and is not in the picture.

    PX4-Avoidance issue 357, "Memory not working in real flight due to blind spot" (2019), fixed by pull request
    358.

    The local planner took the camera's view for slightly wider than it is.  A point at the edge is no longer in the
    picture while the planner still counts it as in view, and what is in view and not in the picture is forgotten;
    so no point ever reaches the memory.  The fix keeps the view that the camera has.  The thread gives no angle: a
    tenth is this copy's assumption.
    """

    def observe(self, frame: DepthFrame, pose: PoseEstimate) -> Clearing:
        """The cells to forget: those of the reference stack, and those beside the picture."""
        clearing = super().observe(frame, pose)
        lost = np.isin(self._cells, clearing.forget) | self._beside_the_picture(pose)
        lost[self._places[self._places >= 0]] = False
        return clearing._replace(forget=self._cells[lost])

    def _beside_the_picture(self, pose: PoseEstimate) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
        """Which cells lie in the assumed view, but beside the camera's."""
        c, camera, turn = self.config, self.camera, np.empty((3, 3))
        estimator.rotation(pose.attitude, turn)
        eye = pose.position + camera.ahead_m * turn[:, 0]
        centres = memory.centres(self._cells, eye, c.voxel_m, np.inf)
        ahead, left, up = ((centres - eye) @ turn).T
        in_range = (ahead > c.min_range_m) & (ahead < c.max_range_m)
        side, height = (abs(first) + 0.5 * abs(step) for first, step in (camera.column, camera.row))
        in_view = (abs(left) <= side * ahead) & (abs(up) <= height * ahead)
        assumed = (abs(left) <= WIDER * side * ahead) & (abs(up) <= WIDER * height * ahead)
        beside: np.ndarray[tuple[int], np.dtype[np.bool_]] = in_range & assumed & ~in_view
        return beside


class NewestOnly(PoseBuffer):
    """Answers every stamp with the newest pose."""

    def at(self, stamp_s: float) -> PoseEstimate | None:
        """The newest pose, whatever the stamp."""
        return self.newest


class PlacesWithNewest(Companion):
    """Places depth frames with the newest pose.

    PX4-Avoidance pull request 394, "use correctly stamped tf for pointcloud" (2019), taken up by 435.

    The local planner placed each point cloud with the newest transform instead of the one at the cloud's stamp, so
    that points stand wrong by what the vehicle turned meanwhile.  The fix looks the transform up by the cloud's
    stamp; 435 keeps a buffer for it.  In the copy depth frames are placed with the newest pose.
    """

    def __init__(self, config: CompanionConfig, stages: Stages, wire: Wire, route: Route, yaw_rad: float) -> None:
        super().__init__(config, stages, wire, route, yaw_rad)
        self._poses = NewestOnly(config.pose_span_s, config.pose_reach_s)


OFFSET_M = (0.5, 0.5, 0.0)
"""The wrong initial position, from home [m]."""


class BeginsElsewhere(Estimator):
    """Begins with a position that is not that of the vehicle.

    crazyflie-firmware issue 760, "Default initial position of kalman estimator is not (0, 0, 0)" (2021).

    A refactoring changed the estimator's initial position by accident; testing-abstractions (ManCla) injects it as
    `initialPos`.  The fix sets it to zero again.  The thread gives no number: 0.5 m in x and y is this copy's
    assumption.
    """

    def __init__(self, config: EstimatorConfig, position: Array, yaw_rad: float) -> None:
        super().__init__(config, position + np.array(OFFSET_M), yaw_rad)


EPOCH_S = 1508529766.613423
"""The difference of the two time bases that the thread prints [s]."""


class AnotherEpoch(Receiver):
    """Hands position fixes on with wall-clock stamps.

    mavros issue 838, "Timesync issue when using Snapdragon Flight with mavros" (2017).

    Poses of a vision system reach the autopilot with stamps of another epoch: the thread prints a difference of
    1508529766613423 us, wall-clock time against time since start.  The estimator declares every pose timed out.
    What mends it is one time base on both sides.  In the copy the stamps of position fixes are off by that
    difference.
    """

    def receive(self, frames: SensorFrames) -> SensorFrames:
        """The messages of a tick; the stamp of a fix is of another epoch."""
        fix = frames.fix
        return changed(frames, positioning=fix and fix._replace(stamp_s=fix.stamp_s + EPOCH_S))


QUEUE_SIZE = 10
"""Pictures that wait, of a camera that sends one a tick."""


class TenPicturesWaiting(Receiver):
    """Hands on the detections of the oldest picture in the queue.

    opendr issue 275, "ROS nodes delay" (2022).

    The nodes that detect persons and objects kept ten pictures waiting (`queue_size=10`).  A detector slower than
    its camera takes the oldest of them each time, so that its answer is about a past picture.  The fix is a queue
    of one.  In the copy what the detector sees comes out of a queue of ten pictures of the 20 Hz camera.
    """

    def __init__(self) -> None:
        self._waiting: deque[Detections | None] = deque()

    def receive(self, frames: SensorFrames) -> SensorFrames:
        """The messages of a tick, with the detections of ten ticks before."""
        self._waiting.append(frames.detections)
        return changed(frames, detector=self._waiting.popleft() if len(self._waiting) > QUEUE_SIZE else None)


SCALE = 0.0
"""The calibration scale, which should be 1."""


class ScaledByZero(Estimator):
    """Multiplies the gyro's rates by a scale of zero.

    PX4-Autopilot pull request 5062, "Fix gyro calibration" (merged in 2016; issues 5029 and 5060).

    The calibration scale of the gyro was set to 0 instead of 1, so that every rate reads zero.  The fix sets it to
    1.  In the copy rates are multiplied by that scale before they are integrated.
    """

    def inertial(self, now_s: float, imu: Imu) -> None:
        """Integrate one inertial sample, whose rates are scaled."""
        super().inertial(now_s, imu._replace(rate=SCALE * imu.rate))


class Unstamped(Receiver):
    """Leaves the stamp of position fixes at zero.

    PX4-Autopilot pull request 6647, "Legacy vision interface timestamp hotfix" (merged in 2017).

    The receiver of the legacy vision message did not fill in a time stamp, which stays zero.  The fix fills it in.
    In the copy the receiver of position fixes, the stack's vision, leaves the stamp at zero.
    """

    def receive(self, frames: SensorFrames) -> SensorFrames:
        """The messages of a tick; the stamp of a fix is zero."""
        return changed(frames, positioning=frames.fix and frames.fix._replace(stamp_s=0.0))


class KeepsNoPast(Estimator):
    """Keeps estimates only as long as the parameter for delays says: not at all.

    PX4-Autopilot issue 9182, "Potential bug for EKF2" (2018); the buffer got a size of its own by pull request
    22983.

    Poses of an onboard SLAM reach the estimator 200 ms late, with right stamps.  The estimator keeps the past only
    as long as a parameter for delays says, which is zero because the stamps are synchronised; late poses are
    compared with a too recent estimate, or overwritten, and the vehicle struck the ceiling.  The fix sizes the
    buffers by the real delay.  In the copy the estimator keeps no past, so that a fix, 50 ms late in this study, is
    compared with the newest estimate.
    """

    def __init__(self, config: EstimatorConfig, position: Array, yaw_rad: float) -> None:
        super().__init__(replace(config, history_s=0.0), position, yaw_rad)


class CruisesAlways(Travel):
    """Travels at the cruise speed, whatever was commanded.

    PX4-Autopilot issue 11764, "Mission speed change not working" (2019), fixed by pull request 11836.

    A command to change the speed during a mission was ignored: the vehicle always travelled at the cruise speed,
    which limited it further down.  The fix applies the commanded speed, and tests it.  In the copy the reduction
    beside a person arrives, and the way along a plan is flown at the cruise speed all the same.
    """

    def shaped(self, plan: LocalPlan, pose: PoseEstimate) -> tuple[Array, float]:
        """Velocity and heading at the cruise speed."""
        cruise = self.limit._replace(limit_mps=self.stages.speed_limit.cruise_mps)
        return shape_velocity(plan, pose, cruise, self.stages.planner.config)


INTEGRATED_S = 1.0 / TICK_HZ
"""Integration time of a depth frame [s]."""


class StampedWithDuration(Receiver):
    """Stamps depth frames with their integration time.

    PX4-Autopilot issue 11840, "distance_sensor timestamp from MAVLink OPTICAL_FLOW_RAD is wrong" (2019), fixed by
    11852.

    The receiver stamped a range with the duration over which the sensor had integrated, instead of a time; on the
    ground that is zero, and the estimator never uses the range.  The fix stamps it as the optical flow of the same
    message.  In the copy the receiver stamps depth frames with the camera's integration time, one period.
    """

    def receive(self, frames: SensorFrames) -> SensorFrames:
        """The messages of a tick; the stamp of a depth frame is a duration."""
        return changed(frames, depth=frames.depth and frames.depth._replace(stamp_s=INTEGRATED_S))


class EachAxisLimited(Travel):
    """Limits each horizontal axis of the commanded velocity instead of the speed.

    PX4-Autopilot pull request 11866, "Collision prevention improvements" (merged in 2019).

    Two stages read one speed limit differently: collision prevention took `speed_xy` as the greatest speed, and the
    position controller applied it to each axis by itself, so that the vehicle may fly sqrt(2) times the limit on a
    diagonal.  The pull request made collision prevention read it as the controller does.  The study's limit is one
    of the speed, so the defect of the copy is the controller's reading: each horizontal axis is limited by itself.
    """

    def shaped(self, plan: LocalPlan, pose: PoseEstimate) -> tuple[Array, float]:
        """Velocity and heading; no horizontal axis is faster than the limit."""
        limit_mps = self.limit.limit_mps
        greatest = self.limit._replace(limit_mps=math.sqrt(2.0) * limit_mps)
        velocity, yaw_rad = shape_velocity(plan, pose, greatest, self.stages.planner.config)
        velocity[:2] = np.clip(velocity[:2], -limit_mps, limit_mps)
        return velocity, yaw_rad


class BiasTwice(Estimator):
    """Takes the bias of the gyro off the rate twice.

    PX4-Autopilot pull request 14882, "sensors/vehicle_angular_velocity: don't remove bias twice" (merged in 2020).

    A refactoring took the estimated gyro bias off the angular velocity twice, which rate control flies with.  The
    fix takes it off once.  In the copy the angular rate for rate control has the bias taken off a second time; the
    attitude does not.
    """

    def inertial(self, now_s: float, imu: Imu) -> None:
        """Integrate one inertial sample; the angular rate then lacks the bias twice."""
        super().inertial(now_s, imu)
        self.rate[:] = imu.rate - 2.0 * self.state[RATE_BIAS : RATE_BIAS + 3]


EXTRA_M = 0.5
"""How far beyond the waypoint's distance the acceptance radius is raised [m], as in PX4."""


class SkipsFromBehind(Mission):
    """Raises the acceptance radius where the vehicle is farther behind a leg's start than the leg is long.

    PX4-Autopilot pull request 20308, "ObstacleAvoidance: fix condition for target wp skipping" (2022).

    A waypoint counts as passed when the vehicle, projected on the leg, is farther from the leg's start than the leg
    is long.  Only lengths are compared, so a vehicle *before* the start passes as well: with an acceptance radius
    longer than the next leg all waypoints in a line are skipped.  The fix asks for the same direction too.  The
    reference mission has no such rule; the copy has the part of it that the fix took out.  Its legs are longer than
    3 m, its radius is 0.15 m.
    """

    def check(self, pose: PoseEstimate) -> GoalCheck | None:
        """Input of the goal test; its radius holds the vehicle where the rule takes the waypoint for passed."""
        check = super().check(pose)
        if check is None:
            return None
        start = self._route[self.index - 1] if self.index else self.home
        leg_x, leg_y = (self._route[self.index][k] - start[k] for k in range(2))
        along_m2 = leg_x * (float(pose.position[0]) - start[0]) + leg_y * (float(pose.position[1]) - start[1])
        if along_m2 < 0.0 and -along_m2 > leg_x**2 + leg_y**2:
            return check._replace(radius_m=math.hypot(*check.offset[:2]) + EXTRA_M)
        return check


MOUNTED_RAD = math.pi
"""Angle from the nose to the direction in which the sensor's own zero lies [rad]."""
RAW_PER_DEG = 100.0
"""Raw units of the sensor in a degree."""


class MountedAft(ProximityMonitor):
    """Adds the angle of the mounting to the sensor's raw angle, in the wrong unit.

    PX4-Autopilot pull request 23047, "Lightware SF45 fix to orientation offsets for scaled yaw" (merged in 2024).

    The driver of a scanning range finder added the angle of its mounting, in degrees, to a raw angle in hundredths
    of a degree.  Facing left, right or aft the obstacles so stand in the wrong bins of the obstacle map; facing
    forward the offset is zero.  The fix adds the offset to the scaled angle.  In the copy the proximity monitor's
    sensor counts its angles from the tail, as one that is mounted facing aft, so that the driver must add 180
    degrees and adds 1.8.
    """

    def sectors(self, frame: DepthFrame, pose: PoseEstimate, *, touched: bool = False) -> Proximity:
        """Least range in each sector; the bearings are wrong by the angle of the mounting."""
        seen = super().sectors(frame, pose, touched=touched)
        return seen._replace(bearings=seen.bearings - MOUNTED_RAD + MOUNTED_RAD / RAW_PER_DEG)


BUGS = (
    Bug("px4-11866", "PARTOF-speedlimit", Parts(companion=EachAxisLimited)),
    Bug("px4-23047", "OTHERTHAN-collision", Parts(proximity=MountedAft)),
    Bug("px4-11840", "NO-clock", Parts(receiver=StampedWithDuration)),
    Bug("avoidance-394", "PARTOF-clock", Parts(companion=PlacesWithNewest)),
    Bug("mavros-838", "OTHERTHAN-clock", Parts(receiver=AnotherEpoch)),
    Bug("px4-9182", "LATE-pose", Parts(estimator=KeepsNoPast)),
    Bug("px4-20308", "BEFORE-goal", Parts(mission=SkipsFromBehind)),
    Bug("crazyflie-760", "MORE-pose", Parts(estimator=BeginsElsewhere)),
    Bug("px4-6647", "NO-clock", Parts(receiver=Unstamped)),
    Bug("px4-11764", "NO-speedlimit", Parts(companion=CruisesAlways)),
    Bug("opendr-275", "LATE-human", Parts(receiver=TenPicturesWaiting)),
    Bug("px4-14882", "MORE-imu", Parts(estimator=BiasTwice, compiled=False)),
    Bug("px4-5062", "NO-imu", Parts(estimator=ScaledByZero, compiled=False)),
    Bug("avoidance-357", "PARTOF-map", Parts(memory=ViewTooWide)),
)
"""The bugs: first those of a list of threads that read like cells, then those that were looked for besides."""


WITHOUT = {"staged": Parts(), "travel": Parts(companion=Travel), "interpreted": Parts(compiled=False)}
"""What the copies are made of where no stage has a defect, by name of the stack."""


def declare() -> None:
    """Declare the stack of each bug, and those without a defect; once."""
    for name, parts in (WITHOUT | {bug.key: bug.parts for bug in BUGS}).items():
        if name not in STACKS:
            declare_stack(declaration(name, parts))
