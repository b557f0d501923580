"""Compiled kernels: one decorator for all of the stack, and for the simulation around it."""

from __future__ import annotations

from collections.abc import Callable
from typing import ParamSpec, TypeVar, cast

import numba

P = ParamSpec("P")
R = TypeVar("R")


def jit(function: Callable[P, R]) -> Callable[P, R]:
    """Compile `function` with numba, keeping the machine code on disk where a folder for it can be written.

    Strict IEEE arithmetic (no fastmath), so the bits depend on nothing but the platform; a division by zero gives
    inf or NaN as in numpy.  Kernels that call each other share a file: numba's disk cache only watches a kernel's own.
    """
    try:
        compiled = numba.njit(cache=True, error_model="numpy")(function)
    except RuntimeError:  # neither the package's folder nor the user's cache folder can be written
        compiled = numba.njit(error_model="numpy")(function)
    return cast(Callable[P, R], compiled)
