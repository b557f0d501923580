"""Coverage against kills: what suites of k situations cover and kill, by each strategy of choosing them.

The comparison is with random situations at equal k (Chen and others, "Revisiting the relationship between fault
detection, test adequacy criteria, and test set size", ASE 2020): the size of a suite is what a strategy costs.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from importlib.util import find_spec

import numpy as np
from numpy.typing import NDArray

from experiments.coverage_against_kills import orders
from experiments.coverage_against_kills.chance import (
    Chances,
    Found,
    apfd,
    firsts,
    in_orders,
    in_subsets,
    with_replacement,
    without_replacement,
)
from experiments.coverage_against_kills.redrawn import redrawn
from experiments.coverage_against_kills.trial import Trial
from scaloft_fi.analysis.coverage import covering_array

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
        difference: mutants killed more than by random situations at equal k, with a paired 95 % interval; None for
            random order itself.
        distinct: the same of kill sets: the headline, as mutants that are killed in the same situations count once.
        apfd: of the mutants killed in some situation; None for a strategy that does not order them all.
        area: mean of the share of mutants killed, over the k of this strategy.
        random_area: the same of random situations over the same k.
        matched: the least k (with a fraction) at which random situations meet as many kill sets as the whole suite;
            None for a strategy that orders all of them.
        oracle: whether it knows the kills beforehand.
    """

    id: str
    name: str
    about: str
    kills: Band
    kill_sets: Band
    t_way: tuple[tuple[int, Floats], ...]
    difference: Band | None
    distinct: Band | None
    apfd: float | None
    area: float
    random_area: float
    matched: float | None = None
    oracle: bool = False


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

    def curve(self, name: str) -> Curve | None:
        """The strategy with that id."""
        return next((curve for curve in self.curves if curve.id == name), None)


def curves(trial: Trial) -> Curves:
    """Follow every strategy over the trial."""
    compare = _Compare(trial)
    size = len(trial.situations)
    ties = max(1, GREEDY // size)
    random, draws = without_replacement(size), with_replacement(size)
    found = [
        compare.curve("random", "random order", "uniform without replacement: exact", lambda a: random[a.sum(axis=1)]),
        compare.curve(
            "draws", "random draws", "uniform with replacement: exact", lambda a: draws[a.sum(axis=1)], whole=False
        ),
        compare.ordered("lexicographic", "grid's order", "as listed, the last axis fastest", np.arange(size)[None, :]),
        compare.ordered(
            "greedy",
            "greedy t-way",
            f"most new combinations of 1 axis, then of 2, ...: mean of {ties * size} orders",
            orders.greedy_t_way(trial.space, trial.situations, ties),
        ),
    ]
    missing = []
    for strength in ARRAYS:
        if strength >= len(trial.space.axes):
            continue
        name = f"{strength}-way array"
        if find_spec("covertable") is None:
            missing.append((name, "covertable is not installed: pip install 'scaloft-fi[covering]'"))
            continue
        suite = covering_array(trial.space, trial.situations, strength, 0)
        suites = orders.relabelled(trial.space, trial.situations, suite, strength)
        if len(suites) < 2:
            missing.append((name, "no renaming of its axes and values stays among the situations flown"))
            continue
        about = f"covering array of {len(suite)}: mean of {len(suites)} relabellings, in random order"
        found.append(compare.curve(f"{strength}-way", name, about, partial(in_subsets, suites=suites), whole=False))
    oracle = orders.greedy_by_kills(trial.kills)
    found.append(
        compare.ordered(
            "oracle", "oracle", "most new kills first, as if they were known beforehand", oracle, oracle=True
        )
    )
    spread = _spread(trial.kills)
    return Curves(trial, tuple(found), spread, tuple(missing))


class _Compare:
    """Follows strategies over one trial, with the same redrawn campaigns for all."""

    def __init__(self, trial: Trial) -> None:
        self._again = redrawn(trial.parameters, trial.kills, trial.seed_sets)
        self._random = without_replacement(len(trial.situations))[self._again.kill_sets.sum(axis=1)]
        self._combinations = trial.followed

    def ordered(self, id_: str, name: str, about: str, positions: NDArray[np.int64], *, oracle: bool = False) -> Curve:
        """A strategy that orders all situations."""
        return self.curve(id_, name, about, lambda found: in_orders(found, positions), oracle=oracle)

    def curve(
        self,
        id_: str,
        name: str,
        about: str,
        chances: Callable[[Found], Chances],
        *,
        whole: bool = True,
        oracle: bool = False,
    ) -> Curve:
        """A strategy by the chances that it meets things within k situations; whole: it ends with all of them."""
        met, again = chances(self._again.kill_sets), self._again
        length = met.shape[1]
        random = self._random[:, :length]
        partial = not whole and length < self._random.shape[1]
        sets = _band(again.distinct @ met)
        return Curve(
            id=id_,
            name=name,
            about=about,
            kills=_band(again.mutants @ met),
            kill_sets=sets,
            t_way=tuple(
                (strength, _floats(chances(found).sum(axis=0) / possible))
                for strength, found, possible in self._combinations
            ),
            difference=None if id_ == "random" else _band(again.mutants @ (met - random)),
            distinct=None if id_ == "random" else _band(again.distinct @ (met - random)),
            apfd=apfd(met[again.place]) if whole else None,
            area=float(met[again.place].mean()),
            random_area=float(random[again.place].mean()),
            matched=_matched(again.distinct[0] @ self._random, sets.mean[-1]) if partial else None,
            oracle=oracle,
        )


def _band(values: NDArray[np.float64]) -> Band:
    """Of (1 + resamples, k): first the campaign flown."""
    low, high = np.quantile(values[1:], QUANTILES, axis=0)
    return Band(_floats(values[0]), _floats(low), _floats(high))


def _spread(kills: Found) -> Band:
    """Kills at k between random orders."""
    situations = kills.shape[1]
    first = firsts(kills, orders.random(situations, ORDERS, "spread"))
    at = np.stack([(first <= k).sum(axis=1) for k in range(situations)], axis=1)
    low, high = np.quantile(at, (0.05, 0.95), axis=0)
    return Band(_floats(at.mean(axis=0)), _floats(low), _floats(high))


def _matched(at_random: NDArray[np.float64], number: float) -> float:
    """Where the curve of random situations reaches a number, between its points on a straight line."""
    steps = np.concatenate([[0.0], at_random])
    return float(np.interp(number, steps, np.arange(len(steps))))


def _floats(values: NDArray[np.float64]) -> Floats:
    return tuple(map(float, values))
