"""REDRAW: how often the verdict calls a fault detected that does nothing, measured on the baselines that were flown.

A fault that did nothing but redraw the noise would turn one baseline into another.  So seeds of the unmutated drone are
judged as a mutant beside ten others: as many as the mutants flew, the same in every situation, chosen at random again
and again.  PLACEBO cannot show this, because it draws the same noise as its baseline.  The redraws overlap, so their
share has no interval.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from scaloft_fi.analysis.ratio import Ratio
from scaloft_fi.analysis.scoring.detection import Sample, adjusted
from scaloft_fi.analysis.scoring.pool import LEAST, Pair, Pool
from scaloft_fi.judge.outcome import BASELINE, Outcome
from scaloft_fi.judge.requirement import Kind

FROM = 20
"""Pool flights in every situation from which redraws are made."""
REDRAWS = 200
SEED = 20251
"""Of the choices; a fixed number, so that a score is the same whenever it is asked for."""

NONE = Ratio(0, 0)
"""The share where no redraw was made."""


@dataclass(frozen=True)
class Redraw:
    """What redraws of the unmutated drone gave.

    Attributes:
        seeds: flights of a redraw in each situation; 0 where none was made.
        safety, operability: redraws called detected by requirements of that kind, of all.
    """

    seeds: int = 0
    safety: Ratio = NONE
    operability: Ratio = NONE


def redraw(baselines: Iterable[Outcome], seeds: int, alpha: float, redraws: int = REDRAWS) -> Redraw:
    """Judge seeds of the baseline as mutants; none where a situation with a pool has fewer flights than `FROM`.

    Args:
        baselines: the pool.
        seeds: flights of a mutant in each situation.
        alpha: of the verdict.
        redraws: how many.
    """
    flown: dict[str, dict[int, Outcome]] = {}
    for outcome in baselines:
        if outcome.subject.id == BASELINE and not outcome.invalid:
            flown.setdefault(outcome.situation, {})[outcome.seed] = outcome
    pooled = {key: own for key, own in flown.items() if len(own) >= LEAST}
    common = sorted(set.intersection(*(set(own) for own in pooled.values()))) if pooled else []
    if len(common) < max(FROM, LEAST + seeds) or not seeds:
        return Redraw()
    drawn = _Drawn({key: [own[seed] for seed in common] for key, own in pooled.items()})
    draw = np.random.Generator(np.random.PCG64(SEED))
    counts = dict.fromkeys((Kind.SAFETY, Kind.OPERABILITY), 0)
    for _ in range(redraws):
        order = draw.permutation(len(common))
        for kind in counts:
            p = drawn.p(order[:seeds], order[seeds : seeds + LEAST], kind)
            counts[kind] += min(p.values(), default=1.0) <= alpha
    return Redraw(seeds, *(Ratio(count, redraws) for count in counts.values()))


class _Drawn:
    """Baselines of the same seeds in each situation.

    Args:
        flown: by situation, in the order of the seeds.
    """

    def __init__(self, flown: Mapping[str, Sequence[Outcome]]) -> None:
        self._violated = {
            key: [tuple(violation.requirement for violation in outcome.violations) for outcome in own]
            for key, own in flown.items()
        }
        self._counted: dict[tuple[str, str, Kind], NDArray[np.int64]] = {}
        for key, own in flown.items():
            readings = zip(*(outcome.readings for outcome in own), strict=True)
            for column in readings:
                facts = [(r.violated, r.open, r.violated or r.triggered > 0) for r in column]
                if column[0].kind is not Kind.REPORTED:
                    self._counted[key, column[0].requirement, column[0].kind] = np.array(facts, np.int64)

    def p(self, chosen: NDArray[np.int64], others: NDArray[np.int64], kind: Kind) -> dict[str, float]:
        """Adjusted p per requirement of some flights, judged as a mutant beside some others as the pool."""
        counts = {
            (key, name): Pair(key, name, own, len(others), *map(int, facts[others].sum(axis=0)))
            for (key, name, own), facts in self._counted.items()
            if own is kind
        }
        samples = [Sample(key, tuple(own[i] for i in chosen), infected=True) for key, own in self._violated.items()]
        pool = Pool(counts)
        return adjusted(samples, pool, pool.requirements(kind))
