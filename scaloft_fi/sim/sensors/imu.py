"""Inertial sensor, 240 Hz: a strapdown gyroscope and accelerometer with bias and white noise."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from scaloft_fi.document import Item
from scaloft_fi.sim.build import GRAVITY_MPS2
from scaloft_fi.stack.declaration import STEP_S
from scaloft_fi.stack.kernel import jit
from scaloft_fi.stack.messages import Imu
from scaloft_fi.streams import Array, Table, generator

NUMBERS = 21


@dataclass(frozen=True)
class ImuConfig:
    """Errors of the inertial sensor; the biases are drawn once per flight.

    Attributes:
        rate_sigma_radps, rate_bias_radps: white noise per sample, standard deviation of the bias [rad/s].
        force_sigma_mps2, force_bias_mps2: white noise per sample, standard deviation of the bias [m/s2].
    """

    rate_sigma_radps: float
    rate_bias_radps: float
    force_sigma_mps2: float
    force_bias_mps2: float

    @classmethod
    def read(cls, item: Item) -> ImuConfig:
        """Read the `imu` of `sensors.yaml`."""
        config = cls(
            rate_sigma_radps=item.need("rate_sigma_radps").number(least=0.0),
            rate_bias_radps=item.need("rate_bias_radps").number(least=0.0),
            force_sigma_mps2=item.need("force_sigma_mps2").number(least=0.0),
            force_bias_mps2=item.need("force_bias_mps2").number(least=0.0),
        )
        item.close()
        return config


class ImuSensor:
    """Measures angular rate and specific force; the acceleration is the change of velocity over the last step.

    Attributes:
        noise: noise of each sample.
        numbers: (21,) arguments of `inertial`, see `parts_of`.
    """

    def __init__(self, config: ImuConfig, *stream: object) -> None:
        self.noise = Table(6, *stream, "imu")
        bias = np.repeat(np.array([config.rate_bias_radps, config.force_bias_mps2], np.float64), 3)
        bias *= generator(*stream, "imu bias").standard_normal(6)
        sigma = np.repeat(np.array([config.rate_sigma_radps, config.force_sigma_mps2], np.float64), 3)
        self.numbers = np.zeros(NUMBERS)
        self._before, self._errors, _ = parts_of(self.numbers)
        self._errors[:] = bias, sigma
        self._measured = False

    def begin(self, state: Array) -> None:
        """Before the first sample, set the velocity one step earlier to that of `state` (13,)."""
        if not self._measured:
            self._measured = True
            self._before[:] = state[7:10]

    def measure(self, step: int, state: Array) -> Imu:
        """The sample of physics step `step` from the vehicle's true `state` (13,)."""
        self.begin(state)
        reading = np.empty((2, 3))
        inertial(state, self._before, self.noise.row(step), self._errors, reading)
        return Imu(step * STEP_S, reading[0], reading[1])


@jit
def parts_of(numbers: Array) -> tuple[Array, Array, Array]:
    """Velocity one step earlier (3,), errors (2, 6), reading (2, 3) as views of `numbers` (21,); see `inertial`."""
    return numbers[:3], numbers[3:15].reshape((2, 6)), numbers[15:NUMBERS].reshape((2, 3))


@jit
def inertial(state: Array, before: Array, noise: Array, errors: Array, reading: Array) -> None:
    """Write the `reading` of the sensor, and copy the velocity of `state` into `before` (3,).

    Args:
        state: (13,) state of the vehicle.
        before: (3,) velocity one step earlier [m/s, world].
        noise: (6,) standard normal numbers.
        errors: (2, 6) bias and standard deviation of rate x, y, z and force x, y, z.
        reading: (2, 3) receives body rate [rad/s] and specific force [m/s2].
    """
    x, y, z, w = state[3], state[4], state[5], state[6]
    r = np.empty((3, 3))
    r[0, 0], r[0, 1], r[0, 2] = 1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)
    r[1, 0], r[1, 1], r[1, 2] = 2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)
    r[2, 0], r[2, 1], r[2, 2] = 2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)
    for i in range(3):
        turn, push = 0.0, 0.0
        for k in range(3):
            felt = (state[7 + k] - before[k]) / STEP_S + (GRAVITY_MPS2 if k == 2 else 0.0)
            turn += r[k, i] * state[10 + k]
            push += r[k, i] * felt
        reading[0, i] = turn + errors[0, i] + errors[1, i] * noise[i]
        reading[1, i] = push + errors[0, 3 + i] + errors[1, 3 + i] * noise[3 + i]
    for k in range(3):
        before[k] = state[7 + k]
