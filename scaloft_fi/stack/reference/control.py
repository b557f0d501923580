"""Cascaded flight control in the manner of PX4: velocity, attitude, body rate, rotor allocation; compiled.

Gains are PX4's defaults where PX4 has them (MPC_XY_P 0.95, MPC_XY_VEL_P/I_ACC 1.8/0.4, MPC_Z_P 1, MPC_Z_VEL_P/I_ACC
4/2, MC_ROLL_P 6.5, MC_YAW_P 2.8, MPC_YAWRAUTO_MAX 45 deg/s).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from scaloft_fi.stack.config import Positive
from scaloft_fi.stack.fields import Array
from scaloft_fi.stack.kernel import jit
from scaloft_fi.stack.reference.strapdown import GRAVITY_MPS2

VELOCITY_MODE, HOLD_MODE, LAND_MODE, LEVEL_MODE = 0, 1, 2, 3

# Layout of the controller's memory: slewed velocity setpoint, integrators, slewed heading setpoint.
SETPOINT, INTEGRAL, HEADING, MEMORY_SIZE = 0, 3, 6, 7

# Layout of the numbers of flight control: velocity, hold, memory, gains, allocation, thrust.
_HOLD, _MEMORY, _GAINS = 3, 6, 6 + MEMORY_SIZE
_ALLOCATION = _GAINS + 19
_THRUST, NUMBERS = _ALLOCATION + 16, _ALLOCATION + 20


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
    rotors: tuple[tuple[float, float], ...]
    spins: tuple[float, ...]
    moment_m: Positive
    max_thrust_n: Positive
    position_p: tuple[float, float]
    velocity_p: tuple[float, float]
    velocity_i: tuple[float, float]
    attitude_p: tuple[float, float]
    rate_p: tuple[float, float]
    accel_mps2: float
    tilt_accel_mps2: float
    yaw_rate_radps: float
    hold_mps: tuple[float, float]
    land_mps: float

    def gains(self) -> Array:
        """(19,) masses, limits and gains in the order in which `control` reads them."""
        return np.array(
            [
                self.mass_kg,
                *self.inertia,
                self.max_thrust_n,
                *self.position_p,
                *self.velocity_p,
                *self.velocity_i,
                *self.attitude_p,
                *self.rate_p,
                self.tilt_accel_mps2,
                self.yaw_rate_radps,
                *self.hold_mps,
            ]
        )

    def allocation(self) -> Array:
        """(4, 4) rotor thrusts [N] from collective thrust [N] and body torques [N m]."""
        x, y = np.array(self.rotors).T
        effect = np.vstack([np.ones(4), y, -x, self.moment_m * np.array(self.spins)])
        return np.ascontiguousarray(np.linalg.inv(effect))


@jit
def parts_of(numbers: Array) -> tuple[Array, Array, Array, Array, Array, Array]:
    """Velocity and hold (3,), memory (7,), gains (19,), allocation (4, 4), thrust (4,) as views of `numbers` (52,)."""
    return (
        numbers[:_HOLD],
        numbers[_HOLD:_MEMORY],
        numbers[_MEMORY:_GAINS],
        numbers[_GAINS:_ALLOCATION],
        numbers[_ALLOCATION:_THRUST].reshape((4, 4)),
        numbers[_THRUST:NUMBERS],
    )


@jit
def control(
    state: Array,
    r: Array,
    rate: Array,
    mode: int,
    velocity_sp: Array,
    hold: Array,
    yaw_sp: float,
    accel_mps2: float,
    dt_s: float,
    gains: Array,
    allocation: Array,
    memory: Array,
    thrust: Array,
) -> bool:
    """One 240 Hz step of the cascade; writes `memory` and `thrust`.

    Args:
        state: (16,) estimator state. r: (3, 3) its rotation matrix. rate: (3,) body rate [rad/s].
        mode: VELOCITY_MODE follows `velocity_sp` (3,) [m/s, world]; HOLD_MODE flies to and holds `hold` (3,)
            [m, world]; LAND_MODE sinks above `hold`, LEVEL_MODE sinks level and
            drifts, both at the vertical velocity of `velocity_sp`.
        yaw_sp: heading to take [rad]. accel_mps2: greatest change of the velocity setpoint [m/s2].
        thrust: (4,) receives the rotor thrusts [N].

    Returns:
        Whether all thrusts are finite numbers.
    """
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
    collective = fx * r[0, 2] + fy * r[1, 2] + fz * r[2, 2]
    norm = math.sqrt(fx * fx + fy * fy + fz * fz)

    turned = yaw_sp - memory[6]
    turned -= 2.0 * math.pi * math.floor(turned / (2.0 * math.pi) + 0.5)
    memory[6] += min(gains[16] * dt_s, max(-gains[16] * dt_s, turned))
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
    return finite
