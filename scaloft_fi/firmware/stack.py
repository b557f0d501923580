"""A firmware below a stack: an outer loop above it, its seams, and its throttles to the speed controllers.

What is above is the reference companion, one with a planner of its own, or stages in other processes.

The outer loop is that of our flight control (`flight_control.outer`): from the mode and the ordered velocity to a
force, with PX4's gains.  A firmware that holds attitudes gets tilt, turn rate and throttle of that force; one that
flies velocities gets the velocity and the heading themselves.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from scaloft_fi.firmware.kind import (
    ACCELEROMETER,
    GYRO,
    KINDS,
    MOTORS,
    VELOCITY,
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
from scaloft_fi.outside import stack as outside
from scaloft_fi.outside.exchange import Command, OutsideConfig
from scaloft_fi.outside.stack import GoalConfig, VelocityConfig
from scaloft_fi.stack.declaration import STEPS_PER_TICK, ConfigError, Declaration, Stack, Task, Wire
from scaloft_fi.stack.messages import (
    EARTH_FIELD_UT,
    Array,
    Fix,
    Imu,
    MagneticField,
    Pressure,
    SensorFrames,
    Thrust,
    standard_hpa,
)
from scaloft_fi.stack.reference import estimator
from scaloft_fi.stack.reference.declaration import REFERENCE
from scaloft_fi.stack.reference.estimator import ATTITUDE, GRAVITY_MPS2, RATE_BIAS, Estimator, yaw_of
from scaloft_fi.stack.reference.flight_control import (
    ControlConfig,
    FailsafeConfig,
    FlightControl,
    MakeFlightControl,
    outer,
)
from scaloft_fi.stack.reference.stack import ReferenceConfig, ReferenceStack


@dataclass(frozen=True, kw_only=True)
class FirmwareStackConfig(ReferenceConfig):
    """All settings of the reference companion above a firmware."""

    firmware: FirmwareConfig

    @property
    def processes(self) -> tuple[Command, ...]:
        """The program of the study's own that a flight starts."""
        return (Command((self.firmware.program, *self.firmware.arguments)),)


@dataclass(frozen=True, kw_only=True)
class OutsideFirmwareConfig(OutsideConfig):
    """What all stages outside above a firmware have."""

    firmware: FirmwareConfig


@dataclass(frozen=True, kw_only=True)
class VelocityFirmwareConfig(VelocityConfig):
    """All settings where velocities come from outside, above a firmware."""

    firmware: FirmwareConfig


@dataclass(frozen=True, kw_only=True)
class GoalFirmwareConfig(GoalConfig):
    """All settings where the mission is outside, above a firmware."""

    firmware: FirmwareConfig


class FirmwareControl(FlightControl):
    """Modes and time-outs of our flight control above a firmware, which orders the motors.

    Args:
        config, failsafe, estimator, yaw_rad: as `FlightControl`.
        firmware: the firmware under way.
        settings: of the firmware: its kind has its seams.
        wire: carries the samples of these seams.
        throttle_exponent: curve of the speed controllers.
    """

    fast_path = None

    def __init__(
        self,
        config: ControlConfig,
        failsafe: FailsafeConfig,
        estimator: Estimator,
        yaw_rad: float,
        *,
        firmware: Firmware,
        settings: FirmwareConfig,
        wire: Wire,
        throttle_exponent: float,
    ) -> None:
        super().__init__(config, failsafe, estimator, yaw_rad)
        self._firmware, self._limits, self._wire, self._curve = firmware, settings, wire, throttle_exponent
        self._velocities = VELOCITY in KINDS[settings.kind].seams
        self._sensors = settings.seams_by_sensor
        self._arrived: dict[str, Any] = {}
        self._steps, self._altitude_m = 0, 0.0

    def take_off(self, altitude_m: float) -> None:
        """Climb to `altitude_m` above the start and hold there."""
        super().take_off(altitude_m)
        self._altitude_m = altitude_m

    def deliver(self, now_s: float, frames: SensorFrames) -> None:
        """Take what the firmware's sensors deliver at a tick, for its next step.

        Raises:
            KeyError: the study has no such sensor.
        """
        for sensor, seam in self._sensors.items():
            self._arrived[sensor] = self._wire.cross(seam.name, now_s, frames[sensor])

    def step(self, now_s: float, imu: Imu | None, felt: Imu | None = None) -> Thrust:
        """One step of the firmware; what the speed controllers make of its motors."""
        assert felt is not None
        motors = self._wire.cross(MOTORS.name, now_s, self.motors(now_s, imu, felt))
        throttles = np.zeros(4) if motors is None else np.clip(np.array(motors), 0.0, 1.0)
        return Thrust(self.config.max_thrust_n * throttles**self._curve)

    def close(self) -> None:
        """End the firmware."""
        self._firmware.close()

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
        arrived, self._arrived = self._arrived, {}
        state = estimate.state
        attitude, velocity = state[ATTITUDE:RATE_BIAS], state[estimator.VELOCITY : ATTITUDE]
        samples = Samples(gyro, accelerometer, order, attitude, velocity, self._altitude_m, self.mode, arrived)
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
            min(1.0, share) ** (1.0 / self._curve),
        )


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
    force = Accelerometer(0.0, np.array([0.0, 0.0, GRAVITY_MPS2]))
    x, y, z = EARTH_FIELD_UT
    ahead, left = math.cos(task.yaw_rad), math.sin(task.yaw_rad)
    arrived = {
        "positioning": Fix(0.0, np.array(task.home), task.yaw_rad),
        "barometer": Pressure(0.0, standard_hpa(task.home[2])),
        "magnetometer": MagneticField(0.0, np.array([ahead * x + left * y, ahead * y - left * x, z])),
    }
    return Samples(Gyro(0.0, np.zeros(3)), force, None, attitude, np.zeros(3), task.altitude_m, "takeoff", arrived)


