"""Flight control with its fail-safes: the autopilot below the companion computer."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from scaloft_fi.stack.messages import Imu, Thrust
from scaloft_fi.stack.reference.control import (
    HEADING,
    HOLD_MODE,
    LAND_MODE,
    LEVEL_MODE,
    NUMBERS,
    VELOCITY_MODE,
    ControlConfig,
    control,
    parts_of,
)
from scaloft_fi.stack.reference.estimator import Estimator
from scaloft_fi.stack.reference.messages import VelocityCommand


@dataclass(frozen=True)
class FailsafeConfig:
    """Time-outs of the autopilot.

    Attributes:
        command_hold_s: time without a command before it holds position [s] (PX4 COM_OF_LOSS_T 1 s; PX4-Avoidance
            0.5 s).
        command_land_s: time without a command before it lands [s] (PX4-Avoidance's termination, 15 s).
        fix_level_s: time without an accepted fix before it sinks level [s] (PX4 EKF2_NOAID_TOUT, 5 s).
        imu_stop_s: time without an inertial sample before it stops the rotors, because attitude is lost [s].
    """

    command_hold_s: float
    command_land_s: float
    fix_level_s: float
    imu_stop_s: float


class FlightControl:
    """Follows velocity commands, holds, takes off, lands; falls back to a fail-safe when its inputs stop.

    Attributes:
        mode: its present mode, one of "takeoff", "offboard", "hold", "land", "level", "stopped".
        kernel_mode, yaw_rad, accel_mps2: arguments of the kernel `control`.
        numbers: (52,) the other arguments of `control`, see `control.parts_of`.
    """

    def __init__(self, config: ControlConfig, failsafe: FailsafeConfig, estimator: Estimator, yaw_rad: float) -> None:
        self.config = config
        self.failsafe = failsafe
        self.estimator = estimator
        self.mode = "takeoff"
        self.numbers = np.zeros(NUMBERS)
        self._velocity, self._hold, self._memory, self._gains, self._allocation, _ = parts_of(self.numbers)
        self._gains[:], self._allocation[:] = config.gains(), config.allocation()
        self._memory[HEADING] = yaw_rad
        self._hold[:] = estimator.state[:3]
        self.yaw_rad = yaw_rad
        self.accel_mps2 = config.accel_mps2
        self.kernel_mode = HOLD_MODE
        self._commanded_s = 0.0
        self._stopped = np.zeros(4)

    def take_off(self, altitude_m: float) -> None:
        """Climb to `altitude_m` above the start and hold there."""
        self._enter("takeoff", HOLD_MODE)
        self._hold[2] = altitude_m

    def land(self, limit_mps: float) -> None:
        """Sink at the present position, no faster than `limit_mps`."""
        if self.mode not in ("land", "level", "stopped"):
            self._sink("land", LAND_MODE, limit_mps)

    def command(self, now_s: float, order: VelocityCommand, accel_mps2: float) -> None:
        """Follow a velocity command; a command ends take-off and hold, but not a landing."""
        if self.mode in ("land", "level", "stopped"):
            return
        self._commanded_s = now_s
        self._velocity[:] = order.velocity
        self.yaw_rad = order.yaw_rad
        self.accel_mps2 = accel_mps2
        self.mode, self.kernel_mode = "offboard", VELOCITY_MODE

    def watch(self, now_s: float) -> None:
        """Check the time-outs, at 20 Hz."""
        silent_s = now_s - self._commanded_s
        if self.mode == "offboard" and silent_s > self.failsafe.command_hold_s:
            self._enter("hold", HOLD_MODE)
        if self.mode == "hold" and silent_s > self.failsafe.command_land_s:
            self._sink("land", LAND_MODE, self.config.land_mps)
        if self.mode not in ("level", "stopped") and now_s - self.estimator.last_fix_s > self.failsafe.fix_level_s:
            self._sink("level", LEVEL_MODE, self.config.land_mps)

    def step(self, now_s: float, imu: Imu | None, dt_s: float) -> Thrust:
        """One 240 Hz step: integrate the inertial sample, if one arrived, and return the thrust."""
        estimator = self.estimator
        if imu is not None:
            estimator.inertial(now_s, imu)
        elif now_s - estimator.last_imu_s > self.failsafe.imu_stop_s:
            self.mode = "stopped"
        if self.mode == "stopped":
            return Thrust(self._stopped)
        thrust = np.empty(4)
        finite = control(
            estimator.state,
            estimator.rotation,
            estimator.rate,
            self.kernel_mode,
            self._velocity,
            self._hold,
            self.yaw_rad,
            self.accel_mps2,
            dt_s,
            self._gains,
            self._allocation,
            self._memory,
            thrust,
        )
        if not finite:
            self.mode = "stopped"
            return Thrust(self._stopped)
        return Thrust(thrust)

    def _sink(self, mode: str, kernel_mode: int, limit_mps: float) -> None:
        self._enter(mode, kernel_mode)
        self._velocity[:] = 0.0, 0.0, -min(limit_mps, self.config.land_mps)

    def _enter(self, mode: str, kernel_mode: int) -> None:
        self.mode, self.kernel_mode = mode, kernel_mode
        self._hold[:] = self.estimator.state[:3]
        self.accel_mps2 = self.config.accel_mps2
