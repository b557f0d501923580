"""Whether compiled free flight and the physics server compute the same bits on this machine; tested once per process.

The bits may differ on a processor that fuses multiplication and addition, or with another version of the server.  Then
the server makes every step.
"""

from __future__ import annotations

from functools import cache

import numpy as np

from scaloft_fi.sim.airframe import Airframe
from scaloft_fi.sim.build import connect, set_up
from scaloft_fi.sim.free_flight import free_step
from scaloft_fi.sim.vehicle import Vehicle

STEPS = 240
"""Number of steps that are compared: one second."""
BLOCK = Vehicle(
    mass_kg=1.3,
    inertia=(0.011, 0.017, 0.023),
    hull_m=(0.4, 0.3, 0.1),
    rotors=np.zeros((4, 2)),
    spins=np.ones(4),
    moment_m=0.01,
    max_thrust_n=8.0,
    spin_up_s=0.05,
    spin_down_s=0.05,
    drag=0.0,
)
"""The body of the test; no two of its moments of inertia are equal."""


@cache
def agrees() -> bool:
    """Whether a block that tumbles under changing forces has the same state, to the bit, in both."""
    import pybullet

    client = connect()
    try:
        set_up(client)
        return _tumbles_alike(Airframe(client, BLOCK, (0.1, -0.2, 5.0), 0.3))
    finally:
        pybullet.disconnect(physicsClientId=client)


def _tumbles_alike(airframe: Airframe) -> bool:
    state, inverse = airframe.state.copy(), airframe.inverse_attitude().copy()
    pushes = np.random.default_rng(0).normal(0.0, (9.0, 9.0, 9.0, 0.3, 0.3, 0.3), (STEPS, 6))
    pushed = airframe.pushed

    def drive(step: int) -> None:
        pushed[:] = pushes[step]

    for step in range(STEPS):
        airframe.step(drive, step, 1)
        free_step(state, inverse, pushes[step], airframe.inertia)
        if state.tobytes() != airframe.state.tobytes():
            return False
    return inverse.tobytes() == airframe.inverse_attitude().tobytes()
