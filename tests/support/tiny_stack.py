"""A stack that hops on the spot, the cheapest thing that flies: thrust by the clock, and nothing sensed is acted on."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from scaloft_fi.stack import messages
from scaloft_fi.stack.declaration import STEP_HZ, TICK_HZ, Belief, Declaration, PlainStack, Seam, Task, Wire
from scaloft_fi.stack.kernel import jit
from scaloft_fi.stack.messages import Array, Stamp

PROFILE = ((1.0, 10.81), (2.0, 8.81), (5.0, 9.81), (5.4, 8.81))
"""Until when [s], what the rotors push [m/s2]: up a metre, hover, sink."""
HOVER_MPS2 = 9.81


class Level(NamedTuple):
    """What the rotors push, by the clock [m/s2]."""

    stamp_s: Stamp
    push_mps2: float


@dataclass(frozen=True)
class Settings:
    """mass_kg: of the vehicle."""

    mass_kg: float


class Hop(PlainStack):
    """Pushes by the clock, on every rotor alike."""

    def __init__(self, task: Task, wire: Wire) -> None:
        self.mass_kg, self.wire = task.settings.mass_kg, wire
        self.rotors = np.zeros(4)

    def autopilot(self, now_s: float, frames: Any) -> None:
        push = next((push for end_s, push in PROFILE if now_s < end_s), HOVER_MPS2)
        level = self.wire.cross("level", now_s, Level(now_s, push))
        if level is not None:
            self.rotors = np.full(4, 0.25 * self.mass_kg * level.push_mps2)

    def step(self, now_s: float, imu: messages.Imu) -> messages.Thrust | None:
        self.wire.cross("gyro", now_s, imu)
        return self.wire.cross("rotors", now_s, messages.Thrust(self.rotors.copy()))

    def beliefs(self, now_s: float) -> Array:
        return np.array([now_s, 0.0])


@jit
def push(now_s: float, stamp_s: float, rate: Array, force: Array, numbers: tuple[Array, ...]) -> Array:
    """The thrust of the tick."""
    return numbers[0]


class FastHop:
    """The compiled step; `factor` 1 has its bits."""

    seams = ("gyro", "rotors")
    kernel = staticmethod(push)

    def __init__(self, stack: Hop, factor: float) -> None:
        self._stack, self._factor = stack, factor

    def begin(self) -> tuple[Array, ...]:
        """The thrust of the tick."""
        return (self._stack.rotors * self._factor,)

    def end(self) -> None:
        """Nothing is left to take over."""


SOUND = Declaration(
    name="hop",
    seams=(
        Seam("gyro", messages.Imu, STEP_HZ, "inertial sensor -> nobody"),
        Seam("level", Level, TICK_HZ, "clock -> rotors"),
        Seam("rotors", messages.Thrust, STEP_HZ, "clock -> rotors", units={"rotors": "N"}),
    ),
    beliefs=(Belief("clock_s", "s", "time since the start"), Belief("doubt", "", "how unsure it is, 0..1", most=1.0)),
    make=Hop,
    settings=lambda: Settings,
)


def hop(stack: type[Hop] = Hop, **changes: Any) -> Declaration:
    """The declaration of a stack that hops, with these changes."""
    return replace(SOUND, make=stack, **changes)
