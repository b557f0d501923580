"""A campaign redrawn: seeds and mutants resampled with replacement, by which intervals are made.

A bootstrap in which a redrawn campaign is judged anew: of the n seeds that the mutants share, n are drawn with
replacement, and the verdicts are those of the flights with the seeds that came out, beside the whole baseline pool.
Then the mutants are resampled within their parameter, or the different kill sets among each other.  Fewer seeds come
out than were flown, so a redrawn campaign is a smaller one, and an interval need not be centred on the campaign flown.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from math import comb

import numpy as np
from numpy.typing import NDArray

from experiments.coverage_against_kills.chance import Found
from scaloft_fi.streams import generator

MOST_SUBSETS = 64
"""Greatest number of sets of seeds that are judged; of more sets, a sample of this size."""
RESAMPLES = 2_000
Counts = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class SeedSet:
    """The seeds that may come out.

    Attributes:
        seeds: distinct.
        chance: that exactly these come out.
        kills: (mutants, situations): the kills by the flights with these seeds.
    """

    seeds: tuple[int, ...]
    chance: float
    kills: Found


@dataclass(frozen=True, eq=False)
class Redrawn:
    """Redrawn campaigns, as how often each kill set is in them.

    Attributes:
        kill_sets: (kill sets, situations): each different one of the campaign and of its seed sets, also the empty one.
        place: (mutants,): the kill set of each mutant in the campaign flown.
        mutants: (1 + resamples, kill sets): mutants with that kill set, first in the campaign flown.
        distinct: the same where mutants with equal kill sets count once, and those without a kill not at all.
    """

    kill_sets: Found
    place: NDArray[np.int64]
    mutants: Counts
    distinct: Counts


def seed_draws(seeds: Sequence[int]) -> list[tuple[tuple[int, ...], float]]:
    """Which seeds come out of as many draws with replacement, each set with its chance.

    >>> [(drawn, round(27 * chance)) for drawn, chance in seed_draws([0, 1, 2])][2:5]
    [((2,), 1), ((0, 1), 6), ((0, 2), 6)]
    """
    n = len(seeds)
    if 2**n - 1 <= MOST_SUBSETS:
        chances = {size: _onto(n, size) / n**n for size in range(1, n + 1)}
        return [(drawn, chances[size]) for size in chances for drawn in combinations(seeds, size)]
    rng = generator("redrawn seeds")
    found = Counter(tuple(sorted(set(rng.choice(seeds, n).tolist()))) for _ in range(MOST_SUBSETS))
    return [(drawn, count / MOST_SUBSETS) for drawn, count in sorted(found.items())]


def _onto(draws: int, size: int) -> int:
    """Number of sequences of draws that contain each of `size` seeds and no other seed."""
    return sum((-1) ** (size - some) * comb(size, some) * some**draws for some in range(size + 1))


def redrawn(parameters: Sequence[str], kills: Found, seed_sets: Sequence[SeedSet]) -> Redrawn:
    """Redraw a campaign.

    Args:
        parameters: of each mutant.
        kills: (mutants, situations): the kills of the campaign flown.
        seed_sets: empty where seeds are not resampled.
    """
    mutants = len(kills)
    every = np.concatenate([kills, *(one.kills for one in seed_sets)])
    kill_sets, places = np.unique(every, axis=0, return_inverse=True)
    place, *others = places.reshape(-1, mutants)
    chances = [one.chance for one in seed_sets] or [1.0]
    drawn = np.asarray(generator("seed sets").choice(len(chances), RESAMPLES, p=chances))
    weights, killing = resamples(parameters), np.asarray(kill_sets.any(axis=1))
    rng = generator("resampled kill sets")
    counts = np.zeros((RESAMPLES, len(kill_sets)))
    distinct = np.zeros_like(counts)
    for number, own in enumerate(others or [place]):
        taken = drawn == number
        counts[taken] = weights[taken] @ np.eye(len(kill_sets))[own]
        present = np.unique(own[killing[own]])
        if len(present):
            evenly = np.full(len(present), 1 / len(present))
            distinct[np.ix_(taken, present)] = rng.multinomial(len(present), evenly, int(taken.sum()))
    flown = np.bincount(place, minlength=len(kill_sets)).astype(float)
    return Redrawn(
        kill_sets=kill_sets,
        place=place,
        mutants=np.vstack([flown, counts]),
        distinct=np.vstack([(flown > 0) & killing, distinct]),
    )


def resamples(parameters: Sequence[str]) -> Counts:
    """(resamples, mutants): how often each mutant is in each bootstrap sample.

    Drawn within each parameter: the mutants of one parameter are no independent sample of those of another.
    """
    rng = generator("resampled mutants")
    weights = np.zeros((RESAMPLES, len(parameters)))
    for parameter in sorted(set(parameters)):
        members = [place for place, other in enumerate(parameters) if other == parameter]
        weights[:, members] = rng.multinomial(len(members), np.full(len(members), 1 / len(members)), RESAMPLES)
    return weights
