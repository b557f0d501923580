"""Flight control below the companion: cascaded control in the manner of PX4, fail-safes, and both as one compiled step.

Gains are PX4's defaults where PX4 has them (MPC_XY_P 0.95, MPC_XY_VEL_P/I_ACC 1.8/0.4, MPC_Z_P 1, MPC_Z_VEL_P/I_ACC
4/2, MC_ROLL_P 6.5, MC_YAW_P 2.8, MPC_YAWRAUTO_MAX 45 deg/s).

The compiled step calls the same kernels on the same numbers as `FlightControl.step`, in the same order.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import accumulate
from typing import Literal, Protocol

import numpy as np

from scaloft_fi.marks import NotNegative, Positive
from scaloft_fi.stack.declaration import STEP_HZ, FastPath, Numbers
from scaloft_fi.stack.kernel import jit
from scaloft_fi.stack.messages import Array, Imu, SensorFrames, Thrust
from scaloft_fi.stack.reference import estimator
from scaloft_fi.stack.reference.estimator import GRAVITY_MPS2, Estimator
from scaloft_fi.stack.reference.messages import VelocityCommand

VELOCITY_MODE, HOLD_MODE, LAND_MODE, LEVEL_MODE, STOPPED_MODE = 0, 1, 2, 3, 4

# In the controller's memory stand the slewed velocity setpoint, the integrators, and here the slewed heading setpoint.
HEADING = 6

# Layout of the orders: mode, heading to take, greatest change of the velocity setpoint.
_MODE, _YAW, _ACCEL = 0, 1, 2

# Layout of the numbers of flight control: velocity, hold, memory, gains, allocation, orders, thrust.
_HOLD, _MEMORY, _GAINS, _ALLOCATION, _ORDERS, _THRUST, NUMBERS = accumulate((3, 3, 7, 19, 16, 3, 4))

Arm = tuple[float, float]
Spin = Literal[1, -1]


@dataclass(frozen=True)
class ControlConfig:
    """The vehicle as flight control believes it to be, and the gains.

    Attributes:
        mass_kg: believed mass [kg].
        inertia: (3,) believed principal moments of inertia [kg m2].
        rotors: four (x, y) arm positions [m, body].
        spins: direction of the torque of each rotor, +1 or -1 about body z.
        moment_m: rotor torque per thrust [m].
        max_thrust_n: greatest thrust of one rotor [N].
        position_p: horizontal, vertical [1/s].
        velocity_p: horizontal, vertical [1/s].
        velocity_i: horizontal, vertical [1/s2].
        attitude_p: roll and pitch, yaw [1/s].
        rate_p: roll and pitch, yaw [1/s].
        accel_mps2: greatest change of the velocity setpoint [m/s2].
        tilt_accel_mps2: greatest horizontal acceleration setpoint [m/s2].
        yaw_rate_radps: greatest change of the heading setpoint [rad/s].
        hold_mps: greatest speed of position hold, horizontal, up [m/s].
        land_mps: sink rate of a landing [m/s].
    """

    mass_kg: Positive
    inertia: tuple[Positive, Positive, Positive]
    rotors: tuple[Arm, Arm, Arm, Arm]
    spins: tuple[Spin, Spin, Spin, Spin]
    moment_m: Positive
    max_thrust_n: Positive
    position_p: tuple[NotNegative, NotNegative]
    velocity_p: tuple[NotNegative, NotNegative]
    velocity_i: tuple[NotNegative, NotNegative]
    attitude_p: tuple[NotNegative, NotNegative]
    rate_p: tuple[NotNegative, NotNegative]
    accel_mps2: Positive
    tilt_accel_mps2: Positive
    yaw_rate_radps: NotNegative
    hold_mps: tuple[NotNegative, NotNegative]
    land_mps: Positive

    def gains(self) -> Array:
        """(19,) masses, limits and gains in the order in which `control` reads them."""
        body = (self.mass_kg, *self.inertia, self.max_thrust_n)
        loops = (*self.position_p, *self.velocity_p, *self.velocity_i, *self.attitude_p, *self.rate_p)
        return np.array((*body, *loops, self.tilt_accel_mps2, self.yaw_rate_radps, *self.hold_mps))

    def allocation(self) -> Array:
        """(4, 4) rotor thrusts [N] from collective thrust [N] and body torques [N m]."""
        x, y = np.array(self.rotors).T
        effect = np.vstack([np.ones(4), y, -x, self.moment_m * np.array(self.spins)])
        return np.ascontiguousarray(np.linalg.inv(effect))


@jit
def parts_of(numbers: Array) -> tuple[Array, Array, Array, Array, Array, Array, Array]:
    """Velocity, hold (3,), memory (7,), gains (19,), allocation (4, 4), orders (3,), thrust (4,) in `numbers` (55,)."""
    velocity, hold, memory = numbers[:_HOLD], numbers[_HOLD:_MEMORY], numbers[_MEMORY:_GAINS]
    gains, allocation = numbers[_GAINS:_ALLOCATION], numbers[_ALLOCATION:_ORDERS].reshape((4, 4))
    return velocity, hold, memory, gains, allocation, numbers[_ORDERS:_THRUST], numbers[_THRUST:NUMBERS]


@jit
def outer(estimate: Array, numbers: Array) -> tuple[float, float, float]:
    """One 240 Hz step of the outer loops; writes memory, and returns the wanted force [N, world].

    In VELOCITY_MODE it follows the velocity (3,) [m/s, world]; in HOLD_MODE it flies to and holds `hold` (3,)
    [m, world]; in LAND_MODE it sinks above `hold`, in LEVEL_MODE it sinks level and drifts, both at the vertical
    velocity.

    Args:
        estimate: (33,) numbers of the estimator.
        numbers: (55,) see `parts_of`; the orders are the mode, the heading to take [rad], and the greatest change of
            the velocity setpoint [m/s2].
    """
    state, _, _, _, _ = estimator.parts_of(estimate)
    velocity_sp, hold, memory, gains, _, orders, _ = parts_of(numbers)
    mode, yaw_sp, accel_mps2, dt_s = int(orders[_MODE]), orders[_YAW], orders[_ACCEL], 1.0 / STEP_HZ
    mass = gains[0]
    target = np.zeros(3)
    if mode == VELOCITY_MODE:
        target[:] = velocity_sp
    else:
        if mode != LEVEL_MODE:
            ex, ey = gains[5] * (hold[0] - state[0]), gains[5] * (hold[1] - state[1])
            e = math.sqrt(ex * ex + ey * ey)
            scale = 1.0 if e <= gains[17] else gains[17] / e
            target[0], target[1] = ex * scale, ey * scale
        if mode == HOLD_MODE:
            target[2] = min(gains[18], max(-gains[18], gains[6] * (hold[2] - state[2])))
        else:
            target[2] = velocity_sp[2]

    dx, dy, dz = target[0] - memory[0], target[1] - memory[1], target[2] - memory[2]
    change = math.sqrt(dx * dx + dy * dy + dz * dz)
    share = 1.0 if change <= accel_mps2 * dt_s else accel_mps2 * dt_s / change
    memory[0] += share * dx
    memory[1] += share * dy
    memory[2] += share * dz

    accel = np.zeros(3)
    for i in range(3):
        axis = 1 if i == 2 else 0
        if mode == LEVEL_MODE and i < 2:
            continue
        error = memory[i] - state[3 + i]
        memory[3 + i] = min(3.0, max(-3.0, memory[3 + i] + gains[9 + axis] * error * dt_s))
        accel[i] = gains[7 + axis] * error + memory[3 + i]
    horizontal = math.sqrt(accel[0] * accel[0] + accel[1] * accel[1])
    if horizontal > gains[15]:
        accel[0] *= gains[15] / horizontal
        accel[1] *= gains[15] / horizontal
    fx, fy, fz = mass * accel[0], mass * accel[1], mass * max(0.2 * GRAVITY_MPS2, GRAVITY_MPS2 + accel[2])

    turned = yaw_sp - memory[6]
    turned -= 2.0 * math.pi * math.floor(turned / (2.0 * math.pi) + 0.5)
    memory[6] += min(gains[16] * dt_s, max(-gains[16] * dt_s, turned))
    return fx, fy, fz


@jit
def control(estimate: Array, numbers: Array) -> None:
    """One 240 Hz step of the cascade; writes memory and thrust, and stops where a thrust is no finite number.

    It follows `outer`; in STOPPED_MODE there is no thrust.

    Args:
        estimate, numbers: as `outer`.
    """
    _, r, _, rate, _ = estimator.parts_of(estimate)
    _, _, memory, gains, allocation, orders, thrust = parts_of(numbers)
    if int(orders[_MODE]) == STOPPED_MODE:
        thrust[:] = 0.0
        return
    fx, fy, fz = outer(estimate, numbers)
    collective = fx * r[0, 2] + fy * r[1, 2] + fz * r[2, 2]
    norm = math.sqrt(fx * fx + fy * fy + fz * fz)
    cx, cy = math.cos(memory[6]), math.sin(memory[6])
    zx, zy, zz = fx / norm, fy / norm, fz / norm
    yx, yy, yz = -zz * cy, zz * cx, zx * cy - zy * cx
    n = math.sqrt(yx * yx + yy * yy + yz * yz)
    yx, yy, yz = yx / n, yy / n, yz / n
    xx, xy, xz = yy * zz - yz * zy, yz * zx - yx * zz, yx * zy - yy * zx
    # Error of attitude as half the antisymmetric part of R_desired^T R, in the body frame.
    e0 = 0.5 * ((zx * r[0, 1] + zy * r[1, 1] + zz * r[2, 1]) - (yx * r[0, 2] + yy * r[1, 2] + yz * r[2, 2]))
    e1 = 0.5 * ((xx * r[0, 2] + xy * r[1, 2] + xz * r[2, 2]) - (zx * r[0, 0] + zy * r[1, 0] + zz * r[2, 0]))
    e2 = 0.5 * ((yx * r[0, 0] + yy * r[1, 0] + yz * r[2, 0]) - (xx * r[0, 1] + xy * r[1, 1] + xz * r[2, 1]))
    jx, jy, jz = gains[1], gains[2], gains[3]
    p, q, s = rate[0], rate[1], rate[2]
    tx = jx * gains[13] * (-gains[11] * e0 - p) + (q * jz * s - s * jy * q)
    ty = jy * gains[13] * (-gains[11] * e1 - q) + (s * jx * p - p * jz * s)
    tz = jz * gains[14] * (-gains[12] * e2 - s) + (p * jy * q - q * jx * p)
    finite = True
    for i in range(4):
        t = allocation[i, 0] * collective + allocation[i, 1] * tx + allocation[i, 2] * ty + allocation[i, 3] * tz
        finite = finite and math.isfinite(t)
        thrust[i] = min(gains[4], max(0.0, t))
    if not finite:
        orders[_MODE] = STOPPED_MODE
        thrust[:] = 0.0


@jit
def stabilise(now_s: float, stamp_s: float, rate: Array, force: Array, numbers: Numbers) -> Array:
    """One 240 Hz step: integrate the inertial sample; returns the thrust of each rotor (4,) [N].

    Args:
        now_s, stamp_s, rate, force: of `estimator.integrate`.
        numbers: (33,) of the estimator, (55,) of flight control.
    """
    estimate, controlled = numbers
    estimator.integrate(now_s, stamp_s, rate, force, estimate)
    control(estimate, controlled)
    return controlled[_THRUST:NUMBERS]


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

    command_hold_s: NotNegative
    command_land_s: NotNegative
    fix_level_s: NotNegative
    imu_stop_s: NotNegative


class FlightControl:
    """Follows velocity commands, holds, takes off, lands; falls back to a fail-safe when its inputs stop.

    It is its own fast path: estimator and control as one kernel.  A flight control that is no kernel derives from it.

    Attributes:
        mode: its present mode, one of "takeoff", "offboard", "hold", "land", "level", "stopped".
        numbers: (55,) argument of `control`, see `parts_of`.
        seams: the seams that the kernel skips.
        kernel: the compiled step.
    """

    seams = ("imu", "thrust")
    kernel = staticmethod(stabilise)

    def __init__(self, config: ControlConfig, failsafe: FailsafeConfig, estimator: Estimator, yaw_rad: float) -> None:
        self.config, self.failsafe, self.estimator = config, failsafe, estimator
        self.numbers = np.zeros(NUMBERS)
        self._velocity, self._hold, memory, gains, allocation, self._orders, self._thrust = parts_of(self.numbers)
        gains[:], allocation[:] = config.gains(), config.allocation()
        memory[HEADING] = self._orders[_YAW] = yaw_rad
        self.mode, self._commanded_s = "takeoff", 0.0
        self._enter("takeoff", HOLD_MODE)

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
        self._orders[:] = VELOCITY_MODE, order.yaw_rad, accel_mps2
        self.mode = "offboard"

    def watch(self, now_s: float) -> None:
        """Check the time-outs, at 20 Hz."""
        silent_s = now_s - self._commanded_s
        if self.mode == "offboard" and silent_s > self.failsafe.command_hold_s:
            self._enter("hold", HOLD_MODE)
        if self.mode == "hold" and silent_s > self.failsafe.command_land_s:
            self._sink("land", LAND_MODE, self.config.land_mps)
        if self.mode not in ("level", "stopped") and now_s - self.estimator.last_fix_s > self.failsafe.fix_level_s:
            self._sink("level", LEVEL_MODE, self.config.land_mps)

    @property
    def fast_path(self) -> FastPath | None:
        """`step`, compiled; None where there is no such kernel."""
        return self

    def deliver(self, now_s: float, frames: SensorFrames) -> None:
        """Take what the sensors deliver at a tick, beside the fix of the estimator: ours needs nothing of it."""

    def close(self) -> None:
        """End what it started; may be called twice."""

    def step(self, now_s: float, imu: Imu | None, felt: Imu | None = None) -> Thrust:
        """One 240 Hz step: integrate the inertial sample, if one arrived, and return the thrust.

        Args:
            now_s: time since the start [s].
            imu: the sample that arrived.
            felt: the sample of the sensor, for a flight control with seams of its own.
        """
        self.sense(now_s, imu)
        control(self.estimator.numbers, self.numbers)
        self.end()
        return Thrust(self._thrust.copy())

    def sense(self, now_s: float, imu: Imu | None) -> None:
        """Integrate the inertial sample; without one for too long the rotors stop."""
        if imu is not None:
            self.estimator.inertial(now_s, imu)
        elif now_s - self.estimator.last_imu_s > self.failsafe.imu_stop_s:
            self._orders[_MODE] = STOPPED_MODE

    def target(self) -> tuple[Array, float]:
        """The velocity (3,) [m/s, world] and the heading [rad] that the outer loop wants now, within their rates."""
        _, _, memory, _, _, _, _ = parts_of(self.numbers)
        return memory[:3].copy(), float(memory[HEADING])

    def begin(self) -> Numbers:
        """The arrays of estimator and flight control, not copies of them."""
        return self.estimator.numbers, self.numbers

    def end(self) -> None:
        """Note whether a step stopped the rotors."""
        if self._orders[_MODE] == STOPPED_MODE:
            self.mode = "stopped"

    def _sink(self, mode: str, kernel_mode: int, limit_mps: float) -> None:
        self._enter(mode, kernel_mode)
        self._velocity[:] = 0.0, 0.0, -min(limit_mps, self.config.land_mps)

    def _enter(self, mode: str, kernel_mode: int) -> None:
        self.mode = mode
        self._orders[_MODE], self._orders[_ACCEL] = kernel_mode, self.config.accel_mps2
        self._hold[:] = self.estimator.state[:3]


class MakeFlightControl(Protocol):
    """Makes what flies below a stack, usually the class."""

    def __call__(
        self, config: ControlConfig, failsafe: FailsafeConfig, estimator: Estimator, yaw_rad: float, /
    ) -> FlightControl:
        """Make it for a flight that starts with this heading."""
        ...
