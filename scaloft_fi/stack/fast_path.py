"""The compiled form of a stack's `step`, for physics steps in which no tap sits on the seams that it skips.

A stack without a fast path has the attribute `fast_path = None`, and every step is its Python `step`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from scaloft_fi.stack.fields import Array

Numbers = tuple[Array, ...]
"""One-dimensional arrays, any number of them, that the kernel of a stack reads and writes."""

Kernel = Callable[[float, float, Array, Array, Numbers], Array]
"""A function under `stack.kernel.jit` (and `joined`, if it calls kernels of other files) with the arguments

    now_s: time of the step, its number divided by `STEP_HZ` [s].
    stamp_s: stamp of the inertial sample, the step's number times `STEP_S` [s].
    rate, force: (3,) of the inertial sample [rad/s, m/s2, body].
    numbers: what `FastPath.begin` returned.

which returns the thrust of each rotor (4,) [N].  It must have the bits of the stack's `step`.
"""


class FastPath(Protocol):
    """A stack's `step`, compiled.  The flight loop calls `begin`, the kernel for each step up to a tick, and `end`.

    What `begin` raises stops the rotors, like what `step` raises; the kernel and `end` must not raise.
    """

    @property
    def seams(self) -> tuple[str, ...]:
        """The seams that the kernel skips: the flight loop uses it only where the wire listens on none of them."""
        ...

    @property
    def kernel(self) -> Kernel:
        """The compiled step, the same function at every call."""
        ...

    def begin(self) -> Numbers:
        """Prepare for steps by the kernel; returns the kernel's numbers, equally many arrays at every call."""
        ...

    def end(self) -> None:
        """Take the result of the steps over from the numbers, as if `step` had been called."""
        ...
