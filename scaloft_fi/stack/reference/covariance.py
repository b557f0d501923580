"""Compiled updates of the covariance of the estimator's error: prediction, and correction by a fix.

Products of matrices are fused multiply-adds in the order of the terms, one rounding each, so that their bits are the
same on every processor; the bits of a BLAS depend on the kernels that it chooses for the processor.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, cast

import numpy as np
from numba import types
from numba.extending import intrinsic

from scaloft_fi.stack.fields import Array
from scaloft_fi.stack.kernel import jit

SIZE = 15
"""Components of the error: position, velocity, attitude, rate bias, force bias, three each."""
MEASURED = (0, 1, 2, 8)
"""Components of the error that a fix measures: position x, y, z and heading."""
_FIX = len(MEASURED)
_BLOCK = 5  # columns that are summed at once: while one sum waits for its last term, the others go on


def _emit_fused(_typing: Any, _a: Any, _b: Any, _c: Any) -> Any:
    def emit(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        return builder.fma(*arguments)

    return types.float64(types.float64, types.float64, types.float64), emit


fused = cast(Callable[[float, float, float], float], intrinsic(_emit_fused))
"""a * b + c, rounded once."""


@jit
def _product(a: Array, b: Array, out: Array) -> None:
    """Write a b into `out`; all (SIZE, SIZE)."""
    for i in range(SIZE):
        for j in range(0, SIZE, _BLOCK):
            s = t = u = v = w = 0.0
            for k in range(SIZE):
                x = a[i, k]
                s, t, u = fused(x, b[k, j], s), fused(x, b[k, j + 1], t), fused(x, b[k, j + 2], u)
                v, w = fused(x, b[k, j + 3], v), fused(x, b[k, j + 4], w)
            out[i, j], out[i, j + 1], out[i, j + 2], out[i, j + 3], out[i, j + 4] = s, t, u, v, w


@jit
def _both_sides(f: Array, p: Array) -> Array:
    """The product f p f', (SIZE, SIZE) as both are."""
    half, turned, out = np.empty((SIZE, SIZE)), np.empty((SIZE, SIZE)), np.empty((SIZE, SIZE))
    for i in range(SIZE):
        for j in range(SIZE):
            turned[j, i] = f[i, j]
    _product(f, p, half)
    _product(half, turned, out)
    return out


@jit
def carried(f: Array, p: Array, noise: Array) -> Array:
    """The covariance after a step: f p f' + noise; all (SIZE, SIZE)."""
    out = _both_sides(f, p)
    for i in range(SIZE):
        for j in range(SIZE):
            out[i, j] += noise[i, j]
    return out


@jit
def innovation(p: Array, noise: Array) -> Array:
    """Covariance (4, 4) of the innovation: that of the estimate's measured components plus `noise`, that of the fix."""
    s = np.empty((_FIX, _FIX))
    for i in range(_FIX):
        for j in range(_FIX):
            s[i, j] = p[MEASURED[i], MEASURED[j]] + noise[i, j]
    return s


@jit
def corrected(p: Array, noise: Array, inverse: Array, z: Array) -> tuple[Array, Array, Array]:
    """Gain (SIZE, 4), error (SIZE,) and covariance (SIZE, SIZE) after a fix, in Joseph's form.

    Args:
        p: (SIZE, SIZE) covariance before the fix.
        noise: (4, 4) covariance of a fix.
        inverse: (4, 4) inverse of the innovation's covariance.
        z: (4,) the innovation, fix minus estimate.
    """
    gain, error, kept, spread = np.empty((SIZE, _FIX)), np.empty(SIZE), np.zeros((SIZE, SIZE)), np.empty((SIZE, _FIX))
    for i in range(SIZE):
        kept[i, i] = 1.0
        for j in range(_FIX):
            total = 0.0
            for k in range(_FIX):
                total = fused(p[i, MEASURED[k]], inverse[k, j], total)
            gain[i, j] = total
            kept[i, MEASURED[j]] -= total
        # summed in pairs, as numpy does, and from +0: an innovation of 0 gives an error of +0, not of -0
        error[i] = 0.0 + ((gain[i, 0] * z[0] + gain[i, 2] * z[2]) + (gain[i, 1] * z[1] + gain[i, 3] * z[3]))
        for j in range(_FIX):
            total = 0.0
            for k in range(_FIX):
                total = fused(gain[i, k], noise[k, j], total)
            spread[i, j] = total
    left = _both_sides(kept, p)
    for i in range(SIZE):
        for j in range(SIZE):
            total = 0.0
            for k in range(_FIX):
                total = fused(spread[i, k], gain[j, k], total)
            left[i, j] += total
    return gain, error, left
