"""Make physics steps in one compiled call: inertial sensor, fast path of the stack, rotors and free flight."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

from scaloft_fi.sim import vehicle
from scaloft_fi.sim.airframe import Airframe
from scaloft_fi.sim.free_flight import free_step
from scaloft_fi.sim.sensors import imu
from scaloft_fi.sim.sensors.imu import ImuSensor, inertial
from scaloft_fi.sim.vehicle import Array, actuate
from scaloft_fi.stack.declaration import STEP_HZ, STEP_S, FastPath, Kernel, Numbers
from scaloft_fi.stack.kernel import jit, joined, with_globals

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
    before, errors, reading = imu.parts_of(sensor)
    state, thrusts, pushed, lag, effect = vehicle.parts_of(airframe)
    top_square = 0.0
    for i in range(count):
        step = first + i
        inertial(state, before, noise[row + i], errors, reading)
        order = kernel(step / STEP_HZ, step * STEP_S, reading[0], reading[1], numbers)  # type: ignore[name-defined] # noqa: F821 - `loop_with` gives it
        actuate(thrusts, order, lag, effect, state, pushed)
        top_square = max(top_square, free_step(state, inverse, pushed, inertia))
    return top_square