def _begun(task: Task, wire: Wire, firmware: Firmware) -> MakeFlightControl:
    """Makes the flight control with this firmware.

    Raises:
        ConfigError: the study lacks a sensor of the firmware.
    """
    settings: FirmwareConfig = task.settings.firmware
    for name in settings.sensors:
        if name not in task.sensors:
            raise ConfigError("stack.firmware.sensors", f"names {name!r}, which is no sensor of sim/sensors.yaml")
    return partial(
        FirmwareControl, firmware=firmware, settings=settings, wire=wire, throttle_exponent=task.throttle_exponent
    )


MakeStack = Callable[[Task, Wire, MakeFlightControl], Stack]
"""Makes a stack above a flight control, usually the class."""


def above_firmware(name: str, stack: type[ReferenceStack]) -> Declaration:
    """The declaration of a stack above a firmware, such as one with a planner of its own.

    Args:
        name: by which `sim/stack.yaml` names it.
        stack: its class.
    """
    above = replace(REFERENCE, name=name, settings=lambda: FirmwareStackConfig)
    return _above_firmware(above, stack, stack, lambda _settings: above)


def _above_firmware(
    above: Declaration, make_above: MakeStack, rehearse: MakeStack, shape: Callable[[Any], Declaration]
) -> Declaration:
    """The declaration of a stack above a firmware.

    Args:
        above: of the stack.
        make_above, rehearse: make it above a flight control, for a flight and for the trial flight.
        shape: its declaration from its settings.
    """

    def make(task: Task, wire: Wire) -> Stack:
        config: FirmwareConfig = task.settings.firmware
        firmware = KINDS[config.kind](config, Path(task.folder), still(task))
        try:
            return make_above(task, wire, _begun(task, wire, firmware))
        except BaseException:
            firmware.close()
            raise

    def rehearsed(task: Task, wire: Wire) -> Stack:
        return rehearse(task, wire, _begun(task, wire, NoFirmware()))

    def shaped(settings: Any) -> Declaration:
        config: FirmwareConfig = settings.firmware
        own = shape(settings)
        for seam in (*config.seams, MOTORS):
            if seam.name in own.by_name:
                raise ConfigError(
                    f"stack.seams.{seam.name}", "is the name of a seam of the firmware, give it another one"
                )
        adapter = sys.modules[KINDS[config.kind].__module__].__file__
        return replace(
            own,
            name=above.name,
            seams=(*own.seams, *config.seams, MOTORS),
            canaries=("order", *own.canaries),
            files=(str(Path(config.program).expanduser()), *config.parameters, str(TURNS), str(adapter)),
            version=", ".join(filter(None, (f"{config.kind} {config.version}", own.version))),
            make=make,
            rehearse=rehearsed,
            forks=False,
            shape=None,
        )

    make.__module__ = make_above.__module__  # whose code decides the flights
    return replace(above, seams=(), canaries=(), make=make, rehearse=rehearsed, forks=False, shape=shaped)


def _outside_shape(settings: Any) -> Declaration:
    velocities = settings.below == "flight_control"
    return replace(
        outside.shaped(settings), settings=lambda: VelocityFirmwareConfig if velocities else GoalFirmwareConfig
    )


FIRMWARE = above_firmware("firmware", ReferenceStack)
OUTSIDE_FIRMWARE = _above_firmware(
    replace(
        outside.OUTSIDE,
        name="outside_firmware",
        settings=lambda: OutsideFirmwareConfig,
        forms=lambda: (VelocityFirmwareConfig, GoalFirmwareConfig),
    ),
    outside.make,
    outside.rehearsed,
    _outside_shape,
)
