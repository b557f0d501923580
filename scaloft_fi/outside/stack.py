"""A stack whose stages run in other processes: above flight control, or flight control and planner of our drone."""

from __future__ import annotations

import json
import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from scaloft_fi.mutants.operator import Hold, Period, Seconds, Tap, TapContext, on
from scaloft_fi.mutants.sample import within
from scaloft_fi.outside.border import BORDERS, PORTS, CameraInfo, Goal, Motion
from scaloft_fi.outside.exchange import Exchange, OutsideConfig
from scaloft_fi.stack.declaration import TICK_S, ConfigError, Declaration, FastPath, Seam, Stack, Task, Wire
from scaloft_fi.stack.messages import (
    Array,
    Bumper,
    DepthCamera,
    DepthFrame,
    Detections,
    Exposure,
    Imu,
    Person,
    Point,
    SensorFrames,
    Stamps,
    Thrust,
)
from scaloft_fi.stack.reference.declaration import SEAMS
from scaloft_fi.stack.reference.estimator import Estimator, EstimatorConfig
from scaloft_fi.stack.reference.flight_control import ControlConfig, FailsafeConfig, FlightControl, MakeFlightControl
from scaloft_fi.stack.reference.messages import (
    BELIEFS,
    MODES,
    Failsafe,
    GoalCheck,
    PoseEstimate,
    Route,
    SpeedLimit,
    Target,
    VelocityCommand,
)
from scaloft_fi.stack.reference.mission import Mission, SpeedLimitStage
from scaloft_fi.stack.reference.stack import ReferenceConfig, ReferenceStack

FLIGHT_CONTROL = ("imu", "fix", "thrust")
"""Seams of our drone that are left where velocities come from outside."""
REPLACED = ("person", "route", "goal", "speedlimit")
"""Seams of the reference stack that nobody uses where the mission is outside."""
_MOVED = tuple(one for one in BELIEFS if one.name.startswith(("cmd_", "est_")) or one.name == "mode")


def seams_of(config: OutsideConfig) -> tuple[Seam, ...]:
    """The seams at the border, then those of the part of our drone that flies below.

    Raises:
        ConfigError: two seams have one name.
    """
    border = []
    for name, declared in config.seams.items():
        port = PORTS[declared.carries]
        ends = ("our drone", declared.topic) if port.outward else (declared.topic, "our drone")
        border.append(Seam(name, port.message, port.rate_hz, " -> ".join(ends), units=port.units))
    own = tuple(
        seam
        for seam in SEAMS
        if (seam.name in FLIGHT_CONTROL if config.below == "flight_control" else seam.name not in REPLACED)
    )
    for seam in own:
        if seam.name in config.seams:
            raise ConfigError(f"stack.seams.{seam.name}", "is the name of a seam of our drone, give it another one")
    return (*border, *own)


def shaped(settings: Any) -> Declaration:
    """The declaration that follows from the settings.

    Raises:
        ConfigError: the settings do not fit together.
    """
    config: OutsideConfig = settings
    orders = [name for name, seam in config.seams.items() if not PORTS[seam.carries].outward]
    odometry = [name for name, seam in config.seams.items() if seam.carries == "odometry"]
    return replace(
        OUTSIDE,
        seams=seams_of(config),
        beliefs=_MOVED if config.below == "flight_control" else BELIEFS,
        settings=lambda: VelocityConfig if config.below == "flight_control" else GoalConfig,
        canaries=(*orders[:1], *odometry[:1]),
        deterministic=config.deterministic,
        version=config.version,
    )


def make(task: Task, wire: Wire, flight_control: MakeFlightControl = FlightControl) -> Stack:
    """Start the stages outside, and make the part of our drone that flies below them.

    Args:
        task: of the flight.
        wire: of the flight.
        flight_control: makes what flies below.
    """
    config: OutsideConfig = task.settings
    declared = DeclaredWire(wire, [seam.name for seam in seams_of(config)])
    exchange = Exchange.begin(config, declared, Path(task.folder), words_of(task))
    try:
        return _stack(task, declared, exchange, flight_control)
    except BaseException:
        exchange.close()
        raise


def rehearsed(task: Task, wire: Wire, flight_control: MakeFlightControl = FlightControl) -> Stack:
    """As `make`, without stages outside."""
    BORDERS[task.settings.border].need()
    return _stack(task, wire, None, flight_control)


