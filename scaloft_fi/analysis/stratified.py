"""The exact stratified test of whether a subject violates a requirement more often than the baseline pool.

Each situation is a stratum.  Given the t violations among the n flights of the subject and the m flights of the pool,
the subject's k are hypergeometric if both violate at the same rate (Fisher, The Design of Experiments, 1935).  A
situation contributes k to the statistic where t - k <= m/10, else 0.  This gate is part of the statistic: situations
that were chosen first by a lucky pool and tested afterwards would call noise a detection.  The contributions' exact
distributions are convolved over the situations (as in the exact test of a common odds ratio of 2 x 2 tables: Gart,
Biometrika 57, 1970); p is the chance of a sum at least as large as the one observed.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

GATE = 10
"""A situation contributes where at most one in `GATE` of its pool flights violates."""


class Stratum(NamedTuple):
    """A situation: the subject violates in k of n flights, the pool in b of m.

    Attributes:
        most: violating pool flights up to which the situation contributes; a tenth of m where none is given.
    """

    k: int
    n: int
    b: int
    m: int
    most: int | None = None


def p_value(strata: Iterable[Stratum]) -> float:
    """Chance of at least the observed sum of contributions, if subject and pool violate at the same rates.

    >>> f"{p_value([Stratum(3, 3, 0, 10)]):.4f}", f"{p_value([Stratum(1, 1, 0, 10)] * 2):.4f}"
    ('0.0035', '0.0083')
    >>> p_value([Stratum(3, 3, 8, 10)])
    1.0

    Raises:
        ValueError: not 0 <= k <= n, or not 0 <= b <= m.
    """
    observed = 0
    margins = []
    for k, n, b, m, given in strata:
        if not (0 <= k <= n and 0 <= b <= m):
            raise ValueError(f"{k} of {n} against {b} of {m} is no stratum")
        if k + b:  # a situation without a violation contributes nothing, whatever else happens
            most = m // GATE if given is None else given
            observed += k if b <= most else 0
            margins.append((n, m, k + b, most))
    if observed == 0:
        return 1.0
    return min(1.0, float(_tails(tuple(sorted(margins)))[observed]))


@lru_cache(maxsize=8192)
def _tails(margins: tuple[tuple[int, int, int, int], ...]) -> NDArray[np.float64]:
    """Chance of a sum of at least 0, 1, 2, ... over strata with these (n, m, t, most)."""
    chances = np.ones(1)
    for n, m, t, most in margins:
        entries = _contributions(n, m, t, most)
        wider = np.zeros(len(chances) + entries[-1][0])
        for contribution, chance in entries:
            wider[contribution : contribution + len(chances)] += chance * chances
        chances = wider
    return np.cumsum(chances[::-1])[::-1]


@lru_cache(maxsize=8192)
def _contributions(n: int, m: int, t: int, most: int) -> tuple[tuple[int, float], ...]:
    """What a stratum may contribute, each with its chance, least first."""
    ways = math.comb(n + m, t)
    weights: dict[int, int] = {}
    for k in range(max(0, t - m), min(n, t) + 1):
        contribution = k if t - k <= most else 0
        weights[contribution] = weights.get(contribution, 0) + math.comb(n, k) * math.comb(m, t - k)
    return tuple((contribution, weights[contribution] / ways) for contribution in sorted(weights))
