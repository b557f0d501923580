"""The reference companion above a firmware: its perception and navigation, an outer loop, and the firmware below.

The outer loop is that of our flight control (`flight_control.outer`): from the mode and the ordered velocity to a
force, with PX4's gains.  A firmware that holds attitudes gets tilt, turn rate and throttle of that force; one that
flies velocities gets the velocity and the heading themselves.
"""

from __future__ import annotations

import math
import sys
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from scaloft_fi.firmware.kind import (
    ACCELEROMETER,
    GYRO,
    KINDS,
    MOTORS,
    POSITION,
    Accelerometer,
    AttitudeOrder,
    Firmware,
    FirmwareConfig,
    Gyro,
    Motors,
    Samples,
    VelocityOrder,
)
from scaloft_fi.firmware.program import TURNS
from scaloft_fi.outside.exchange import Command
from scaloft_fi.stack.declaration import STEPS_PER_TICK, Declaration, Seam, Stack, Task, Wire
from scaloft_fi.stack.messages import Array, Fix, Imu, SensorFrames, Thrust
from scaloft_fi.stack.reference import estimator
from scaloft_fi.stack.reference.declaration import SEAMS
from scaloft_fi.stack.reference.estimator import ATTITUDE, GRAVITY_MPS2, RATE_BIAS, VELOCITY, Estimator, yaw_of
from scaloft_fi.stack.reference.flight_control import ControlConfig, FailsafeConfig, FlightControl, outer
from scaloft_fi.stack.reference.messages import BELIEFS
from scaloft_fi.stack.reference.stack import ReferenceConfig, ReferenceStack


@dataclass(frozen=True, kw_only=True)
class FirmwareStackConfig(ReferenceConfig):
    """All settings of the reference companion above a firmware."""

    firmware: FirmwareConfig

    @property
    def processes(self) -> tuple[Command, ...]:
        """The program of the study's own that a flight starts."""
        return (Command((self.firmware.program, *self.firmware.arguments)),)


class FirmwareControl(FlightControl):
    """Modes and time-outs of our flight control above a firmware, which orders the motors.

    Args:
        config, failsafe, estimator, yaw_rad: as `FlightControl`.
        firmware: the firmware under way.
        limits: the greatest tilt and turn rate, and the curve of the speed controllers.
        wire: carries the samples of the firmware's seams.
        velocities: whether the firmware flies velocities; else it holds attitudes.
        seams: names of the seams that its kind takes.
    """

    def __init__(
        self,
        config: ControlConfig,
        failsafe: FailsafeConfig,
        estimator: Estimator,
        yaw_rad: float,
        firmware: Firmware,
        limits: FirmwareConfig,
        wire: Wire,
        *,
        velocities: bool,
        seams: frozenset[str],
    ) -> None:
        super().__init__(config, failsafe, estimator, yaw_rad)
        self._firmware, self._limits, self._wire = firmware, limits, wire
        self._velocities, self._has = velocities, seams
        self._fix: Fix | None = None
        self._steps, self._altitude_m = 0, 0.0

    def take_off(self, altitude_m: float) -> None:
        """Climb to `altitude_m` above the start and hold there."""
        super().take_off(altitude_m)
        self._altitude_m = altitude_m

    def fixed(self, now_s: float, fix: Fix | None) -> None:
        """Hand the position fix of a tick to the firmware."""
        self._fix = self._wire.cross(POSITION.name, now_s, fix) if POSITION.name in self._has else None

    def motors(self, now_s: float, believed: Imu | None, imu: Imu) -> Motors:
        """One 240 Hz step: estimate, order, and let the firmware answer.

        Args:
            now_s: time since the start [s].
            believed: the sample that arrived at our estimator.
            imu: the sample of the inertial sensor.
        """
        estimate, cross = self.estimator, self._wire.cross
        self.sense(now_s, believed)
        force = outer(estimate.numbers, self.numbers)
        order: AttitudeOrder | VelocityOrder | None = None
        if not self._velocities:
            order = cross("order", now_s, self._attitude(now_s, np.array(force)))
        elif self._steps % STEPS_PER_TICK == 0:
            order = cross("order", now_s, VelocityOrder(now_s, *self.target()))
        gyro = cross(GYRO.name, now_s, Gyro(imu.stamp_s, imu.rate))
        accelerometer = cross(ACCELEROMETER.name, now_s, Accelerometer(imu.stamp_s, imu.force))
        self.end()
        fix, self._fix = self._fix, None
        state = estimate.state
        attitude, velocity = state[ATTITUDE:RATE_BIAS], state[VELOCITY:ATTITUDE]
        samples = Samples(gyro, accelerometer, fix, order, attitude, velocity, self._altitude_m, self.mode)
        self._steps += 1
        return Motors(*self._firmware.step(samples).tolist())

    def _attitude(self, now_s: float, force: Array) -> AttitudeOrder:
        """Tilt, turn rate and throttle of a force [N, world]."""
        _, r, _, _, _ = estimator.parts_of(self.estimator.numbers)
        state, config, limits = self.estimator.state, self.config, self._limits
        yaw_rad = float(yaw_of(state[ATTITUDE:RATE_BIAS]))
        ahead = math.cos(yaw_rad) * force[0] + math.sin(yaw_rad) * force[1]
        left = math.cos(yaw_rad) * force[1] - math.sin(yaw_rad) * force[0]
        pitch_rad, roll_rad = math.atan2(ahead, force[2]), math.atan2(-left, math.hypot(ahead, force[2]))
        behind = math.remainder(self.target()[1] - yaw_rad, 2.0 * math.pi)
        share = max(0.0, float(force @ r[:, 2])) / (4.0 * config.max_thrust_n)
        most = limits.tilt_rad
        return AttitudeOrder(
            now_s,
            min(most, max(-most, roll_rad)),
            min(most, max(-most, pitch_rad)),
            min(limits.turn_radps, max(-limits.turn_radps, config.attitude_p[1] * behind)),
            min(1.0, share) ** (1.0 / limits.throttle_exponent),
        )


