"""The autopilot's 240 Hz part as one compiled step, for a flight loop in which nobody listens to what it is sent.

The same kernels on the same numbers as `FlightControl.step`, in the same order.
"""

from __future__ import annotations

from scaloft_fi.stack.fields import Array
from scaloft_fi.stack.kernel import jit, joined
from scaloft_fi.stack.reference import control, strapdown
from scaloft_fi.stack.reference.estimator import IMU_GAP_S, Estimator
from scaloft_fi.stack.reference.flight_control import FlightControl

STOPPED_MODE = -1


class InnerLoop:
    """Estimator and flight control as `stabilise` takes them.

    Attributes:
        estimate, control: (31,), (52,) their numbers themselves, not copies.
    """

    def __init__(self, estimator: Estimator, flight_control: FlightControl) -> None:
        self._estimator, self._control = estimator, flight_control
        self.estimate, self.control = estimator.numbers, flight_control.numbers

    @property
    def stamp_s(self) -> float:
        """Stamp of the last inertial sample [s]."""
        return self._estimator.stamp_s

    @property
    def heard_s(self) -> float:
        """Time of the last inertial sample that was used [s]."""
        return self._estimator.last_imu_s

    @property
    def mode(self) -> int:
        """What flight control does now, as `stabilise` takes it."""
        return STOPPED_MODE if self._control.mode == "stopped" else self._control.kernel_mode

    @property
    def orders(self) -> tuple[float, float]:
        """Heading to take [rad], and greatest change of the velocity setpoint [m/s2]; they hold for a tick."""
        return self._control.yaw_rad, self._control.accel_mps2

    def note(self, stamp_s: float, heard_s: float, mode: int) -> None:
        """Take note of what the steps came to: the last sample's stamp, when one was last used [s], and the mode."""
        self._estimator.stamp_s, self._estimator.last_imu_s = stamp_s, heard_s
        if mode == STOPPED_MODE:
            self._control.mode = "stopped"


@jit
@joined(strapdown.propagate, control.control)
def stabilise(
    rate: Array, force: Array, dt_s: float, step_s: float, mode: int, yaw_sp: float, accel_mps2: float,
    estimate: Array, controlled: Array,
) -> tuple[bool, Array]:  # fmt: skip
    """One 240 Hz step: integrate the inertial sample; whether the rotors go on, and their thrust (4,) [N].

    Args:
        rate, force: (3,) of the inertial sample [rad/s, m/s2, body], which came `dt_s` [s] after the one before.
        step_s: length of the step [s].
        mode: of `control`, or STOPPED_MODE. yaw_sp, accel_mps2: of `control`.
        estimate, controlled: (31,), (52,) numbers of estimator and flight control.
    """
    state, r, world_force, body_rate = strapdown.parts_of(estimate)
    velocity_sp, hold, memory, gains, allocation, thrust = control.parts_of(controlled)
    if 0.0 < dt_s < IMU_GAP_S:
        strapdown.propagate(state, rate, force, dt_s, r, world_force, body_rate)
    goes_on = mode != STOPPED_MODE and control.control(
        state, r, body_rate, mode, velocity_sp, hold, yaw_sp, accel_mps2, step_s, gains, allocation, memory, thrust
    )
    if not goes_on:
        thrust[:] = 0.0
    return goes_on, thrust
