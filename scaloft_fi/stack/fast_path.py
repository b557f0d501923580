"""What a stack may offer beside its `step`: the same, compiled, for physics steps in which no fault sits on its seams.

A stack without a fast path has the attribute `fast_path = None`, and every step is its Python `step`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from scaloft_fi.stack.fields import Array

Numbers = tuple[Array, ...]
"""One-dimensional arrays in which a stack keeps what its kernel reads and writes, as many as the stack likes."""

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
        """The compiled step, always the same one."""
        ...

    def begin(self) -> Numbers:
        """Get ready for steps by the kernel; returns its numbers, always as many."""
        ...

    def end(self) -> None:
        """Take over from the numbers what the steps led to, as if `step` had made them."""
        ...
