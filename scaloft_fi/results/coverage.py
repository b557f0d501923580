"""Situation coverage: how much of the grid was flown."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import combinations
from math import prod

from scaloft_fi.results.outcome import BASELINE, Outcome
from scaloft_fi.results.ratio import Ratio
from scaloft_fi.results.space import Space

STRENGTHS = (1, 2, 3, 4, 5)


@dataclass(frozen=True)
class Coverage:
    """Coverage of the situation space.

    Attributes:
        situations: distinct situations flown, of the grid.
        draws: test cases flown, a situation with a seed each.
        t_way: per strength t, the combinations of values of t axes that were flown, of all there are.
        realised: situations whose every value came true together in a baseline flight, of the grid.
        by_axis: per axis, the situations whose value there came true in a baseline flight, of those with one.
    """

    situations: Ratio
    draws: int
    t_way: tuple[tuple[int, Ratio], ...]
    realised: Ratio
    by_axis: tuple[tuple[str, Ratio], ...]


def coverage(outcomes: Iterable[Outcome], space: Space) -> Coverage:
    """Coverage by the flights that count; a flight outside the grid or an invalid one covers nothing."""
    valid = [outcome for outcome in outcomes if not outcome.invalid and outcome.situation in space.point]
    flown = {outcome.situation for outcome in valid}
    baselines = [outcome for outcome in valid if outcome.mutant == BASELINE]
    judged = {outcome.situation for outcome in baselines}
    came_true = {(outcome.situation, axis) for outcome in baselines for axis, true in outcome.realised if true}
    whole = {
        outcome.situation for outcome in baselines if outcome.realised and all(true for _, true in outcome.realised)
    }
    return Coverage(
        situations=Ratio(len(flown), len(space.points)),
        draws=len({(outcome.situation, outcome.seed) for outcome in valid}),
        t_way=tuple((strength, t_way(flown, space, strength)) for strength in STRENGTHS),
        realised=Ratio(len(whole), len(space.points)),
        by_axis=tuple(
            (axis, Ratio(sum((key, axis) in came_true for key in judged), len(judged))) for axis in space.axes
        ),
    )


def t_way(flown: Iterable[str], space: Space, strength: int) -> Ratio:
    """Combinations of the values of `strength` axes that some flown situation has, of all combinations."""
    points = [space.point[key] for key in flown]
    covered = possible = 0
    for axes in combinations(range(len(space.axes)), strength):
        covered += len({tuple(point[axis] for axis in axes) for point in points})
        possible += prod(len(space.values[axis]) for axis in axes)
    return Ratio(covered, possible)
