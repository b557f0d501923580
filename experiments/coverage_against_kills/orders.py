"""Orders of the situations, by which suites of any size are chosen."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import chain, permutations, product
from math import factorial, prod

import numpy as np
from numpy.typing import NDArray

from experiments.coverage_against_kills.chance import Found, Positions
from scaloft_fi.analysis.coverage import Levels, levels_of, table
from scaloft_fi.judge.space import Space
from scaloft_fi.streams import generator

MOST_RELABELLINGS = 5_000
"""Greatest number of relabellings that are all taken; of more, a sample of this size."""
SAMPLE = 1_000


def positions(order: Sequence[int] | NDArray[np.int64]) -> Positions:
    """(situations,): the place of each situation in an order of their numbers."""
    return np.argsort(np.asarray(order, np.int64))


def random(situations: int, orders: int, *key: object) -> Positions:
    """Random orders, the same for the same key."""
    rng = generator("orders", *key)
    return np.stack([rng.permutation(situations) for _ in range(orders)])


def greedy_t_way(space: Space, keys: Sequence[str], ties: int, *key: object) -> Positions:
    """Always a situation with the most combinations not yet covered: first of one axis, then of two, and so on.

    Incremental interaction coverage (Huang and others, IJSEKE 23(10), 2013).  Ties are broken at random.

    Args:
        space: the grid.
        keys: the situations to order.
        ties: how many orders begin with each situation, each breaking later ties its own way.
        key: of the random stream.
    """
    tables = [table(levels_of(keys, space), space, strength) for strength in range(1, len(space.axes) + 1)]
    rng = generator("ties", *key)
    shuffled = [rng.permutation(len(keys)) for _ in range(ties * len(keys))]
    # every situation alone covers as much as any other: each begins equally often
    begun = [np.concatenate([[i % len(keys)], row[row != i % len(keys)]]) for i, row in enumerate(shuffled)]
    return np.stack([positions(_rising(tables, row)) for row in begun])


def _rising(tables: Sequence[tuple[NDArray[np.int64], int]], shuffled: NDArray[np.int64]) -> list[int]:
    """One order; of equals the first in `shuffled`."""
    order: list[int] = []
    left = list(shuffled)
    for codes, size in tables:
        if not left:
            break
        open_ = np.zeros(size, bool)
        open_[codes] = True
        open_[codes[order]] = False
        while left and open_.any():
            row = left.pop(int(open_[codes[left]].sum(axis=1).argmax()))
            order.append(int(row))
            open_[codes[row]] = False
    return order + [int(row) for row in left]


def greedy_by_kills(kills: Found) -> Positions:
    """(1, situations): always the situation that kills the most mutants still alive, the first of equals.

    An oracle: it knows what the flights were to find out.
    """
    alive, order = np.ones(len(kills), bool), list[int]()
    left = list(range(kills.shape[1]))
    while left:
        best = left.pop(int(kills[alive][:, left].sum(axis=0).argmax()))
        order.append(best)
        alive &= ~kills[:, best]
    return positions(order)[None, :]


def relabelled(space: Space, keys: Sequence[str], suite: Sequence[str], *key: object) -> NDArray[np.int64]:
    """(suites, size): the suite under renamings of axes and values, so that no lucky labels decide.

    Axes with equally many values change places, the values of each axis too: 3,840 ways for five binary axes.
    Renamings that leave `keys` (a constraint, a situation not flown) are left out.

    Args:
        space: the grid.
        keys: the situations that may be chosen; the suites are numbers into them.
        suite: the situations that are renamed.
        key: of the random stream of the sample, when there are more than `MOST_RELABELLINGS`.
    """
    levels = levels_of(suite, space)
    place = {tuple(row): number for number, row in enumerate(levels_of(keys, space).tolist())}
    found = set()
    for axes, values in _renamings(space, key):
        renamed = np.stack([values[axis][levels[:, source]] for axis, source in enumerate(axes)], axis=1)
        rows = [place.get(tuple(row), -1) for row in renamed.tolist()]
        if -1 not in rows:
            found.add(tuple(sorted(rows)))
    return np.array(sorted(found), np.int64).reshape(len(found), len(suite))


def _renamings(space: Space, key: tuple[object, ...]) -> Iterator[tuple[tuple[int, ...], tuple[Levels, ...]]]:
    """Per axis the axis that stands in for it, and the new place of each value."""
    sizes = [len(values) for values in space.values]
    alike = [[axis for axis, size in enumerate(sizes) if size == one] for one in sorted(set(sizes))]
    ways = prod(factorial(len(group)) for group in alike) * prod(map(factorial, sizes))
    if ways <= MOST_RELABELLINGS:
        for swapped in product(*map(permutations, alike)):
            source = dict(zip(chain(*alike), chain(*swapped), strict=True))
            for values in product(*(permutations(range(size)) for size in sizes)):
                yield tuple(source[axis] for axis in range(len(sizes))), tuple(map(np.array, values))
        return
    rng = generator("relabelled", *key)
    for _ in range(SAMPLE):
        source = {
            axis: int(other) for group in alike for axis, other in zip(group, rng.permutation(group), strict=True)
        }
        yield tuple(source[axis] for axis in range(len(sizes))), tuple(rng.permutation(size) for size in sizes)
