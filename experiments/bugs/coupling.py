"""Whether situations that kill a mutant detect a bug more often than random situations: pure functions of counts.

Situations are keys; a set of them *detects* a bug if the score's own test, restricted to that set, does.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from scaloft_fi.streams import generator

RELABELLINGS = 9_999
DRAWS = 1_000
"""Sets that are drawn where there are more than that."""

Detects = Callable[[Collection[str]], bool]
"""Whether a set of situations detects a bug."""


@dataclass(frozen=True)
class Coupling:
    """A bug beside the mutant of its cell.

    Attributes:
        key: of the bug.
        killing: situations that kill the mutant.
        alone: situations that detect the bug, each by itself.
        weight: 1 divided by the number of bugs with the same flights.
    """

    key: str
    killing: frozenset[str]
    alone: frozenset[str]
    weight: float = 1.0

    def excess(self, population: Collection[str]) -> float:
        """How much oftener a killing situation detects the bug than one of the population does."""
        return share(self.alone, self.killing) - share(self.alone, population)

    def p(self, population: Collection[str]) -> float:
        """Chance that as many situations of the population, drawn at random, hold as many that detect the bug."""
        whole, detecting = len(population), len(self.alone & set(population))
        return tail(whole, detecting, len(self.killing), len(self.alone & self.killing))


def share(part: Collection[str], whole: Collection[str]) -> float:
    """The share of `whole` that lies in `part`.

    >>> share("ab", "bc")
    0.5
    """
    return len(set(part) & set(whole)) / len(whole)


def tail(whole: int, marked: int, drawn: int, least: int) -> float:
    """Chance that `drawn` of `whole`, without putting back, hold at least `least` of the `marked`.

    >>> tail(4, 2, 2, 2) == 1 / 6, tail(4, 2, 2, 0)
    (True, 1.0)
    """
    counts = range(least, min(marked, drawn) + 1)
    ways = sum(math.comb(marked, k) * math.comb(whole - marked, drawn - k) for k in counts)
    return ways / math.comb(whole, drawn)


def mean_excess(bugs: Sequence[Coupling], population: Collection[str]) -> float:
    """The weighted mean of the bugs' excess."""
    return sum(bug.weight * bug.excess(population) for bug in bugs) / sum(bug.weight for bug in bugs)


def relabelled_p(bugs: Sequence[Coupling], population: Collection[str]) -> float:
    """Chance of at least the mean excess if the names of the situations tell nothing of kills.

    Each of `RELABELLINGS` keyed draws permutes the names in all sets of killing situations at once, so that the sets
    keep their sizes and what they have in common.

    Args:
        bugs: the bugs; their killing situations lie in the population.
        population: the situations.
    """
    names = sorted(population)
    killing = np.array([[name in bug.killing for name in names] for bug in bugs], float)
    alone = np.array([[name in bug.alone for name in names] for bug in bugs], float)
    alone *= np.array([[bug.weight / len(bug.killing)] for bug in bugs])
    random = generator("bugs", "relabelling")
    seen = float((killing * alone).sum())
    drawn = (float((killing[:, random.permutation(len(names))] * alone).sum()) for _ in range(RELABELLINGS))
    return (1 + sum(value >= seen - 1e-9 for value in drawn)) / (1 + RELABELLINGS)


def detecting_share(detects: Detects, population: Collection[str], size: int, *name: object) -> float:
    """The share of sets of `size` situations of the population that detect a bug.

    All of them where there are at most `DRAWS`, else that many draws of the stream `name`.
    """
    names = sorted(population)
    if math.comb(len(names), size) <= DRAWS:
        sets = list(combinations(names, size))
    else:
        random = generator("bugs", "sets", *name)
        sets = [tuple(names[i] for i in random.permutation(len(names))[:size]) for _ in range(DRAWS)]
    return sum(map(detects, sets)) / len(sets)
