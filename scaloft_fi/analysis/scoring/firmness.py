"""Firm: whether a verdict `detected` hangs on a single seed.

Detected says what these flights support; firm says what another seed would say.  A detected mutant is firm if it stays
detected when any one seed is left out of its own flights and, separately, any one out of the pool's (the jackknife of
Quenouille, Biometrika 43, 1956, over seeds).  States of pairs and the gate's allowance stay those of the whole pool,
else leaving out one of ten flights would change what is asked and not only what answers.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from enum import StrEnum

from scaloft_fi.analysis.scoring.detection import Sample, Spending, adjusted, at_worst, reaches
from scaloft_fi.analysis.scoring.pool import Pool
from scaloft_fi.judge.requirement import Kind


class Firmness(StrEnum):
    """What remains of a verdict `detected` when one seed is left out."""

    FIRM = "firm"
    """It stays detected, whichever seed is left out of its own flights or of the pool."""
    FIRM_BY_POOL = "firm_by_pool"
    """It has one seed of its own, and stays detected whichever seed is left out of the pool."""
    HANGS = "hangs_on_a_seed"
    """Without some seed it is not detected."""
    TOO_FEW = "too_few_seeds"
    """Without some seed the flights that remain could not be detected whatever they show."""

    @property
    def firm(self) -> bool:
        """Whether it counts as firm."""
        return self in (Firmness.FIRM, Firmness.FIRM_BY_POOL)

    @property
    def words(self) -> str:
        """As people read it."""
        return _WORDS[self]


_WORDS = {
    Firmness.FIRM: "firm",
    Firmness.FIRM_BY_POOL: "firm by the pool alone",
    Firmness.HANGS: "hangs on a seed",
    Firmness.TOO_FEW: "too few seeds to say",
}


def firmness(mutant: str, samples: Sequence[Sample], pool: Pool, spending: Spending, kind: Kind) -> Firmness:
    """What remains of the verdict on a detected mutant when one seed is left out.

    Each number of seeds at which the mutant is judged is judged again without the seed, at its share of alpha.

    Args:
        mutant: its id.
        samples: one per situation flown, with their seeds.
        pool: what the flights are compared with.
        spending: of alpha.
        kind: safety or operability.
    """
    flown = max(len(sample.violated) for sample in samples)
    looks = [([sample.at(seeds) for sample in samples], share) for seeds, share in spending.looks(mutant, flown)]
    own = sorted({seed for sample in samples for seed in sample.seeds})
    names = pool.requirements(kind)

    def detected(left: Sequence[Sample], seed: int | None, share: float) -> bool:
        return reaches(min(adjusted(left, pool, names, seed).values()), share)

    def cases() -> Iterator[list[tuple[list[Sample], int | None, float]]]:
        for seed in own if len(own) > 1 else ():
            yield [([sample.without(seed) for sample in looked], None, share) for looked, share in looks]
        for seed in pool.by_seed:
            yield [(looked, seed, share) for looked, share in looks]

    lost = [case for case in cases() if not any(detected(*look) for look in case)]
    if not lost:
        return Firmness.FIRM if len(own) > 1 else Firmness.FIRM_BY_POOL
    able = any(detected(_worst(left, pool, kind), seed, share) for case in lost for left, seed, share in case)
    return Firmness.HANGS if able else Firmness.TOO_FEW


def _worst(samples: Sequence[Sample], pool: Pool, kind: Kind) -> list[Sample]:
    """The flights that put the fault to the test, if each violated all that it could."""
    return at_worst([one for one in samples if one.infected and pool.steady(one.situation, kind)], pool, kind)
