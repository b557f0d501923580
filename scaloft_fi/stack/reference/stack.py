"""The reference stack behind the contract `Stack`, and what it declares: seams, beliefs, claims."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from scaloft_fi.stack.declaration import Task, Wire
from scaloft_fi.stack.messages import Array, Exposure, Imu, SensorFrames, Stamps, Thrust
from scaloft_fi.stack.reference.companion import Companion, CompanionConfig, ExposureConfig, ExposureControl, Stages
from scaloft_fi.stack.reference.estimator import Estimator, EstimatorConfig
from scaloft_fi.stack.reference.flight_control import ControlConfig, FailsafeConfig, FlightControl
from scaloft_fi.stack.reference.memory import MemoryConfig, ObstacleMemory
from scaloft_fi.stack.reference.messages import MODES, Route
from scaloft_fi.stack.reference.mission import (
    BatteryConfig,
    BatteryMonitor,
    Mission,
    MissionConfig,
    SpeedLimitConfig,
    SpeedLimitStage,
)
from scaloft_fi.stack.reference.planner import Planner, PlannerConfig
from scaloft_fi.stack.reference.proximity import ProximityConfig, ProximityMonitor, Recoil, RecoilConfig


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


class ReferenceStack:
    """Estimator and flight control below, companion computer above.

    Attributes:
        planner_kind: class of the planner; a stack with another planner derives from this one and names it here.
        fast_path: `step`, compiled, for steps in which the wire listens on neither `imu` nor `thrust`.
    """

    planner_kind: type[Planner] = Planner

    def __init__(self, task: Task, wire: Wire) -> None:
        config: ReferenceConfig = task.settings
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
                self.planner_kind(config.planner),
                Recoil(config.recoil),
            ),
            wire,
            Route(task.route),
            task.yaw_rad,
        )
        self._control.take_off(task.altitude_m)
        self.fast_path = self._control
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

    def companion(self, now_s: float, frames: SensorFrames) -> None:
        """Run the companion's stages on the estimate of this tick."""
        self._companion.tick(now_s, frames, self._pose, self._control)

    def step(self, now_s: float, imu: Imu) -> Thrust | None:
        """One step of flight control."""
        cross = self._wire.cross
        return cross("thrust", now_s, self._control.step(now_s, cross("imu", now_s, imu)))

    def beliefs(self, now_s: float) -> Array:
        """The values of the declared beliefs."""
        mode = float(MODES.index(self._control.mode))
        return np.array((*self._companion.beliefs(now_s), *self._estimator.state[:6].tolist(), mode))
