"""What strategies are compared on: mutants flown in the same situations, and which situation killed which."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from experiments.coverage_against_kills.chance import Found
from experiments.coverage_against_kills.redrawn import SeedSet, seed_draws
from scaloft_fi.analysis.coverage import choices, ids, levels_of, t_way
from scaloft_fi.analysis.detection import Spending
from scaloft_fi.analysis.roster import Roster
from scaloft_fi.analysis.score import MutantScore, Score, mutant_score
from scaloft_fi.judge.space import Space
from scaloft_fi.judge.status import INVALID, Rulings, Situations

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
        kills: (mutants, situations): whether a safety requirement kills the mutant there.
        left_out: ids of the default mutants that were not flown in all of the situations.
        unkilled: ids of the mutants that are detected though they are killed in no situation.
        seeds: that all of the mutants were flown with.
        more_seeds: that some of them were flown with besides; their flights are in every redrawn campaign.
        seed_sets: the campaign judged by some of `seeds`; empty where there are not two.
    """

    space: Space
    situations: tuple[str, ...]
    mutants: tuple[str, ...]
    parameters: tuple[str, ...]
    kills: Found
    left_out: tuple[str, ...] = ()
    unkilled: tuple[str, ...] = ()
    seeds: tuple[int, ...] = ()
    more_seeds: tuple[int, ...] = ()
    seed_sets: tuple[SeedSet, ...] = ()

    @property
    def killed(self) -> int:
        """Mutants killed in some situation."""
        return int(self.kills.any(axis=1).sum())

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


def trial(
    scored: Score, rulings: Rulings, roster: Roster, space: Space, spending: Spending | None = None
) -> Trial | None:
    """The largest set of situations that many mutants have in common, and those mutants; None when nothing was flown.

    The situations are those that most mutants were flown in, the larger set of equals.

    Args:
        scored: the campaign's score.
        rulings: what it was made of.
        roster: which mutants count.
        space: the grid.
        spending: of alpha, as the score has it.
    """
    counted = [mutant for mutant in scored.mutants if roster.counts(mutant.subject)]
    flown = {m.subject.id: frozenset(r.situation for r in m.results if r.flown) & set(space.point) for m in counted}
    sets = Counter(found for found in flown.values() if found)
    if not sets:
        return None
    common = max(sets, key=lambda found: (sets[found], len(found), sorted(found)))
    situations = tuple(sorted(common, key=space.rank))
    taken = [mutant for mutant in counted if common <= flown[mutant.subject.id]]
    seeds = [_seeds(rulings.mutants[mutant.subject]) for mutant in taken]
    shared, every = frozenset.intersection(*seeds), frozenset.union(*seeds)

    def judged(mutant: MutantScore, drawn: Iterable[int]) -> MutantScore:
        if not mutant.seen_in:  # what all flights do not violate some of them do not either
            return mutant
        kept = every - shared | set(drawn)
        flights = rulings.mutants[mutant.subject].items()
        fewer = {key: [one for one in own if one.seed in kept] for key, own in flights}
        return mutant_score(mutant.subject, fewer, space, scored.pool, spending or Spending())

    return Trial(
        space=space,
        situations=situations,
        mutants=tuple(mutant.subject.id for mutant in taken),
        parameters=tuple(mutant.subject.parameter for mutant in taken),
        kills=_kills(taken, situations),
        left_out=tuple(mutant.subject.id for mutant in counted if mutant not in taken),
        unkilled=tuple(mutant.subject.id for mutant in taken if mutant.detected and not mutant.kills),
        seeds=tuple(sorted(shared)),
        more_seeds=tuple(sorted(every - shared)),
        seed_sets=tuple(
            SeedSet(drawn, chance, _kills([judged(mutant, drawn) for mutant in taken], situations))
            for drawn, chance in (seed_draws(sorted(shared)) if len(shared) > 1 else ())
        ),
    )


def _seeds(situations: Situations) -> frozenset[int]:
    """Of a mutant's flights that count."""
    return frozenset(one.seed for own in situations.values() for one in own if one.ruling is not INVALID)


def _kills(mutants: Iterable[MutantScore], situations: Sequence[str]) -> Found:
    return np.array([np.isin(situations, mutant.killing) for mutant in mutants], bool)


def sub_cube(space: Space, killing: Sequence[str]) -> int | None:
    """The t for which a mutant is killed exactly where t axes have certain values; None where there is none.

    0 when it is killed everywhere.
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