class FirmwareStack(ReferenceStack):
    """The reference companion above a firmware."""

    _control: FirmwareControl

    def __init__(self, task: Task, wire: Wire, firmware: Firmware) -> None:
        self._firmware, self._curve = firmware, task.settings.firmware.throttle_exponent
        super().__init__(task, wire)
        self.fast_path = None

    def _flight_control(self, config: ReferenceConfig, yaw_rad: float, wire: Wire) -> FlightControl:
        assert isinstance(config, FirmwareStackConfig)
        seams = frozenset(seam.name for seam in KINDS[config.firmware.kind].seams)
        velocities = any(seam.message is VelocityOrder for seam in KINDS[config.firmware.kind].seams)
        return FirmwareControl(
            config.control, config.failsafe, self._estimator, yaw_rad, self._firmware, config.firmware, wire,
            velocities=velocities, seams=seams,
        )  # fmt: skip

    def autopilot(self, now_s: float, frames: SensorFrames) -> None:
        """As our flight control; the firmware gets the position fix too."""
        super().autopilot(now_s, frames)
        self._control.fixed(now_s, frames.fix)

    def step(self, now_s: float, imu: Imu) -> Thrust | None:
        """One step of the firmware; what the speed controllers make of its motors."""
        cross = self._wire.cross
        motors = cross(MOTORS.name, now_s, self._control.motors(now_s, cross("imu", now_s, imu), imu))
        throttles = np.zeros(4) if motors is None else np.clip(np.array(motors), 0.0, 1.0)
        thrusts_n = self._control.config.max_thrust_n * throttles**self._curve
        return cross("thrust", now_s, Thrust(thrusts_n))

    def close(self) -> None:
        """End the firmware."""
        self._firmware.close()


class NoFirmware:
    """What stands for a firmware in the trial flight: motors that carry the drone."""

    def step(self, _samples: Samples) -> Array:
        """Half the throttle."""
        return np.full(4, 0.5)

    def close(self) -> None:
        """Do nothing."""


def still(task: Task) -> Samples:
    """What the sensors say of a vehicle that stands."""
    half = 0.5 * task.yaw_rad
    attitude = np.array([0.0, 0.0, math.sin(half), math.cos(half)])
    fix = Fix(0.0, np.array(task.home), task.yaw_rad)
    force = Accelerometer(0.0, np.array([0.0, 0.0, GRAVITY_MPS2]))
    return Samples(Gyro(0.0, np.zeros(3)), force, fix, None, attitude, np.zeros(3), task.altitude_m, "takeoff")


def seams_of(config: FirmwareConfig) -> tuple[Seam, ...]:
    """The seams of the companion, then those of the firmware."""
    return (*SEAMS, *KINDS[config.kind].seams, MOTORS)


def above_firmware(name: str, stack: type[FirmwareStack]) -> Declaration:
    """The declaration of a stack above a firmware, such as one with a planner of its own.

    Args:
        name: by which `sim/stack.yaml` names it.
        stack: its class.
    """

    def make(task: Task, wire: Wire) -> Stack:
        config: FirmwareConfig = task.settings.firmware
        firmware = KINDS[config.kind](config, Path(task.folder), still(task))
        try:
            return stack(task, wire, firmware)
        except BaseException:
            firmware.close()
            raise

    def rehearsed(task: Task, wire: Wire) -> Stack:
        return stack(task, wire, NoFirmware())

    def shaped(settings: Any) -> Declaration:
        config: FirmwareConfig = settings.firmware
        adapter = sys.modules[KINDS[config.kind].__module__].__file__
        files = (str(Path(config.program).expanduser()), *config.parameters, str(TURNS), str(adapter))
        version = f"{config.kind} {config.version}"
        return replace(declared, seams=seams_of(config), canaries=CANARIES, files=files, version=version, shape=None)

    make.__module__ = stack.__module__  # whose code decides the flights
    declared = Declaration(
        name=name,
        seams=(),
        beliefs=BELIEFS,
        make=make,
        settings=lambda: FirmwareStackConfig,
        operators=("scaloft_fi.mutants.reference",),
        forks=False,
        shape=shaped,
        rehearse=rehearsed,
    )
    return declared


CANARIES = ("order", "velcmd", "pose", "goal")
FIRMWARE = above_firmware("firmware", FirmwareStack)
