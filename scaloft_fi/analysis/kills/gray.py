"""Situations in the order of a reflected Gray code: neighbours differ on one axis, so blocks stay together."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product

from scaloft_fi.judge.space import Space


def gray_order(space: Space) -> tuple[str, ...]:
    """The keys of the listed situations in the order of the reflected mixed-radix Gray code, the first axis slowest.

    In a grid of every combination, neighbours differ on one axis, by neighbouring values; where constraints leave
    situations out the rest keep their order.  Source: Knuth, The Art of Computer Programming 4A, 7.2.1.1, algorithm H.
    """
    radices = [len(values) for values in space.values]

    def rank(entry: tuple[str, tuple[str, ...]]) -> int:
        digits = [values.index(value) for values, value in zip(space.values, entry[1], strict=True)]
        return gray_rank(digits, radices)

    return tuple(key for key, _ in sorted(space.situations, key=rank))


def gray_rank(digits: Sequence[int], radices: Sequence[int]) -> int:
    """The place of a word in the reflected Gray code of these radices.

    >>> [gray_rank(word, (2, 3)) for word in [(0, 0), (0, 1), (0, 2), (1, 2), (1, 1), (1, 0)]]
    [0, 1, 2, 3, 4, 5]
    """
    rank = 0
    for digit, radix in zip(digits, radices, strict=True):
        # under a word of odd rank the rest is listed backwards
        rank = rank * radix + (radix - 1 - digit if rank % 2 else digit)
    return rank


def gray_words(radices: Sequence[int]) -> tuple[tuple[int, ...], ...]:
    """All words of the reflected Gray code of these radices, in its order.

    >>> gray_words((2, 2))
    ((0, 0), (0, 1), (1, 1), (1, 0))
    """
    return tuple(sorted(product(*map(range, radices)), key=lambda word: gray_rank(word, radices)))
