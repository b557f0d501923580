"""The arms: what proposes the situations after the opening, which is `seek`'s and the same in all of them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import count, islice
from typing import TYPE_CHECKING

from experiments.search_or_chance.pairs import Share, array
from scaloft_fi.campaign.seeking.proposals import (
    EDGES,
    IMPOSSIBLE,
    MakeProposer,
    Parameters,
    Possible,
    Proposal,
    Proposals,
    Proposer,
    at_shares,
    placed,
)
from scaloft_fi.sim.situation import DEVIATES, Situation
from scaloft_fi.streams import key_words

if TYPE_CHECKING:
    from scaloft_fi.sim.grid import Grid

MOST_LOG2 = 8
"""The low-discrepancy sequence ends after 2^8 points; no budget of the experiment reaches that."""
Shares = Callable[["Grid", int], Iterator[Share]]
"""The shares of each situation that an arm proposes, from the grid and the seed of the search."""


@dataclass
class Listed:
    """Proposes for one mutant, whatever the distances, the next situations of a list that its block shares."""

    left: Iterator[Proposal]
    nearest: float = IMPOSSIBLE
    count: int = 0

    def ask(self, count: int) -> list[Proposal]:
        """The next situations; fewer at the end of the list."""
        return list(islice(self.left, count))

    def tell(self, distances: Sequence[tuple[Proposal, float]]) -> None:
        """Tell the distances; they change no proposal."""
        self.count += len(distances)
        self.nearest = min([self.nearest, *(distance for _, distance in distances)])


@dataclass
class Chance:
    """Makes the proposers of one search, which share one list.

    Attributes:
        shares: what the list is made from.
    """

    shares: Shares
    _list: Iterator[Proposal] | None = None

    def __call__(self, grid: Grid, possible: Possible, seed: int, _mutant: str) -> Proposer:
        """The proposer of a mutant."""
        self._list = self._list or _distinct(grid, possible, seed, self.shares)
        return Listed(self._list)


def _distinct(grid: Grid, possible: Possible, seed: int, shares: Shares) -> Iterator[Proposal]:
    """Situations that can be flown, each once."""
    known: set[Situation] = set()
    for share in shares(grid, seed):
        parameters = with_ends(grid, share)
        situation = placed(grid, parameters)
        if situation is not None and situation not in known and possible(situation):
            known.add(situation)
            yield Proposal(situation, parameters)


def with_ends(grid: Grid, share: Share) -> Parameters:
    """The parameters at shares, half of the numbers off their benign values at an end of their range.

    So it is in the opening, but here a number follows from one share, and the greater from the greater.
    """

    def ended(axis: str, what: str) -> float:
        drawn = share(axis, what)
        inside = ((drawn - 1 + DEVIATES) / DEVIATES - (1 - EDGES) / 2) / EDGES
        if what == "level" or drawn < 1 - DEVIATES:
            return drawn
        return min(1 - DEVIATES + DEVIATES * max(inside, 0.0), 1 - 2**-53)

    return at_shares(grid, ended)


def _at_random(_grid: Grid, seed: int) -> Iterator[Share]:
    """Each share at random."""

    def share(number: int, axis: str, what: str) -> float:
        return (key_words("search or chance", "random", seed, number, axis, what)[0] >> 11) / 2**53

    return (partial(share, number) for number in count())


def _low_discrepancy(grid: Grid, seed: int) -> Iterator[Share]:
    """A scrambled Sobol sequence over a level for each axis, and a share for each number."""
    from scipy.stats import qmc  # takes longer to import than the plan takes

    asked = [*((axis.id, "level") for axis in grid.axes), *((axis.id, "number") for axis in grid.free)]
    columns = {what: place for place, what in enumerate(asked)}
    sequence = qmc.Sobol(len(columns), scramble=True, seed=key_words("search or chance", "sobol", seed)[0])
    for point in sequence.random_base2(MOST_LOG2).tolist():
        yield lambda axis, what, point=point: point[columns[axis, what]]  # type: ignore[misc]


def _pairwise(grid: Grid, seed: int) -> Iterator[Share]:
    """Arrays of all pairs, one after the other."""
    for number in count():
        yield from array(grid, seed, number)


SEARCH = "seek"
ARMS: Mapping[str, Callable[[], MakeProposer]] = {
    SEARCH: lambda: Proposals,
    "random": partial(Chance, _at_random),
    "low-discrepancy": partial(Chance, _low_discrepancy),
    "2-way": partial(Chance, _pairwise),
}
"""What makes the proposers of one search, by arm."""
