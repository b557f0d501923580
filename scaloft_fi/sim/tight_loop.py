"""Physics steps with inertial sensor, stack and rotors in one compiled call each, while nobody listens between them.

A tapped seam is served by the stack's own `step`; a flight has the same bits either way.
"""

from __future__ import annotations

from scaloft_fi.sim import vehicle
from scaloft_fi.sim.body import Body
from scaloft_fi.sim.build import STEP_S
from scaloft_fi.sim.sensors import imu
from scaloft_fi.sim.sensors.imu import ImuSensor, inertial
from scaloft_fi.sim.vehicle import Array, actuate
from scaloft_fi.stack import control, strapdown
from scaloft_fi.stack.estimator import IMU_GAP_S
from scaloft_fi.stack.inner_loop import STOPPED_MODE, InnerLoop, stabilise
from scaloft_fi.stack.kernel import jit, joined
from scaloft_fi.stack.seam import STEP_HZ, Wire

SKIPPED = ("imu", "thrust")
"""The seams that it leaves out."""


class TightLoop:
    """The physics steps of a flight, tick by tick: `begin`, `drive` before each step, `end`.

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
