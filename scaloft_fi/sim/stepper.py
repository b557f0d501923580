"""Steppers make the physics steps of a flight: in the physics server, or compiled where no contact is possible.

Both steppers compute the same bits.

The bits may differ on a processor that fuses multiplication and addition, or with another version of the server.  Then
the server makes every step.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Protocol

import numpy as np

from scaloft_fi.sim import vehicle
from scaloft_fi.sim.build import physics_server, set_up
from scaloft_fi.sim.sensors import body
from scaloft_fi.sim.sensors.body import ImuSensor, inertial
from scaloft_fi.sim.vehicle import Airframe, Array, Drive, Vehicle, actuate, free_step
from scaloft_fi.stack.declaration import STEP_HZ, STEP_S, FastPath, Kernel, Numbers
from scaloft_fi.stack.kernel import jit, joined, with_globals


class Stepper(Protocol):
    """Makes physics steps; each step includes inertial sensor, flight control and rotors."""

    def advance(self, first: int, count: int) -> float:
        """Make `count` steps, beginning with number `first`.

        Returns:
            The greatest square of the speed after a step [m2/s2].
        """
        ...


class ServerStepper:
    """Lets the physics server make the steps; Python calls sensor, stack and rotors before each step.

    Args:
        airframe: the vehicle.
        drive: sets force and torque of the vehicle before a step.
    """

    def __init__(self, airframe: Airframe, drive: Drive) -> None:
        self._airframe, self._drive = airframe, drive

    def advance(self, first: int, count: int) -> float:
        """Make the steps in the server; contacts are allowed."""
        return self._airframe.step(self._drive, first, count)


STEPS = 240
"""Number of steps that are compared: one second."""
BLOCK = Vehicle(
    1.3, (0.011, 0.017, 0.023), (0.4, 0.3, 0.1), ((0.0, 0.0),) * 4, (1, 1, 1, 1),
    moment_m=0.01, max_thrust_n=8.0, spin_up_s=0.05, spin_down_s=0.05, drag_ns_per_m=0.0,
)  # fmt: skip
"""The body of the test; no two of its moments of inertia are equal."""


@cache
def agrees() -> bool:
    """Whether a block that tumbles under changing forces has the same state, to the bit, in both."""
    with physics_server() as client:
        set_up(client)
        return _tumbles_alike(Airframe(client, BLOCK, (0.1, -0.2, 5.0), 0.3))


def _tumbles_alike(airframe: Airframe) -> bool:
    state, inverse = airframe.state.copy(), airframe.inverse_attitude().copy()
    pushes = np.random.default_rng(0).normal(0.0, (9.0, 9.0, 9.0, 0.3, 0.3, 0.3), (STEPS, 6))
    for step in range(STEPS):
        airframe.pushed[:] = pushes[step]
        airframe.step(lambda _step: None, step, 1)
        free_step(state, inverse, pushes[step], airframe.inertia)
        if state.tobytes() != airframe.state.tobytes():
            return False
    return inverse.tobytes() == airframe.inverse_attitude().tobytes()


Loop = Callable[[Array, int, int, int, Array, Array, Array, Array, Numbers], float]


class CompiledStepper:
    """Makes steps without contact outside the physics server; the server then gets the last state.

    Args:
        fast_path: fast path of the stack.
        sensor: the inertial sensor.
        airframe: the vehicle.
    """

    def __init__(self, fast_path: FastPath, sensor: ImuSensor, airframe: Airframe) -> None:
        self._fast_path, self._sensor, self._airframe = fast_path, sensor, airframe
        self._loop = loop_with(fast_path.kernel)
        self._numbers: Numbers = ()

    def begin(self) -> None:
        """Prepare the stack for `advance`; any exception here is a failure of the stack before the first step."""
        self._numbers = self._fast_path.begin()

    def advance(self, first: int, count: int) -> float:
        """Make the steps; valid only where the vehicle can touch nothing and no wire listens on the skipped seams."""
        sensor, airframe, numbers, top_square = self._sensor, self._airframe, self._numbers, 0.0
        sensor.begin(airframe.state)
        inverse, last = airframe.inverse_attitude(), first + count
        while first < last:
            noise, row = sensor.noise.place(first)
            steps = min(last - first, len(noise) - row)
            square = self._loop(
                noise, row, first, steps, sensor.numbers, airframe.numbers, inverse, airframe.inertia, numbers
            )
            top_square = max(top_square, square)
            first += steps
        airframe.update_server()
        self._fast_path.end()
        return top_square


@cache
def loop_with(kernel: Kernel) -> Loop:
    """Compile `_loop` with the kernel of the stack."""
    return jit(joined(inertial, actuate, free_step)(with_globals(_loop, kernel=kernel)))


def _loop(
    noise: Array, row: int, first: int, count: int,
    sensor: Array, airframe: Array, inverse: Array, inertia: Array, numbers: Numbers,
) -> float:  # fmt: skip
    """Make `count` steps, beginning with number `first`; returns the greatest square of the speed [m2/s2].

    Args:
        noise: (N, 6) noise of the inertial samples.
        row: row of `noise` for the first sample.
        sensor: (21,) numbers of the inertial sensor.
        airframe: (46,) numbers of the vehicle.
        inverse, inertia: (4,), (5,) arguments of `free_step`.
        numbers: numbers of the stack's kernel.
    """
    before, errors, reading = body.parts_of(sensor)
    state, thrusts, pushed, lag, effect = vehicle.parts_of(airframe)
    top_square = 0.0
    for i in range(count):
        step = first + i
        inertial(state, before, noise[row + i], errors, reading)
        order = kernel(step / STEP_HZ, step * STEP_S, reading[0], reading[1], numbers)  # type: ignore[name-defined] # noqa: F821 - `loop_with` gives it
        actuate(thrusts, order, lag, effect, state, pushed)
        top_square = max(top_square, free_step(state, inverse, pushed, inertia))
    return top_square
