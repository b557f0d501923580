"""The arms: what proposes the next situation, behind an opening that all of them share."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import chain, count, islice
from typing import TYPE_CHECKING

from scaloft_fi.campaign.runs.seeking.proposals import (
    GENERATION,
    IMPOSSIBLE,
    OPENING,
    TRIES,
    MakeProposer,
    Parameters,
    Possible,
    Proposal,
    Proposals,
    Proposer,
    at_shares,
    opening,
    placed,
)
from scaloft_fi.sim.situation import Situation
from scaloft_fi.streams import key_words
from search_or_chance.pairs import array

if TYPE_CHECKING:
    from scaloft_fi.sim.grid import Grid

MOST_LOG2 = 10
"""A sequence ends after 2^10 points; no budget of the experiment reaches that."""
Sequence_ = Callable[["Grid", int], Iterator[Parameters]]
"""The parameters that an arm proposes after the opening, from the grid and the seed of the search."""


class Listed:
    """Proposes the situations of a sequence, whatever their distances.

    Args:
        grid: the grid.
        possible: whether a situation can be flown; others are left out.
        parameters: the sequence.
    """

    def __init__(self, grid: Grid, possible: Possible, parameters: Iterator[Parameters]) -> None:
        self._grid, self._possible, self._parameters = grid, possible, parameters
        self._known: dict[Situation, float] = {}

    def ask(self) -> list[Proposal]:
        """The next generation: distinct situations that were not proposed before; fewer at the end of the sequence."""
        asked: dict[Situation, None] = {}
        for parameters in islice(self._parameters, GENERATION * TRIES):
            situation = placed(self._grid, parameters)
            if situation is not None and situation not in self._known and self._possible(situation):
                asked[situation] = None
            if len(asked) == GENERATION:
                break
        return [Proposal(situation, None, IMPOSSIBLE) for situation in asked]

    def tell(self, proposed: Sequence[Proposal]) -> None:
        """Tell the distances of a generation; they change nothing."""
        self._known |= {one.situation: one.distance for one in proposed}

    @property
    def nearest(self) -> float:
        """The least distance so far."""
        return min(self._known.values(), default=IMPOSSIBLE)

    @property
    def count(self) -> int:
        """Situations flown so far."""
        return len(self._known)


def _at_random(grid: Grid, seed: int) -> Iterator[Parameters]:
    """The opening goes on."""
    return islice(opening(grid, seed, 2**MOST_LOG2), OPENING, None)


def _low_discrepancy(grid: Grid, seed: int) -> Iterator[Parameters]:
    """A scrambled Sobol sequence over a level for each axis, and a share for each number."""
    from scipy.stats import qmc  # takes longer to import than the plan takes

    columns = {(axis.id, "level"): place for place, axis in enumerate(grid.axes)}
    numbered = [*(axis.id for axis in grid.axes if axis.range), *(axis.id for axis in grid.free)]
    columns |= {(axis, "number"): place for place, axis in enumerate(numbered, len(columns))}
    sequence = qmc.Sobol(len(columns), scramble=True, seed=key_words("search or chance", "sobol", seed)[0])
    for point in sequence.random_base2(MOST_LOG2).tolist():
        yield at_shares(grid, lambda axis, what, point=point: point[columns[axis, what]])  # type: ignore[misc]


def _pairwise(grid: Grid, seed: int) -> Iterator[Parameters]:
    """Arrays of all pairs, one after the other."""
    for number in count():
        yield from array(grid, seed, number)


def _chance(sequence: Sequence_) -> MakeProposer:
    def make(grid: Grid, possible: Possible, seed: int, _mutant: str) -> Proposer:
        return Listed(grid, possible, chain(opening(grid, seed), sequence(grid, seed)))

    return make


SEARCH = "seek"
ARMS: Mapping[str, MakeProposer] = {
    SEARCH: Proposals,
    "random": _chance(_at_random),
    "low-discrepancy": _chance(_low_discrepancy),
    "2-way": _chance(_pairwise),
}
