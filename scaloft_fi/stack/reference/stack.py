"""The reference stack: all stages put together, as the flight loop drives them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from scaloft_fi.stack.camera import DepthCamera
from scaloft_fi.stack.config import build
from scaloft_fi.stack.fast_path import FastPath
from scaloft_fi.stack.messages import Array, Exposure, Imu, Point, Route, SensorFrames, Stamps, Thrust
from scaloft_fi.stack.rates import STEP_HZ
from scaloft_fi.stack.reference.battery_monitor import BatteryConfig, BatteryMonitor
from scaloft_fi.stack.reference.companion import Companion, CompanionConfig, Stages
from scaloft_fi.stack.reference.control import ControlConfig
from scaloft_fi.stack.reference.estimator import Estimator, EstimatorConfig
from scaloft_fi.stack.reference.exposure import ExposureConfig, ExposureControl
from scaloft_fi.stack.reference.flight_control import FailsafeConfig, FlightControl
from scaloft_fi.stack.reference.inner_loop import InnerLoop
from scaloft_fi.stack.reference.memory import MemoryConfig, ObstacleMemory
from scaloft_fi.stack.reference.mission import Mission, MissionConfig
from scaloft_fi.stack.reference.planner import Planner, PlannerConfig
from scaloft_fi.stack.reference.proximity import ProximityConfig, ProximityMonitor
from scaloft_fi.stack.reference.recoil import Recoil, RecoilConfig
from scaloft_fi.stack.reference.speed_limit import SpeedLimitConfig, SpeedLimitStage
from scaloft_fi.stack.seam import Wire

BELIEFS = (
    "told_person",
    "told_range_m",
    "limit_mps",
    "collision_flag",
    "target_index",
    "map_points",
    "cmd_vx_mps",
    "cmd_vy_mps",
    "cmd_vz_mps",
    "cmd_yaw_rad",
    "est_x_m",
    "est_y_m",
    "est_z_m",
    "est_vx_mps",
    "est_vy_mps",
    "est_vz_mps",
    "mode",
)
MODES = ("takeoff", "offboard", "hold", "land", "level", "stopped")


@dataclass(frozen=True)
class Task:
    """What a stack is given before take-off.

    Attributes:
        settings: the plain data of `sim/stack.yaml`.
        camera: geometry of the depth camera.
        home: (3,) where it stands [m, world]; yaw_rad: its heading [rad].
        route: waypoints in order, the last one home [m, world].
        altitude_m: height of flight [m].
        cruise_mps, slow_mps: speed, and speed once a person was seen [m/s].
    """

    settings: Mapping[str, Any]
    camera: DepthCamera
    home: Point
    yaw_rad: float
    route: tuple[Point, ...]
    altitude_m: float
    cruise_mps: float
    slow_mps: float


class Stack(Protocol):
    """What the flight loop asks of a stack under test."""

    @property
    def fast_path(self) -> FastPath | None:
        """`step` as a compiled kernel, None where there is none."""
        ...

    @property
    def exposure(self) -> Exposure:
        """The order in force for the colour camera."""
        ...

    def stamps(self, now_s: float) -> Stamps:
        """What the sensors' clocks read now; they stamp their messages with it."""
        ...

    def autopilot(self, now_s: float, frames: SensorFrames) -> None:
        """Run at 20 Hz what stays alive when the companion is dead; every tick, before `companion`."""
        ...

    def companion(self, now_s: float, frames: SensorFrames) -> None:
        """Run the companion stages once, at 20 Hz."""
        ...

    def step(self, now_s: float, imu: Imu) -> Thrust | None:
        """Run flight control once, at 240 Hz; None when the order was lost on the wire."""
        ...

    def beliefs(self, now_s: float) -> Array:
        """The values of `BELIEFS`."""
        ...


@dataclass(frozen=True)
class ReferenceConfig:
    """All settings of the reference stack, as `sim/stack.yaml` has them."""

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


class ReferenceStack:
    """Estimator and flight control below, companion computer above.

    Attributes:
        fast_path: the same as `step`, compiled, for steps whose seams nobody listens on.
    """

    def __init__(self, task: Task, wire: Wire) -> None:
        config = build(ReferenceConfig, task.settings)
        self._wire = wire
        self._estimator = Estimator(config.estimator, np.array(task.home), task.yaw_rad)
        self._control = FlightControl(config.control, config.failsafe, self._estimator, task.yaw_rad)
        self._companion = Companion(
            config.companion,
            Stages(
                ObstacleMemory(config.memory, task.camera),
                ProximityMonitor(config.proximity, task.camera),
                SpeedLimitStage(config.speed_limit, task.cruise_mps, task.slow_mps),
                ExposureControl(config.exposure),
                BatteryMonitor(config.battery),
                Mission(config.mission, (task.home[0], task.home[1], task.altitude_m)),
                Planner(config.planner),
                Recoil(config.recoil),
            ),
            wire,
            Route(task.route),
            task.yaw_rad,
        )
        self._control.take_off(task.altitude_m)
        self.fast_path = InnerLoop(self._estimator, self._control)
        self._pose = self._estimator.tick(0.0, None)
        self._last_stamps = Stamps(0.0, 0.0, 0.0)

    @property
    def exposure(self) -> Exposure:
        """The order in force for the colour camera."""
        return self._companion.exposure

    def stamps(self, now_s: float) -> Stamps:
        """Read the sensors' clocks; a clock that says nothing keeps its last word."""
        self._last_stamps = self._wire.cross("stamps", now_s, Stamps(now_s, now_s, now_s)) or self._last_stamps
        return self._last_stamps

    def autopilot(self, now_s: float, frames: SensorFrames) -> None:
        """Correct the estimate and check flight control's time-outs."""
        self._pose = self._estimator.tick(now_s, self._wire.cross("fix", now_s, frames.fix))
        self._control.watch(now_s)

    def companion(self, now_s: float, frames: SensorFrames) -> None:
        """Run the companion's stages on the estimate of this tick."""
        self._companion.tick(now_s, frames, self._pose, self._control)

    def step(self, now_s: float, imu: Imu) -> Thrust | None:
        """One step of flight control."""
        cross = self._wire.cross
        return cross("thrust", now_s, self._control.step(now_s, cross("imu", now_s, imu), 1.0 / STEP_HZ))

    def beliefs(self, now_s: float) -> Array:
        """The values of `BELIEFS`."""
        mode = float(MODES.index(self._control.mode))
        return np.array((*self._companion.beliefs(now_s), *self._estimator.state[:6].tolist(), mode))
