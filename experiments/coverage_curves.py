"""Coverage against kills: what suites of k situations cover and kill, by each strategy of choosing them.

The comparison is with random situations at equal k (Chen and others, "Revisiting the relationship between fault
detection, test adequacy criteria, and test set size", ASE 2020): the size of a suite is what a strategy costs.

The chance that something is met by k situations (a mutant by one that kills it, a combination by one that has it) is
exact.  With a random order a mutant killed in d of N situations is killed within k of them with the probability
1 - C(N-d, k)/C(N, k); the same is the expected coverage of a combination that d situations have.  So for a mutant that
is killed exactly where t axes have certain values, kills at k and t-way coverage at k are one number.

Intervals are a bootstrap in which a redrawn campaign is judged anew: of the n seeds that the mutants share, n are drawn
with replacement, and the verdicts are those of the flights with the seeds that came out, beside the whole pool.  Then
the mutants are resampled within their parameter, or the different kill sets among each other.  Fewer seeds come
out than were flown, so a redrawn campaign is a smaller one, and an interval need not be centred on the campaign flown.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from itertools import chain, combinations, permutations, product
from math import comb

import numpy as np
from numpy.typing import NDArray

from scaloft_fi.analysis.coverage import Levels, choices, covering_array, ids, levels_of, t_way, table
from scaloft_fi.analysis.detection import Spending
from scaloft_fi.analysis.roster import Roster
from scaloft_fi.analysis.score import MutantScore, Score, mutant_score
from scaloft_fi.judge.space import Space
from scaloft_fi.judge.status import INVALID, Rulings, Situations
from scaloft_fi.streams import generator

Found = NDArray[np.bool_]
"""(things, situations): whether the situation meets the thing."""
Chances = NDArray[np.float64]
"""(things, k): chance that the thing is met within the first k + 1 situations."""
Positions = NDArray[np.int64]
"""(orders, situations): the place of each situation in the order, from 0."""


def without_replacement(situations: int) -> Chances:
    """(d, k): 1 - C(N-d, k+1)/C(N, k+1) for N situations of which d = 0..N meet the thing.

    >>> [round(float(without_replacement(32)[d, 5]), 3) for d in (16, 8, 4, 2, 1)]  # 6 of 2^5; method: 1 to 5 axes
    [0.991, 0.851, 0.584, 0.345, 0.188]
    """
    d = np.arange(situations + 1)[:, None]
    k = np.arange(situations)[None, :]
    # the (k+1)-th situation misses too with the chance (N - d - k)/(N - k)
    missed = np.clip((situations - d - k) / (situations - k), 0.0, 1.0)
    return np.asarray(1.0 - np.cumprod(missed, axis=1))


def with_replacement(situations: int) -> Chances:
    """(d, k): 1 - (1 - d/N)^(k+1) for draws that may repeat."""
    d = np.arange(situations + 1)[:, None]
    return np.asarray(1.0 - (1.0 - d / situations) ** (np.arange(situations)[None, :] + 1))


def in_orders(found: Found, positions: Positions) -> Chances:
    """The share of the orders in which each thing is met within k + 1 situations."""
    orders, situations = positions.shape
    met = [np.bincount(row, minlength=situations + 1)[:situations] for row in firsts(found, positions).T]
    return np.asarray(np.cumsum(np.reshape(met, (len(found), situations)), axis=1) / orders)


def firsts(found: Found, positions: Positions) -> Positions:
    """(orders, things): the place of the first situation that meets the thing; N where none does."""
    orders, situations = positions.shape
    first = np.full((orders, len(found)), situations, np.int64)
    for thing, row in enumerate(found):
        if row.any():
            first[:, thing] = positions[:, row].min(axis=1)
    return first


def at_sizes(found: Found, positions: Positions) -> Positions:
    """(orders, k): how many things the first k + 1 situations of each order meet."""
    first = firsts(found, positions)
    return np.stack([(first <= k).sum(axis=1) for k in range(found.shape[1])], axis=1)


def in_subsets(found: Found, suites: NDArray[np.int64]) -> Chances:
    """Met by k + 1 situations drawn from a suite without replacement, on average over the suites (suites, size)."""
    size = suites.shape[1]
    by_count = without_replacement(size)
    return np.reshape([by_count[row[suites].sum(axis=1)].mean(axis=0) for row in found], (len(found), size))


def apfd(chances: Chances) -> float | None:
    """Average percentage of faults detected, over the faults that a whole order detects; None without any.

    1 - (TF1 + ... + TFm)/(n m) + 1/(2n), TF the place of the first situation that detects a fault (Rothermel, Untch,
    Chu, Harrold, IEEE TSE 27, 2001).  Under a random order TF is (N+1)/(d+1) on average.

    >>> round(apfd(without_replacement(32)[[16]]), 3), round(apfd(without_replacement(32)[[1]]), 3)
    (0.955, 0.5)
    """
    detected = chances[chances[:, -1] > 1 - 1e-9]
    if not len(detected):
        return None
    n = detected.shape[1]
    # the mean of a place from 1 on is the sum of the chances to be still waiting
    place = 1.0 + (1.0 - detected[:, :-1]).sum(axis=1)
    return float(1.0 - place.mean() / n + 1.0 / (2 * n))


def positions(order: Sequence[int] | NDArray[np.int64]) -> Positions:
    """(situations,): the place of each situation in an order of their numbers."""
    return np.argsort(np.asarray(order, np.int64))


def random_orders(situations: int, orders: int, *key: object) -> Positions:
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


def relabelled(space: Space, keys: Sequence[str], suite: Sequence[str]) -> NDArray[np.int64]:
    """(suites, size): the suite under renamings of axes and values, so that no lucky labels decide.

    Axes with equally many values change places, the values of each axis too: 3,840 ways for five binary axes.
    Renamings that leave `keys` (a constraint, a situation not flown) are left out.

    Args:
        space: the grid.
        keys: the situations that may be chosen; the suites are numbers into them.
        suite: the situations that are renamed.
    """
    levels = levels_of(suite, space)
    place = {tuple(row): number for number, row in enumerate(levels_of(keys, space).tolist())}
    found = set()
    for axes, values in _renamings([len(values) for values in space.values]):
        renamed = np.stack([values[axis][levels[:, source]] for axis, source in enumerate(axes)], axis=1)
        rows = [place.get(tuple(row), -1) for row in renamed.tolist()]
        if -1 not in rows:
            found.add(tuple(sorted(rows)))
    return np.array(sorted(found), np.int64).reshape(len(found), len(suite))


def _renamings(sizes: Sequence[int]) -> Iterator[tuple[tuple[int, ...], tuple[Levels, ...]]]:
    """Per axis the axis that stands in for it, and the new place of each value; `sizes` has how many each axis has."""
    alike = [[axis for axis, size in enumerate(sizes) if size == one] for one in sorted(set(sizes))]
    for swapped in product(*map(permutations, alike)):
        source = dict(zip(chain(*alike), chain(*swapped), strict=True))
        for values in product(*(permutations(range(size)) for size in sizes)):
            yield tuple(source[axis] for axis in range(len(sizes))), tuple(map(np.array, values))


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


STRENGTHS = (1, 2, 3, 4)
"""Strengths whose coverage is followed, as far as there are axes."""


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
        """The combinations of each strength, as `combinations` gives them."""
        strengths = [strength for strength in STRENGTHS if strength <= len(self.space.axes)]
        return tuple((strength, *self.combinations(strength)) for strength in strengths)

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


ARRAYS = (2, 3, 4)
ORDERS = 1_000
"""Random orders, for the spread between orders."""
GREEDY = 320
"""Orders of the greedy strategy, as many of them as can be shared out evenly over the situations to begin with."""
QUANTILES = (0.025, 0.975)
Floats = tuple[float, ...]


@dataclass(frozen=True)
class Band:
    """Values at k = 1, 2, ... with the bounds of an interval."""

    mean: Floats
    low: Floats
    high: Floats


@dataclass(frozen=True)
class Curve:
    """One strategy of choosing situations.

    Attributes:
        id, name, about: of the strategy.
        kills: mutants killed by k = 1, 2, ... situations, expected; 95 % interval over redrawn campaigns.
        kill_sets: the same of kill sets: mutants with equal ones count once.
        t_way: per strength, the share of the combinations covered, expected.
        difference: mutants killed more than by random situations at equal k, with a paired 95 % interval.
        distinct: the same of kill sets: the headline, as mutants that are killed in the same situations count once.
        apfd: of the mutants killed in some situation; None for a strategy that does not order them all.
        area: mean of the share of mutants killed, over the k of this strategy.
        random_area: the same of random situations over the same k.
        matched: the least k (with a fraction) at which random situations meet as many kill sets as the whole suite;
            None for a strategy that orders all of them.
    """

    id: str
    name: str
    about: str
    kills: Band
    kill_sets: Band
    t_way: tuple[tuple[int, Floats], ...]
    difference: Band
    distinct: Band
    apfd: float | None
    area: float
    random_area: float
    matched: float | None


@dataclass(frozen=True, eq=False)
class Curves:
    """All strategies on one axis of k.

    Attributes:
        trial: what they are compared on.
        curves: the strategies, random order first.
        spread: 5 % and 95 % quantile, over random orders, of the mutants killed at k.
        missing: strategies that could not be followed, each with the reason.
    """

    trial: Trial
    curves: tuple[Curve, ...]
    spread: Band
    missing: tuple[tuple[str, str], ...]

    def curve(self, name: str) -> Curve:
        """The strategy with that id."""
        return next(curve for curve in self.curves if curve.id == name)

    @property
    def compared(self) -> list[Curve]:
        """The strategies that are compared with random order: not itself, nor the oracle that knows the kills."""
        return [curve for curve in self.curves if curve.id not in ("random", "oracle")]


def curves(trial: Trial) -> Curves:
    """Follow every strategy over the trial."""
    compare, size, space, keys = _Compare(trial), len(trial.situations), trial.space, trial.situations
    ties = max(1, GREEDY // size)
    random, draws = without_replacement(size), with_replacement(size)
    rising = f"most new combinations of 1 axis, then of 2, ...: mean of {ties * size} orders"
    found = [
        compare.curve("random", "random order", "uniform without replacement: exact", lambda a: random[a.sum(axis=1)]),
        compare.curve(
            "draws", "random draws", "uniform with replacement: exact", lambda a: draws[a.sum(axis=1)], whole=False
        ),
        compare.ordered("lexicographic", "grid's order", "as listed, the last axis fastest", np.arange(size)[None, :]),
        compare.ordered("greedy", "greedy t-way", rising, greedy_t_way(space, keys, ties)),
    ]
    missing = []
    for strength in (strength for strength in ARRAYS if strength < len(space.axes)):
        name, suite = f"{strength}-way array", covering_array(space, keys, strength, 0)
        suites = relabelled(space, keys, suite)
        if len(suites) < 2:
            missing.append((name, "no renaming of its axes and values stays among the situations flown"))
            continue
        about = f"covering array of {len(suite)}: mean of {len(suites)} relabellings, in random order"
        found.append(compare.curve(f"{strength}-way", name, about, partial(in_subsets, suites=suites), whole=False))
    about, order = "most new kills first, as if they were known beforehand", greedy_by_kills(trial.kills)
    found.append(compare.ordered("oracle", "oracle", about, order))
    return Curves(trial, tuple(found), _spread(trial.kills), tuple(missing))


class _Compare:
    """Follows strategies over one trial, with the same redrawn campaigns for all."""

    def __init__(self, trial: Trial) -> None:
        self._again = redrawn(trial.parameters, trial.kills, trial.seed_sets)
        self._random = without_replacement(len(trial.situations))[self._again.kill_sets.sum(axis=1)]
        self._combinations = trial.followed

    def ordered(self, id_: str, name: str, about: str, positions: NDArray[np.int64]) -> Curve:
        """A strategy that orders all situations."""
        return self.curve(id_, name, about, lambda found: in_orders(found, positions))

    def curve(
        self, id_: str, name: str, about: str, chances: Callable[[Found], Chances], *, whole: bool = True
    ) -> Curve:
        """A strategy by the chances that it meets things within k situations; whole: it ends with all of them."""
        met, again = chances(self._again.kill_sets), self._again
        length = met.shape[1]
        random = self._random[:, :length]
        smaller = not whole and length < self._random.shape[1]
        sets = _band(again.distinct @ met)
        return Curve(
            id=id_,
            name=name,
            about=about,
            kills=_band(again.mutants @ met),
            kill_sets=sets,
            t_way=tuple((t, _floats(chances(of).sum(axis=0) / possible)) for t, of, possible in self._combinations),
            difference=_band(again.mutants @ (met - random)),
            distinct=_band(again.distinct @ (met - random)),
            apfd=apfd(met[again.place]) if whole else None,
            area=float(met[again.place].mean()),
            random_area=float(random[again.place].mean()),
            matched=_matched(again.distinct[0] @ self._random, sets.mean[-1]) if smaller else None,
        )


def _band(values: NDArray[np.float64]) -> Band:
    """Of (1 + resamples, k): first the campaign flown."""
    low, high = np.quantile(values[1:], QUANTILES, axis=0)
    return Band(_floats(values[0]), _floats(low), _floats(high))


def _spread(kills: Found) -> Band:
    """Kills at k between random orders."""
    at = at_sizes(kills, random_orders(kills.shape[1], ORDERS, "spread"))
    low, high = np.quantile(at, (0.05, 0.95), axis=0)
    return Band(_floats(at.mean(axis=0)), _floats(low), _floats(high))


def _matched(at_random: NDArray[np.float64], number: float) -> float:
    """Where the curve of random situations reaches a number, between its points on a straight line."""
    steps = np.concatenate([[0.0], at_random])
    return float(np.interp(number, steps, np.arange(len(steps))))


def _floats(values: NDArray[np.float64]) -> Floats:
    return tuple(map(float, values))
