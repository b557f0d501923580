"""Situations spread evenly over all axes: the points of a scrambled Sobol sequence.

A Sobol sequence continues: a larger choice includes every smaller one, and points that no situation has are skipped
(constraints, `--situation`).  A Latin hypercube allows neither.  On seven axes of 2 to 4 values, means of 60 seeds: 8
points of both have 85 % of the pairs of values (random: 75 %), 32 points have 96 % of the triples (Latin hypercube:
91 %, random: 88 %).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from scaloft_fi.sim.situation import Situation
from scaloft_fi.streams import key_words

if TYPE_CHECKING:
    from scaloft_fi.judge.space import Space

MOST_LOG2 = 17
"""The search ends after 2^17 points of the sequence."""


def spread(pool: Sequence[Situation], space: Space, count: int, seed: int) -> tuple[Situation, ...]:
    """The first `count` distinct situations of the sequence, fewer if the search ends before.

    Args:
        pool: situations of the grid to choose from.
        space: the grid.
        count: how many.
        seed: seed of the choice, which scrambles the sequence.
    """
    from scipy.stats import qmc  # takes longer to import than other verbs take

    ranges = dict(space.ranges)
    levels = {axis: sorted({one[axis] for one in pool}) for axis in space.axes}
    for axis, range_ in ranges.items():
        levels[axis].sort(key=range_.ids.index)  # neighbouring numbers in neighbouring bins
    varied = [axis for axis in space.axes if axis in ranges or len(levels[axis]) > 1]
    scramble = key_words("choice", "sobol", seed)[0]
    known = {one.levels for one in pool}
    found: dict[Situation, None] = {}
    for log2 in range(min((count - 1).bit_length(), MOST_LOG2), MOST_LOG2 + 1):
        sequence = qmc.Sobol(max(1, len(varied) + len(space.free)), scramble=True, seed=scramble)
        for point in sequence.random_base2(log2).tolist():
            shares = dict(zip((*varied, *(axis for axis, _ in space.free)), point, strict=False))
            bins, numbers = {}, {}
            for axis, ids in levels.items():
                place, rest = divmod(shares.get(axis, 0.0) * len(ids), 1.0)
                bins[axis] = ids[int(place)]
                if axis in ranges:
                    numbers[axis] = ranges[axis].draw(bins[axis], rest)
            for axis, free in space.free:
                number = free.drawn(shares[axis]) if free.goes_with(bins) else None
                if number is not None and number != free.benign:
                    numbers[axis] = number
            if tuple(bins.items()) in known:
                found[Situation.of(bins, numbers)] = None
            if len(found) == count:
                return tuple(found)
    return tuple(found)
