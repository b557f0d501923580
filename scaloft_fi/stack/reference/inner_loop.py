"""The autopilot's 240 Hz part as one compiled step: the fast path of the reference stack.

It calls the same kernels on the same numbers as `FlightControl.step`, in the same order.
"""

from __future__ import annotations

import numpy as np

from scaloft_fi.stack.fast_path import Numbers
from scaloft_fi.stack.fields import Array
from scaloft_fi.stack.kernel import jit, joined
from scaloft_fi.stack.rates import STEP_HZ
from scaloft_fi.stack.reference import control, strapdown
from scaloft_fi.stack.reference.estimator import Estimator
from scaloft_fi.stack.reference.flight_control import FlightControl

STOPPED_MODE = -1

# Layout of the orders, which hold for a tick: mode of `control` or STOPPED_MODE, heading, change of the velocity.
_MODE, _YAW, _ACCEL, _ORDERS = 0, 1, 2, 3


@jit
@joined(strapdown.integrate, control.control)
def stabilise(now_s: float, stamp_s: float, rate: Array, force: Array, numbers: Numbers) -> Array:
    """One 240 Hz step: integrate the inertial sample; returns the thrust of each rotor (4,) [N].

    Args:
        now_s, stamp_s, rate, force: of `strapdown.integrate`.
        numbers: (33,) of the estimator, (52,) of flight control, (3,) orders.
    """
    estimate, controlled, orders = numbers
    state, r, _, body_rate, _ = strapdown.parts_of(estimate)
    velocity_sp, hold, memory, gains, allocation, thrust = control.parts_of(controlled)
    strapdown.integrate(now_s, stamp_s, rate, force, estimate)
    mode = int(orders[_MODE])
    if mode == STOPPED_MODE or not control.control(
        state, r, body_rate, mode, velocity_sp, hold, orders[_YAW], orders[_ACCEL], 1.0 / STEP_HZ,
        gains, allocation, memory, thrust,
    ):  # fmt: skip
        orders[_MODE] = STOPPED_MODE
        thrust[:] = 0.0
    return thrust


class InnerLoop:
    """Estimator and flight control as one kernel.

    Attributes:
        seams: the seams that the kernel skips.
        kernel: the compiled step.
    """

    seams = ("imu", "thrust")
    kernel = staticmethod(stabilise)

    def __init__(self, estimator: Estimator, flight_control: FlightControl) -> None:
        self._control, self._orders = flight_control, np.empty(_ORDERS)
        self._numbers = (estimator.numbers, flight_control.numbers, self._orders)

    def begin(self) -> Numbers:
        """The arrays of estimator and flight control, not copies of them, and the orders of this tick."""
        control = self._control
        mode = STOPPED_MODE if control.mode == "stopped" else control.kernel_mode
        self._orders[:] = mode, control.yaw_rad, control.accel_mps2
        return self._numbers

    def end(self) -> None:
        """Stop flight control if the kernel stopped the rotors."""
        if self._orders[_MODE] == STOPPED_MODE:
            self._control.mode = "stopped"
