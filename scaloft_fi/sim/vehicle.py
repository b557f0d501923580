"""The vehicle: a rigid hull with four rotors, and the force and torque of the rotors."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from scaloft_fi.document import Item
from scaloft_fi.errors import InputError
from scaloft_fi.sim.build import GRAVITY_MPS2
from scaloft_fi.stack.declaration import STEP_S
from scaloft_fi.stack.kernel import jit

Array = NDArray[np.float64]

SMALLEST, LARGEST = 1e-6, 1e4
"""Bounds of every mass, inertia, length, thrust and time of a vehicle, far beyond those of any drone."""

POSITION, ATTITUDE, VELOCITY, RATE = slice(0, 3), slice(3, 7), slice(7, 10), slice(10, 13)
"""Layout of the vehicle's state (13,): position [m, world], attitude quaternion x, y, z, w (body to world),
velocity [m/s, world], angular rate [rad/s, world]."""
STATE_SIZE = 13

# Layout of the numbers of a step: state, thrusts, force and torque, lag, effect.
_THRUSTS, _PUSHED, _LAG, _EFFECT, NUMBERS = 13, 17, 23, 26, 46


@dataclass(frozen=True, eq=False)
class Vehicle:
    """A quadrotor.

    Attributes:
        mass_kg: mass [kg].
        inertia: (3,) principal moments of inertia [kg m2, body].
        hull_m: (3,) edges of the hull, a box about the centre [m, body].
        rotors: (4, 2) positions of the rotors (x, y) [m, body].
        spins: (4,) direction of each rotor's torque, +1 or -1 about body z.
        moment_m: rotor torque per thrust [m].
        max_thrust_n: greatest thrust of one rotor [N].
        spin_up_s, spin_down_s: time constants of the thrust [s].
        drag: drag force per speed [N s/m].
    """

    mass_kg: float
    inertia: tuple[float, float, float]
    hull_m: tuple[float, float, float]
    rotors: Array
    spins: Array
    moment_m: float
    max_thrust_n: float
    spin_up_s: float
    spin_down_s: float
    drag: float

    @property
    def half_height_m(self) -> float:
        """Height of the centre above the floor on which the vehicle stands [m]."""
        return 0.5 * self.hull_m[2]

    def lag(self) -> Array:
        """Argument of `rotor_step`, (3,): share of the thrust error removed per step, up and down; greatest thrust."""
        return np.array(
            [1.0 - math.exp(-STEP_S / self.spin_up_s), 1.0 - math.exp(-STEP_S / self.spin_down_s), self.max_thrust_n]
        )

    def effect(self) -> Array:
        """Argument of `wrench`, (5, 4): force z and torques x, y, z per rotor thrust [1, m, m, m]; drag at [4, 0]."""
        effect = np.zeros((5, 4))
        effect[0] = 1.0
        effect[1] = self.rotors[:, 1]
        effect[2] = -self.rotors[:, 0]
        effect[3] = self.moment_m * self.spins
        effect[4, 0] = self.drag
        return effect


def read_vehicle(item: Item) -> Vehicle:
    """Read a vehicle.

    Raises:
        InputError: a value is not allowed, or a key is unknown.
    """
    inertia_item, hull_item, rotors_item, spins_item = (
        item.need(k) for k in ("inertia_kgm2", "hull_m", "rotors_m", "spins")
    )
    inertia, hull = (item.numbers(3, most=LARGEST) for item in (inertia_item, hull_item))
    spins = spins_item.numbers(4)
    if min(inertia) < SMALLEST:
        raise inertia_item.error(f"3 numbers >= {SMALLEST:g}")
    if min(hull) < SMALLEST:
        raise hull_item.error(f"3 numbers >= {SMALLEST:g}")
    if any(abs(spin) != 1 for spin in spins):
        raise spins_item.error("4 numbers, each 1 or -1")
    rotors = np.array([rotor.numbers(2, least=-LARGEST, most=LARGEST) for rotor in rotors_item])
    if rotors.shape != (4, 2):
        raise rotors_item.error("4 places [x, y]")
    mass_kg = item.need("mass_kg").number(least=SMALLEST, most=LARGEST)
    thrust_item = item.need("max_thrust_n")
    max_thrust_n = thrust_item.number(least=SMALLEST, most=LARGEST)
    if 4.0 * max_thrust_n <= mass_kg * GRAVITY_MPS2:
        raise InputError(
            f"{thrust_item.place}: max_thrust_n={max_thrust_n:g} must be > {mass_kg * GRAVITY_MPS2 / 4:.2f} to lift off"
        )
    vehicle = Vehicle(
        mass_kg=mass_kg,
        inertia=(inertia[0], inertia[1], inertia[2]),
        hull_m=(hull[0], hull[1], hull[2]),
        rotors=rotors,
        spins=np.array(spins),
        moment_m=item.need("moment_m").number(least=SMALLEST, most=LARGEST),
        max_thrust_n=max_thrust_n,
        spin_up_s=item.need("spin_up_s").number(least=SMALLEST, most=LARGEST),
        spin_down_s=item.need("spin_down_s").number(least=SMALLEST, most=LARGEST),
        drag=item.need("drag_ns_per_m").number(least=0.0, most=LARGEST),
    )
    item.close()
    return vehicle


@jit
def parts_of(numbers: Array) -> tuple[Array, Array, Array, Array, Array]:
    """State (13,), thrusts (4,), force and torque (6,), lag (3,), effect (5, 4) as views of `numbers` (46,)."""
    effect = numbers[_EFFECT:NUMBERS].reshape((5, 4))
    return numbers[:_THRUSTS], numbers[_THRUSTS:_PUSHED], numbers[_PUSHED:_LAG], numbers[_LAG:_EFFECT], effect


@jit
def rotor_step(thrusts: Array, command: Array, lag: Array) -> None:
    """Advance the rotors by one 240 Hz step, in place: first-order lag, faster up than down, within their limits.

    Args:
        thrusts: (4,) thrust of each rotor [N].
        command: (4,) commanded thrust [N]; a value that is not finite stops the rotor.
        lag: (3,) from `Vehicle.lag`.
    """
    for i in range(4):
        wanted = command[i] if np.isfinite(command[i]) else 0.0
        wanted = min(max(wanted, 0.0), lag[2])
        thrusts[i] += (wanted - thrusts[i]) * (lag[0] if wanted > thrusts[i] else lag[1])


@jit
def wrench(thrusts: Array, state: Array, effect: Array, force: Array, torque: Array) -> None:
    """Compute force and torque of rotors and air on the vehicle.

    Args:
        thrusts: (4,) thrust of each rotor [N].
        state: (13,) state of the vehicle.
        effect: (5, 4) from `Vehicle.effect`; the air's own force [N, world] at [4, 1:].
        force: (3,) receives the force [N, world].
        torque: (3,) receives the torque [N m, world].
    """
    lift, tx, ty, tz = 0.0, 0.0, 0.0, 0.0
    for i in range(4):
        lift += effect[0, i] * thrusts[i]
        tx += effect[1, i] * thrusts[i]
        ty += effect[2, i] * thrusts[i]
        tz += effect[3, i] * thrusts[i]
    x, y, z, w = state[3], state[4], state[5], state[6]
    ux, uy, uz = 2.0 * (x * z + y * w), 2.0 * (y * z - x * w), 1.0 - 2.0 * (x * x + y * y)
    drag = effect[4, 0]
    force[0] = lift * ux - drag * state[7]
    force[1] = lift * uy - drag * state[8]
    force[2] = lift * uz - drag * state[9]
    if effect[4, 1] != 0.0 or effect[4, 2] != 0.0 or effect[4, 3] != 0.0:
        for k in range(3):
            force[k] += effect[4, 1 + k]
    torque[0] = (1.0 - 2.0 * (y * y + z * z)) * tx + 2.0 * (x * y - z * w) * ty + ux * tz
    torque[1] = 2.0 * (x * y + z * w) * tx + (1.0 - 2.0 * (x * x + z * z)) * ty + uy * tz
    torque[2] = 2.0 * (x * z - y * w) * tx + 2.0 * (y * z + x * w) * ty + uz * tz


@jit
def actuate(thrusts: Array, order: Array, lag: Array, effect: Array, state: Array, pushed: Array) -> None:
    """Apply `rotor_step`, then `wrench`; `pushed` (6,) receives force, then torque."""
    rotor_step(thrusts, order, lag)
    wrench(thrusts, state, effect, pushed[:3], pushed[3:])