def _stack(task: Task, wire: Wire, exchange: Exchange | None, flight_control: MakeFlightControl) -> Stack:
    config: OutsideConfig = task.settings
    return (VelocityStack if config.below == "flight_control" else GoalStack)(task, wire, exchange, flight_control)


OUTSIDE = Declaration(
    name="outside",
    seams=(),
    beliefs=(),
    make=make,
    settings=lambda: OutsideConfig,
    operators=("scaloft_fi.mutants.reference", "scaloft_fi.outside.stack"),
    deterministic=False,
    forks=False,
    shape=shaped,
    rehearse=rehearsed,
    forms=lambda: (VelocityConfig, GoalConfig),
)


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


S = TypeVar("S")


@dataclass(frozen=True)
class AutopilotConfig:
    """Settings of `inside` where flight control alone is ours."""

    estimator: EstimatorConfig
    control: ControlConfig
    failsafe: FailsafeConfig


@dataclass(frozen=True)
class VelocityConfig(OutsideConfig):
    """All settings where velocities come from outside."""

    inside: AutopilotConfig


@dataclass(frozen=True)
class GoalConfig(OutsideConfig):
    """All settings where the mission is outside."""

    inside: ReferenceConfig


class DeclaredWire:
    """A wire over the declared seams; stages that are not in use cross it unseen.

    Args:
        wire: of the flight.
        names: of the declared seams.
    """

    def __init__(self, wire: Wire, names: Collection[str]) -> None:
        self._wire, self._names = wire, frozenset(names)

    def listens(self, seam: str) -> bool:
        """Whether the flight's wire listens on a declared seam."""
        return seam in self._names and self._wire.listens(seam)

    def cross(self, seam: str, t_s: float, sample: S | None) -> S | None:
        """Carry the sample over a declared seam; return it as it is over any other."""
        return self._wire.cross(seam, t_s, sample) if seam in self._names else sample


def words_of(task: Task) -> Mapping[str, str]:
    """What the words in braces in the commands stand for."""
    return {
        "route": json.dumps(task.route),
        "home": json.dumps(task.home),
        "altitude_m": f"{task.altitude_m:g}",
        "cruise_mps": f"{task.cruise_mps:g}",
        "slow_mps": f"{task.slow_mps:g}",
        "yaw_deg": f"{math.degrees(task.yaw_rad):g}",
        "situation": task.situation,
    }


def offered(frames: SensorFrames, pose: PoseEstimate, camera: DepthCamera) -> Mapping[str, Any]:
    """The sample of each outward port at a tick; None where there is none."""
    return {
        "odometry": pose,
        "depth": frames.depth,
        "camera_info": camera_info(frames.depth, camera),
        "detections": frames.detections,
        "battery": frames.battery,
        "contacts": frames.bumper,
    }


def camera_info(frame: DepthFrame | None, camera: DepthCamera) -> CameraInfo | None:
    """The pinhole geometry of an image, x right and y down as cameras have it."""
    if frame is None:
        return None
    height, width = frame.depth.shape
    (left, per_column), (up, per_row) = camera.column, camera.row
    return CameraInfo(
        frame.stamp_s, width, height, -1.0 / per_column, -1.0 / per_row, -left / per_column, -up / per_row
    )


class _Outside:
    """What both stacks do with their exchange; None in a rehearsal."""

    _exchange: Exchange | None
    _control: FlightControl

    @property
    def complaint(self) -> str:
        """What was wrong with the first message that was refused."""
        return self._exchange.complaint if self._exchange else ""

    def close(self) -> None:
        """End the stages outside, and flight control."""
        try:
            if self._exchange is not None:
                self._exchange.close()
        finally:
            self._control.close()


