"""The two arms compared: exact tests, a permutation test, and seeds drawn again."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from experiments.random_faults.arm import Arm, Kills, kill_sets, kills_of, useful
from experiments.random_faults.plan import LEVEL, PERMUTATIONS, POOL, REDRAWS, SEEDS, fisher
from scaloft_fi.analysis.score import MutantScore
from scaloft_fi.streams import generator


class Answer(StrEnum):
    """What rule 1 says of HAZOP."""

    BETTER = "better"
    WORSE = "worse"
    NO_DIFFERENCE = "no difference is shown"


@dataclass(frozen=True)
class Counts:
    """Numbers of faults of an arm.

    Attributes:
        faults: scored.
        detected, trivial, useful: as the plan defines them.
        kill_sets: different sets of kills.
    """

    faults: int
    detected: int
    trivial: int
    useful: int
    kill_sets: int

    @classmethod
    def of(cls, scores: Sequence[MutantScore]) -> Counts:
        """Counted of scores."""
        detected, plain, good = (sum(map(test, scores)) for test in (lambda s: s.detected, lambda s: s.trivial, useful))
        return cls(len(scores), detected, plain, good, len(kill_sets(scores)))


MEASURES = ("detected", "trivial", "useful", "kill_sets")


def answer(hazop: Counts, random: Counts) -> tuple[Answer, float]:
    """What rule 1 says, and its p."""
    p = fisher(hazop.useful, hazop.faults, random.useful, random.faults)
    if p > LEVEL:
        return Answer.NO_DIFFERENCE, p
    better = hazop.useful * random.faults > random.useful * hazop.faults
    return (Answer.BETTER if better else Answer.WORSE), p


def p_of_kill_sets(hazop: Sequence[MutantScore], random: Sequence[MutantScore]) -> float:
    """Two-sided p that labels exchanged between the arms leave as great a difference of different sets of kills."""
    return permuted([kills_of(score) for score in hazop], [kills_of(score) for score in random])


def permuted(one: Sequence[Kills], other: Sequence[Kills], permutations: int = PERMUTATIONS) -> float:
    """The same of sets of kills; the empty set counts as none.

    >>> permuted([frozenset()] * 3, [frozenset()] * 3, permutations=9)
    1.0
    """
    numbers = {kills: number for number, kills in enumerate(sorted({*one, *other} - {frozenset()}, key=sorted))}
    own = np.array([numbers.get(kills, -1) for kills in (*one, *other)])
    seen = abs(_difference(own, len(one)))
    rng = generator("random faults", "permutation")
    least = sum(abs(_difference(rng.permutation(own), len(one))) >= seen for _ in range(permutations))
    return float((1 + least) / (1 + permutations))


def _difference(numbers: np.ndarray[tuple[int], np.dtype[np.int64]], first: int) -> int:
    one, other = (set(part.tolist()) - {-1} for part in (numbers[:first], numbers[first:]))
    return len(one) - len(other)


def redrawn(hazop: Arm, random: Arm, redraws: int = REDRAWS) -> Mapping[str, tuple[list[int], list[int]]]:
    """By measure the numbers of both arms, seeds drawn again with replacement, the same ones in both arms."""
    rng = generator("random faults", "seeds")
    found: dict[str, tuple[list[int], list[int]]] = {measure: ([], []) for measure in MEASURES}
    for _ in range(redraws):
        seeds, pool = (sorted(rng.integers(most, size=most).tolist()) for most in (SEEDS, POOL))
        for place, arm in enumerate((hazop, random)):
            counts = Counts.of(arm.scored(seeds, pool))
            for measure in MEASURES:
                found[measure][place].append(getattr(counts, measure))
    return found
