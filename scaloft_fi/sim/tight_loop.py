"""Physics steps with inertial sensor, stack and rotors in compiled calls, while nobody listens between them.

One call a step where the server steps, one for many where the vehicle can touch nothing.  A tapped seam is served by
the stack's own `step`, and then the server steps; a flight has the same bits either way.
"""

from __future__ import annotations

from scaloft_fi.sim import vehicle
from scaloft_fi.sim.body import Body
from scaloft_fi.sim.build import STEP_S
from scaloft_fi.sim.free_flight import free_step
from scaloft_fi.sim.sensors import imu
from scaloft_fi.sim.sensors.imu import ImuSensor, inertial
from scaloft_fi.sim.vehicle import Array, actuate
from scaloft_fi.stack.kernel import jit, joined
from scaloft_fi.stack.reference import control, strapdown
from scaloft_fi.stack.reference.estimator import IMU_GAP_S
from scaloft_fi.stack.reference.inner_loop import STOPPED_MODE, InnerLoop, stabilise
from scaloft_fi.stack.seam import STEP_HZ, Wire

SKIPPED = ("imu", "thrust")
"""The seams that it leaves out."""


class TightLoop:
    """The physics steps of a flight, tick by tick: `begin`, `drive` before each step or `run` for all, `end`.

    Args:
        inner: of the stack.
        sensor: the inertial sensor.
        body: the vehicle.
        wire: of the stack.
    """

    def __init__(self, inner: InnerLoop, sensor: ImuSensor, body: Body, wire: Wire) -> None:
        self._inner, self._sensor, self._body, self._wire = inner, sensor, body, wire

    @property
    def free(self) -> bool:
        """Whether nobody listens."""
        return not any(map(self._wire.listens, SKIPPED))

    def begin(self) -> None:
        """Get ready for the steps up to the next tick."""
        inner, sensor, body = self._inner, self._sensor, self._body
        self._mode, self._stamp_s, self._heard_s = inner.mode, inner.stamp_s, inner.heard_s
        sensor.begin(body.state)
        self._arguments = (*inner.orders, sensor.numbers, body.numbers, inner.estimate, inner.control)

    def drive(self, step: int) -> None:
        """All that physics step number `step` needs: inertial sensor, stack and rotors."""
        stamp_s = step * STEP_S
        dt_s, self._stamp_s = stamp_s - self._stamp_s, stamp_s
        if 0.0 < dt_s < IMU_GAP_S:
            self._heard_s = step / STEP_HZ
        noise, row = self._sensor.noise.place(step)
        if not tight(noise, row, dt_s, self._mode, *self._arguments):
            self._mode = STOPPED_MODE

    def run(self, first: int, count: int) -> float:
        """Fly `count` steps from number `first` on, in which nothing can be touched.

        Returns:
            The greatest square of the speed after a step [m2/s2].
        """
        body, top_square = self._body, 0.0
        turned, last = body.turned(), first + count
        while first < last:
            noise, row = self._sensor.noise.place(first)
            steps = min(last - first, len(noise) - row)
            self._stamp_s, self._heard_s, self._mode, square = free(
                noise, row, first, steps, self._stamp_s, self._heard_s, self._mode, *self._arguments,
                turned, body.inertia,
            )  # fmt: skip
            top_square = max(top_square, square)
            first += steps
        body.follow()
        return top_square

    def end(self) -> None:
        """Leave the stack as its own steps would have left it."""
        self._inner.note(self._stamp_s, self._heard_s, self._mode)


@jit
@joined(inertial, strapdown.propagate, control.control, stabilise, actuate)
def tight(
    noise: Array, row: int, dt_s: float, mode: int, yaw_sp: float, accel_mps2: float,
    sensor: Array, body: Array, estimate: Array, controlled: Array,
) -> bool:  # fmt: skip
    """`inertial`, `stabilise` and `actuate` at once; whether the rotors go on.

    Args:
        noise, row: (N, 6), and which row is the inertial sample's.
        dt_s, mode, yaw_sp, accel_mps2, estimate, controlled: of `stabilise`.
        sensor, body: (21,), (46,) numbers of inertial sensor and vehicle.
    """
    before, errors, reading = imu.parts_of(sensor)
    state, thrusts, pushed, lag, effect = vehicle.parts_of(body)
    inertial(state, before, noise[row], errors, reading)
    goes_on, thrust = stabilise(
        reading[0], reading[1], dt_s, 1.0 / STEP_HZ, mode, yaw_sp, accel_mps2, estimate, controlled
    )
    actuate(thrusts, thrust, lag, effect, state, pushed)
    return goes_on


@jit
@joined(inertial, strapdown.propagate, control.control, stabilise, actuate, free_step)
def free(
    noise: Array, row: int, first: int, count: int, stamp_s: float, heard_s: float, mode: int,
    yaw_sp: float, accel_mps2: float, sensor: Array, body: Array, estimate: Array, controlled: Array,
    turned: Array, inertia: Array,
) -> tuple[float, float, int, float]:  # fmt: skip
    """`count` times `tight` and `free_step`, from step number `first` on.

    Args:
        noise, row: (N, 6), and which row is the first step's.
        stamp_s, heard_s: stamp of the last inertial sample, and when one was last used [s].
        mode, yaw_sp, accel_mps2, sensor, body, estimate, controlled: of `tight`.
        turned, inertia: (4,), (5,) of `free_step`.

    Returns:
        stamp_s, heard_s and mode afterwards, and the greatest square of the speed after a step [m2/s2].
    """
    state, _thrusts, pushed, _lag, _effect = vehicle.parts_of(body)
    top_square = 0.0
    for i in range(count):
        now_s = (first + i) * STEP_S
        dt_s, stamp_s = now_s - stamp_s, now_s
        if 0.0 < dt_s < IMU_GAP_S:
            heard_s = (first + i) / STEP_HZ
        if not tight(noise, row + i, dt_s, mode, yaw_sp, accel_mps2, sensor, body, estimate, controlled):
            mode = STOPPED_MODE
        top_square = max(top_square, free_step(state, turned, pushed, inertia))
    return stamp_s, heard_s, mode, top_square
