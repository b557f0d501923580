"""Exact tests and intervals of counts: Fisher, the binomial tail, Clopper and Pearson.

They are few and small, and `score` starts without scipy; the tests hold them against scipy.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from fractions import Fraction
from functools import cache

HALVINGS = 60
"""Bisection steps of a bound within [0, 1]: to the last bit of a float."""


@cache
def fisher(k: int, n: int, b: int, n0: int) -> Fraction:
    """Probability of k or more of the k + b violations among the n flights, if both rates are the same.

    One-sided exact test of 2 x 2 tables (Fisher, The Design of Experiments, 1935): k of n against b of n0.

    >>> [float(round(fisher(k, n, 0, 50), 5)) for k, n in ((2, 2), (3, 3), (3, 5), (4, 10))]
    [0.00075, 4e-05, 0.00038, 0.00043]

    Raises:
        ValueError: not 0 <= k <= n, or not 0 <= b <= n0.
    """
    if not (0 <= k <= n and 0 <= b <= n0):
        raise ValueError(f"{k} of {n} against {b} of {n0} is no table")
    drawn = k + b
    ways = sum(math.comb(n, i) * math.comb(n0, drawn - i) for i in range(k, min(n, drawn) + 1))
    return Fraction(ways, math.comb(n + n0, drawn))


@cache
def at_most(k: int, n: int) -> Fraction:
    """Probability of k or fewer of n when each comes true with probability 1/2.

    >>> str(at_most(0, 5)), str(at_most(1, 10))
    ('1/32', '11/1024')
    """
    return Fraction(sum(math.comb(n, i) for i in range(k + 1)), 2**n)


def clopper_pearson(part: int, whole: int, confidence: float = 0.95) -> tuple[float, float]:
    """The exact two-sided interval of a share: covers at least as often as it says (Biometrika 26, 1934).

    >>> [round(bound, 2) for bound in clopper_pearson(0, 10)]
    [0.0, 0.31]

    Raises:
        ValueError: not 0 <= part <= whole, or whole is 0.
    """
    if not 0 <= part <= whole or whole == 0:
        raise ValueError(f"{part} of {whole} is no share")
    side = (1 - confidence) / 2
    low = 0.0 if part == 0 else 1 - _bound(whole - part, whole, side)
    high = 1.0 if part == whole else _bound(part, whole, side)
    return low, high


def _bound(k: int, n: int, side: float) -> float:
    """The probability at which k or fewer of n are as rare as `side`."""
    logs = [math.lgamma(n + 1) - math.lgamma(i + 1) - math.lgamma(n - i + 1) for i in range(k + 1)]

    def tail(p: float) -> float:
        yes, no = math.log(p), math.log1p(-p)
        return math.fsum(math.exp(ways + i * yes + (n - i) * no) for i, ways in enumerate(logs))

    return _bisect(lambda p: tail(p) > side)


def _bisect(below: Callable[[float], bool]) -> float:
    """Where `below`, true first, becomes false within (0, 1)."""
    low, high = 0.0, 1.0
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        if below(middle):
            low = middle
        else:
            high = middle
    return (low + high) / 2
