"""The chance that something is met by k situations: a mutant by one that kills it, a combination by one that has it.

Every form is exact.  With a random order a mutant killed in d of N situations is killed within k of them with the
probability 1 - C(N-d, k)/C(N, k); the same is the expected coverage of a combination that d situations have.  So for a
mutant that is killed exactly where t axes have certain values, kills at k and t-way coverage at k are one number.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Found = NDArray[np.bool_]
"""(things, situations): whether the situation meets the thing."""
Chances = NDArray[np.float64]
"""(things, k): chance that the thing is met within the first k + 1 situations."""
Positions = NDArray[np.int64]
"""(orders, situations): the place of each situation in the order, from 0."""


def without_replacement(situations: int) -> Chances:
    """(d, k): 1 - C(N-d, k+1)/C(N, k+1) for N situations of which d = 0..N meet the thing.

    >>> [round(float(without_replacement(32)[d, 5]), 3) for d in (16, 8, 4, 2, 1)]  # 6 of 2^5; method: 1 to 5 axes
    [0.991, 0.851, 0.584, 0.345, 0.188]
    """
    d = np.arange(situations + 1)[:, None]
    k = np.arange(situations)[None, :]
    # the (k+1)-th situation misses too with the chance (N - d - k)/(N - k)
    missed = np.clip((situations - d - k) / (situations - k), 0.0, 1.0)
    return np.asarray(1.0 - np.cumprod(missed, axis=1))


def with_replacement(situations: int) -> Chances:
    """(d, k): 1 - (1 - d/N)^(k+1) for draws that may repeat."""
    d = np.arange(situations + 1)[:, None]
    return np.asarray(1.0 - (1.0 - d / situations) ** (np.arange(situations)[None, :] + 1))


def in_orders(found: Found, positions: Positions) -> Chances:
    """The share of the orders in which each thing is met within k + 1 situations."""
    orders, situations = positions.shape
    met = [np.bincount(row, minlength=situations + 1)[:situations] for row in firsts(found, positions).T]
    return np.asarray(np.cumsum(np.reshape(met, (len(found), situations)), axis=1) / orders)


def firsts(found: Found, positions: Positions) -> Positions:
    """(orders, things): the place of the first situation that meets the thing; N where none does."""
    orders, situations = positions.shape
    first = np.full((orders, len(found)), situations, np.int64)
    for thing, row in enumerate(found):
        if row.any():
            first[:, thing] = positions[:, row].min(axis=1)
    return first


def in_subsets(found: Found, suites: NDArray[np.int64]) -> Chances:
    """Met by k + 1 situations drawn from a suite without replacement, on average over the suites (suites, size)."""
    size = suites.shape[1]
    by_count = without_replacement(size)
    return np.reshape([by_count[row[suites].sum(axis=1)].mean(axis=0) for row in found], (len(found), size))


def apfd(chances: Chances) -> float | None:
    """Average percentage of faults detected, over the faults that a whole order detects; None without any.

    1 - (TF1 + ... + TFm)/(n m) + 1/(2n), TF the place of the first situation that detects a fault (Rothermel, Untch,
    Chu, Harrold, IEEE TSE 27, 2001).  Under a random order TF is (N+1)/(d+1) on average.

    >>> round(apfd(without_replacement(32)[[16]]), 3), round(apfd(without_replacement(32)[[1]]), 3)
    (0.955, 0.5)
    """
    detected = chances[chances[:, -1] > 1 - 1e-9]
    if not len(detected):
        return None
    n = detected.shape[1]
    # the mean of a place from 1 on is the sum of the chances to be still waiting
    place = 1.0 + (1.0 - detected[:, :-1]).sum(axis=1)
    return float(1.0 - place.mean() / n + 1.0 / (2 * n))
