"""Compiled kernels: one decorator for all of the stack, and for the simulation around it."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from pathlib import Path
from types import FunctionType
from typing import ParamSpec, TypeVar, cast

import numba

P = ParamSpec("P")
R = TypeVar("R")


def joined(*parts: Callable[..., object]) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """Mark a function that calls kernels of other files, below `@jit`.

    numba keeps machine code under the function's name, which here changes with the names and sources of `parts`, and
    so with all that parts which are `joined` themselves call.
    """
    functions = [getattr(part, "py_func", part) for part in parts]
    names = "".join(sorted(function.__qualname__ for function in functions)).encode()
    sources = {Path(function.__code__.co_filename) for function in functions}
    digest = hashlib.sha256(names + b"".join(source.read_bytes() for source in sorted(sources))).hexdigest()[:12]

    def named(function: Callable[P, R]) -> Callable[P, R]:
        function.__qualname__ += f"_{digest}"
        return function

    return named


def with_globals(function: Callable[P, R], **kernels: Callable[..., object]) -> Callable[P, R]:
    """A copy of `function`, `joined` with these kernels but not yet compiled, in which they have these global names.

    numba keeps its machine code on disk, unlike that of a function which closes over a kernel or takes one as an
    argument: what identifies a kernel there is new in every process.
    """
    plain = cast(FunctionType, function)
    copy = FunctionType(plain.__code__, {**plain.__globals__, **kernels}, plain.__name__, plain.__defaults__)
    copy.__qualname__, copy.__doc__ = plain.__qualname__, plain.__doc__
    return joined(*kernels.values())(cast(Callable[P, R], copy))


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
