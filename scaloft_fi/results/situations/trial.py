"""What strategies are compared on: mutants flown in the same situations, and which situation killed which."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from scaloft_fi.results.roster import Roster
from scaloft_fi.results.scoring.score import Score
from scaloft_fi.results.situations.chance import Found
from scaloft_fi.results.situations.t_way import choices, ids, levels_of, t_way
from scaloft_fi.results.space import Space

STRENGTHS = (1, 2, 3, 4)
"""Strengths whose coverage is followed, as far as there are axes."""
MOST_COMBINATIONS = 4_000


@dataclass(frozen=True, eq=False)
class Trial:
    """Default mutants of credible cells, all flown in all of some situations.

    Attributes:
        space: the grid.
        situations: keys, in the grid's order.
        mutants: canonical ids.
        parameters: of each mutant.
        kills: (mutants, situations): whether a flight killed the mutant there, the eligible ones counted.
        left_out: ids of the default mutants that were not flown in all of the situations.
    """

    space: Space
    situations: tuple[str, ...]
    mutants: tuple[str, ...]
    parameters: tuple[str, ...]
    kills: Found
    left_out: tuple[str, ...]

    @property
    def kill_sets(self) -> Found:
        """(sets, situations): each different set of situations in which some mutant is killed, once."""
        return np.unique(self.kills[self.kills.any(axis=1)], axis=0)

    @cached_property
    def followed(self) -> tuple[tuple[int, Found, int], ...]:
        """The combinations of each strength whose coverage is followed, as `combinations` gives them.

        Of a large grid the higher strengths are left out: they have too many.
        """
        strengths = [strength for strength in STRENGTHS if strength <= len(self.space.axes)]
        every = ((strength, *self.combinations(strength)) for strength in strengths)
        return tuple(
            (strength, found, possible) for strength, found, possible in every if possible <= MOST_COMBINATIONS
        )

    def combinations(self, strength: int) -> tuple[Found, int]:
        """(combinations, situations) of `strength` axes that the situations have, and how many the grid has."""
        levels = levels_of(self.situations, self.space)
        rows = []
        for axes, _ in choices(self.space, strength):
            column = ids(levels, self.space, axes)
            rows += [column == code for code in np.unique(column)]
        return np.stack(rows), t_way(self.situations, self.space, strength).total.whole


def trial(scored: Score, roster: Roster, space: Space) -> Trial | None:
    """The largest set of situations that many mutants have in common, and those mutants; None when nothing was flown.

    The situations are those that most mutants were flown in, the larger set of equals.
    """
    counted = [mutant for mutant in scored.mutants if roster.counts(mutant.subject)]
    flown = {m.subject.id: frozenset(r.situation for r in m.results if r.flown) & set(space.point) for m in counted}
    sets = Counter(found for found in flown.values() if found)
    if not sets:
        return None
    common = max(sets, key=lambda found: (sets[found], len(found), sorted(found)))
    situations = tuple(sorted(common, key=space.rank))
    taken = [mutant for mutant in counted if common <= flown[mutant.subject.id]]
    killed = [{result.situation for result in mutant.results if result.kills} for mutant in taken]
    return Trial(
        space=space,
        situations=situations,
        mutants=tuple(mutant.subject.id for mutant in taken),
        parameters=tuple(mutant.subject.parameter for mutant in taken),
        kills=np.array([[key in found for key in situations] for found in killed], bool),
        left_out=tuple(mutant.subject.id for mutant in counted if mutant not in taken),
    )


def sub_cube(space: Space, killing: Sequence[str]) -> int | None:
    """The t for which a mutant dies exactly where t axes have certain values; None when its kills are no such block.

    0 when it dies everywhere.
    """
    points = [space.point[key] for key in killing]
    seen = [{point[axis] for point in points} for axis in range(len(space.axes))]
    block = [
        point for _, point in space.points if all(value in found for value, found in zip(point, seen, strict=True))
    ]
    open_ = [{point[axis] for _, point in space.points} for axis in range(len(space.axes))]
    fixed = [len(found) == 1 and len(every) > 1 for found, every in zip(seen, open_, strict=True)]
    free = all(one or found == every for one, found, every in zip(fixed, seen, open_, strict=True))
    return sum(fixed) if points and free and len(block) == len(set(points)) else None