class VelocityStack(_Outside):
    """Stages outside order velocities; estimator and flight control of our drone follow them.

    A velocity that stops coming is flight control's time-out: it holds, then lands.
    """

    def __init__(
        self, task: Task, wire: Wire, exchange: Exchange | None, flight_control: MakeFlightControl = FlightControl
    ) -> None:
        config: VelocityConfig = task.settings
        inside = config.inside
        self.exposure = Exposure(0.0, 1.0, 0.0)
        self._camera, self._wire, self._exchange = task.camera, wire, exchange
        self._estimator = Estimator(inside.estimator, np.array(task.home), task.yaw_rad)
        self._control = flight_control(inside.control, inside.failsafe, self._estimator, task.yaw_rad)
        self._control.take_off(task.altitude_m)
        self._pose = self._estimator.tick(0.0, None)
        self._yaw_rad = task.yaw_rad
        self._ordered = np.zeros(3)
        self._body = any(seam.carries == "velocity" and seam.frame == "body" for seam in config.seams.values())
        self._inertial = next((name for name, seam in config.seams.items() if seam.carries == "inertial"), "")
        self.fast_path: FastPath | None = None if self._inertial else self._control.fast_path

    def stamps(self, now_s: float) -> Stamps:
        """The true time."""
        return Stamps(now_s, now_s, now_s)

    def autopilot(self, now_s: float, frames: SensorFrames) -> None:
        """Correct the estimate and check flight control's time-outs."""
        self._pose = self._estimator.tick(now_s, self._wire.cross("fix", now_s, frames.fix))
        self._control.watch(now_s)
        self._control.deliver(now_s, frames)

    def companion(self, now_s: float, frames: SensorFrames) -> None:
        """Exchange samples with the stages outside, and follow their orders."""
        if self._exchange is None:
            return
        taken = self._exchange.tick(now_s, offered(frames, self._pose, self._camera))
        if taken.get("land") is not None:
            self._control.land(self._control.config.land_mps)
        motion: Motion | None = taken.get("velocity")
        if motion is None:
            return
        self._yaw_rad += motion.turn_radps * TICK_S
        x, y, z = motion.velocity.tolist()
        if self._body:
            cos, sin = math.cos(self._pose.yaw_rad), math.sin(self._pose.yaw_rad)
            x, y = cos * x - sin * y, sin * x + cos * y
        self._ordered = np.array([x, y, z])
        self._control.command(
            now_s, VelocityCommand(now_s, self._ordered, self._yaw_rad), self._control.config.accel_mps2
        )

    def step(self, now_s: float, imu: Imu) -> Thrust | None:
        """One step of flight control."""
        cross = self._wire.cross
        if self._inertial and self._exchange is not None:
            self._exchange.send(self._inertial, now_s, imu)
        return cross("thrust", now_s, self._control.step(now_s, cross("imu", now_s, imu), imu))

    def beliefs(self, now_s: float) -> Array:
        """The values of the declared beliefs."""
        mode = float(MODES.index(self._control.mode))
        return np.array((*self._ordered, self._yaw_rad, *self._estimator.state[:6].tolist(), mode))


class GoalStack(_Outside, ReferenceStack):
    """The mission is outside; everything below it is the reference stack's."""

    def __init__(
        self, task: Task, wire: Wire, exchange: Exchange | None, flight_control: MakeFlightControl = FlightControl
    ) -> None:
        config: GoalConfig = task.settings
        super().__init__(replace(task, settings=config.inside), wire, flight_control)
        stages = self._companion.stages
        self._mission = GoalMission(stages.mission.config, stages.mission.home)
        self._limit = TakenLimit(stages.speed_limit.config, task.cruise_mps, task.slow_mps)
        self._companion.stages = replace(stages, mission=self._mission, speed_limit=self._limit)
        self._camera, self._exchange = task.camera, exchange

    def companion(self, now_s: float, frames: SensorFrames) -> None:
        """Exchange samples with the mission outside, then run the stages below it."""
        if self._exchange is not None:
            taken = self._exchange.tick(now_s, offered(frames, self._pose, self._camera))
            self._mission.fly_to(taken.get("goal"))
            self._limit.newest = taken.get("speed_limit")
            if taken.get("land") is not None:
                self._mission.land()
        super().companion(now_s, frames)


_FREE = Bumper(0.0, hull=False, gear=False)


@on(
    Bumper,
    "false_contact",
    {"hold_s": 0.05, "period_s": 0.1},
    (_FREE,) * 4,
    (_FREE, _FREE, _FREE._replace(hull=True), _FREE),
)
def false_contact(context: TapContext, *, hold_s: Hold = 0.5, period_s: Period = 20.0, phase_s: Seconds = 0.0) -> Tap:
    """Report contact of the hull without cause for `hold_s` [s] each `period_s` [s]: noise on the touch sensor."""
    windows = context.windows(period_s, phase_s, max(hold_s, context.period_s))
    return within(windows, lambda bumper: bumper._replace(hull=True))
