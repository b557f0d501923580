"""Compiled kernels: one decorator for all of the stack, and for the simulation around it.

Machine code is kept once for a user of a machine, under a hash of all that it is made of: the kernel, the kernels that
it calls, and the constants that they use, wherever they stand.  numba adds the processor to it.
"""

from __future__ import annotations

import dis
import hashlib
import os
import shutil
from collections.abc import Callable, Iterator
from contextlib import suppress
from functools import cached_property
from pathlib import Path
from types import CodeType, FunctionType, ModuleType
from typing import Any, ParamSpec, TypeVar, cast

import numba
import numpy as np
from numba.core import caching

P = ParamSpec("P")
R = TypeVar("R")

MOST_KEPT = 2_000
"""Kernels whose machine code is kept, some 30 kB each; those that were compiled first go first."""
_LIBRARIES = ("numpy", "math", "numba")


def jit(function: Callable[P, R]) -> Callable[P, R]:
    """Compile `function` with numba, keeping the machine code on disk where a folder for it can be written.

    Strict IEEE arithmetic (no fastmath), so the bits depend on nothing but the platform; a division by zero gives
    inf or NaN as in numpy.
    """
    compiled: Any = numba.njit(error_model="numpy")(function)
    compiled._cache = _Kept(cast(FunctionType, function))
    return cast(Callable[P, R], compiled)


def with_globals(function: Callable[P, R], **kernels: Callable[..., object]) -> Callable[P, R]:
    """A copy of `function`, not yet compiled, in which kernels have these global names.

    numba keeps its machine code on disk, unlike that of a function which closes over a kernel or takes one as an
    argument: what identifies a kernel there is new in every process.
    """
    plain = cast(FunctionType, function)
    copy = FunctionType(plain.__code__, {**plain.__globals__, **kernels}, plain.__name__, plain.__defaults__)
    copy.__qualname__, copy.__doc__ = plain.__qualname__, plain.__doc__
    return cast(Callable[P, R], copy)


def _parts(value: Any, seen: set[int]) -> Iterator[str]:
    """What machine code depends on, of a kernel and all that it uses."""
    value = getattr(value, "py_func", value)
    if isinstance(value, FunctionType):
        if id(value) in seen:
            return
        seen.add(id(value))
        code, known = value.__code__, value.__globals__
        yield _name_of(value)
        yield from _of_code(code, value.__doc__)
        yield repr(value.__defaults__)
        for name in sorted({step.argval for step in dis.get_instructions(code) if step.opname == "LOAD_GLOBAL"}):
            yield name
            used = known.get(name)
            yield from _parts(used, seen)
            if isinstance(used, ModuleType) and used.__name__.partition(".")[0] not in _LIBRARIES:
                for inner in (inner for inner in code.co_names if hasattr(used, inner)):
                    yield from _parts(getattr(used, inner), seen)
        for cell in value.__closure__ or ():
            yield from _parts(cell.cell_contents, seen)
    elif isinstance(value, np.ndarray):
        yield from (value.dtype.str, repr(value.shape), value.tobytes().hex())
    elif isinstance(value, tuple):
        yield _name_of(type(value))
        for one in value:
            yield from _parts(one, seen)
    elif isinstance(value, bool | int | float | complex | str | bytes | np.generic | None):
        yield repr(value)
    elif isinstance(value, type):
        yield f"{_name_of(value)} {getattr(value, '_fields', '')}"
    elif isinstance(value, ModuleType):
        yield value.__name__
    else:  # such as an intrinsic, whose definition is a function
        yield type(value).__qualname__
        yield from _parts(getattr(value, "_defn", None), seen)


def _name_of(value: type | FunctionType) -> str:
    """Where machine code imports `value` from when it is loaded."""
    return f"{value.__module__}.{value.__qualname__}"


def _of_code(code: CodeType, about: str | None) -> Iterator[str]:
    yield from (code.co_code.hex(), repr(code.co_names), repr(code.co_varnames), repr(code.co_argcount))
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from _of_code(constant, None)
        elif about is None or constant != about:
            yield repr(constant)


def made_of(function: FunctionType) -> str:
    """A hash of what the machine code of a function depends on, the processor left out."""
    return hashlib.sha256("\n".join(_parts(function, set())).encode()).hexdigest()


def compiles() -> bool:
    """Whether this process has had to compile a kernel."""
    return _Kept.missed > 0


def lacks(kernel: Callable[..., object]) -> bool:
    """Whether machine code of a kernel can be kept on disk, and none is there."""
    place = cast(Any, kernel)._cache.cache_path
    return place is not None and not Path(place).is_dir()


def folder_of_kernels() -> Path:
    """Where machine code is kept: in numba's folder, if somebody names one, else in the user's folder of caches."""
    own = os.environ.get("NUMBA_CACHE_DIR") or os.environ.get("XDG_CACHE_HOME") or "~/.cache"
    return Path(own).expanduser() / "scaloft-fi" / "kernels"


class _Place(caching._CacheLocator):
    """Tells numba where the machine code of a kernel is."""

    def __init__(self, folder: Path, mark: str) -> None:
        self._folder, self._mark = folder, mark

    def get_cache_path(self) -> str:
        return str(self._folder / self._mark[:32])

    def get_source_stamp(self) -> str:
        return self._mark

    def get_disambiguator(self) -> str:
        return ""

    def ensure_cache_path(self) -> None:
        kept = sorted(self._folder.iterdir(), key=lambda one: one.stat().st_mtime)
        for old in kept[: max(0, len(kept) - MOST_KEPT)]:
            shutil.rmtree(old, ignore_errors=True)
        Path(self.get_cache_path()).mkdir(parents=True, exist_ok=True)


class _Files(caching.CompileResultCacheImpl):
    """The files of a kernel in its place."""

    def __init__(self, function: FunctionType) -> None:
        folder = folder_of_kernels()
        folder.mkdir(parents=True, exist_ok=True)
        if not os.access(folder, os.W_OK):
            raise PermissionError(str(folder))
        self._lineno, self._locator = 0, _Place(folder, made_of(function))
        self._filename_base = self.get_filename_base(function.__name__, "")  # type: ignore[no-untyped-call]


class _Machine(caching.FunctionCache):
    _impl_class = _Files


class _Kept(caching._Cache):
    """The machine code of a kernel on disk, looked for at the first call: all that the kernel uses is there by then."""

    missed = 0

    def __init__(self, function: FunctionType) -> None:
        self._function = function

    @cached_property
    def _cache(self) -> Any:
        try:
            return _Machine(self._function)  # type: ignore[no-untyped-call]
        except (OSError, RuntimeError):  # no folder can be written
            return caching.NullCache()

    @property
    def cache_path(self) -> Any:
        return self._cache.cache_path

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        try:
            found = self._cache.load_overload(sig, target_context)
        except OSError:  # a file of the machine is no fault of the drone
            found = None
        _Kept.missed += found is None
        return found

    def save_overload(self, sig: Any, data: Any) -> None:
        with suppress(OSError):  # what cannot be kept is compiled again
            self._cache.save_overload(sig, data)

    def enable(self) -> None:
        self._cache.enable()

    def disable(self) -> None:
        self._cache.disable()

    def flush(self) -> None:
        self._cache.flush()
