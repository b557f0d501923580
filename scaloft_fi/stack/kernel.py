"""Compiled kernels: one decorator for all of the stack, and for the simulation around it."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from pathlib import Path
from typing import ParamSpec, TypeVar, cast

import numba

P = ParamSpec("P")
R = TypeVar("R")


def joined(*parts: Callable[..., object]) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """Mark a function that calls kernels of other files, below `@jit`.

    numba keeps machine code under the function's name, which here changes with the sources of `parts`.
    """
    sources = {Path(getattr(part, "py_func", part).__code__.co_filename) for part in parts}
    digest = hashlib.sha256(b"".join(source.read_bytes() for source in sorted(sources))).hexdigest()[:12]

    def named(function: Callable[P, R]) -> Callable[P, R]:
        function.__qualname__ += f"_{digest}"
        return function

    return named


def jit(function: Callable[P, R]) -> Callable[P, R]:
    """Compile `function` with numba, keeping the machine code on disk where a folder for it can be written.

    Strict IEEE arithmetic (no fastmath), so the bits depend on nothing but the platform; a division by zero gives
    inf or NaN as in numpy.  Kernels that call each other share a file, because numba's disk cache only watches a
    kernel's own, or are `joined`.
    """
    try:
        compiled = numba.njit(cache=True, error_model="numpy")(function)
    except RuntimeError:  # neither the package's folder nor the user's cache folder can be written
        compiled = numba.njit(error_model="numpy")(function)
    return cast(Callable[P, R], compiled)
