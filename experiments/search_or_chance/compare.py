"""The arms compared: exact permutation tests within blocks, blocks drawn again, and what the tests can show."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from enum import StrEnum
from itertools import accumulate, product
from statistics import mean

import numpy as np

from scaloft_fi.streams import generator

LEVEL = 0.05
"""Two-sided p at which arms differ."""
REDRAWS = 2_000
"""How often the blocks are drawn again."""
Counts = Sequence[Sequence[int]]
"""By block the number of mutants that each arm newly detects, the search first."""


class Answer(StrEnum):
    """What rule 1 says of the search."""

    BETTER = "yes"
    WORSE = "no, chance finds more"
    NO_DIFFERENCE = "no difference is shown"


def exact_p(counts: Counts) -> float:
    """Two-sided p of the first arm's total.

    If what proposes the situations makes no difference, each arm's count in a block might as well be the first arm's,
    whatever the other blocks have.  p is the share of all such choices whose total is as far from their mean.

    >>> exact_p([(1, 0)] * 5), exact_p([(1, 1, 1), (0, 0, 0)]), exact_p([(1, 0, 0)])
    (0.0625, 1.0, 0.3333333333333333)
    """
    ways = {0: 1}
    for block in counts:
        after: dict[int, int] = {}
        for (own, arms), (total, number) in product(Counter(_deviations(block)).items(), ways.items()):
            after[total + own] = after.get(total + own, 0) + arms * number
        ways = after
    seen = abs(sum(_deviations(block)[0] for block in counts))
    return sum(number for total, number in ways.items() if abs(total) >= seen) / sum(ways.values())


def _deviations(block: Sequence[int]) -> list[int]:
    """Each arm's count less the mean of all, times the number of arms."""
    return [len(block) * own - sum(block) for own in block]


def totals(counts: Counts) -> list[int]:
    """By arm the number of mutants over all blocks."""
    return [sum(arm) for arm in zip(*counts, strict=True)]


def answer(counts: Counts) -> tuple[Answer, float]:
    """What rule 1 says, and its p."""
    p = exact_p(counts)
    own, *others = totals(counts)
    if p <= LEVEL and own > max(others):
        return Answer.BETTER, p
    if p <= LEVEL and own < mean(others):
        return Answer.WORSE, p
    return Answer.NO_DIFFERENCE, p


def beside_each(counts: Counts) -> list[float]:
    """By other arm the p of the first arm beside it, adjusted by Holm."""
    return holm([exact_p([(block[0], block[other]) for block in counts]) for other in range(1, len(counts[0]))])


def holm(ps: Sequence[float]) -> list[float]:
    """Each p adjusted for being one of several (Holm, Scand. J. Statistics 6, 1979).

    >>> holm([0.02, 0.01, 0.5])
    [0.04, 0.03, 0.5]
    """
    order = sorted(range(len(ps)), key=ps.__getitem__)
    adjusted = accumulate((min(1.0, (len(ps) - rank) * ps[own]) for rank, own in enumerate(order)), max)
    by_place: Mapping[int, float] = dict(zip(order, adjusted, strict=True))
    return [by_place[place] for place in range(len(ps))]


def redrawn(counts: Counts, redraws: int = REDRAWS) -> list[tuple[int, int]]:
    """What the first arm has more than each of the others: the middle nine tenths, blocks drawn again."""
    rng = generator("search or chance", "blocks")
    more = np.array([[block[0] - other for other in block[1:]] for block in counts])
    drawn = np.array([more[rng.integers(len(more), size=len(more))].sum(axis=0) for _ in range(redraws)])
    low, high = np.quantile(drawn, (0.05, 0.95), axis=0, method="nearest")
    return list(zip(low.tolist(), high.tolist(), strict=True))


def power(
    sizes: Sequence[int], open_: float, chance: float, search: float, *, together: bool, draws: int = 1_000
) -> float:
    """How often rule 1 answers yes.

    Args:
        sizes: mutants of each block.
        open_: share of the mutants that something can show, but not the opening.
        chance: share of these that each of three arms of chance finds.
        search: share of these that the search finds.
        together: whether an arm finds all of these in a block or none; else it finds each by itself.
        draws: experiments that are drawn.
    """
    rng = generator("search or chance", "power", open_, chance, search, together)
    finds = np.array([search, chance, chance, chance])
    left = rng.binomial(np.array(sizes)[:, None], open_, size=(draws, len(sizes), 1))
    found = left * rng.binomial(1, finds, size=(draws, len(sizes), 4)) if together else rng.binomial(left, finds)
    return share(answer(one)[0] is Answer.BETTER for one in found.tolist())


def share(holds: Iterable[bool]) -> float:
    """The share that holds; 0 of nothing."""
    return mean(listed) if (listed := [*map(float, holds)]) else 0.0
