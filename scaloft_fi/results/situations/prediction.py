"""Does situation coverage predict fault detection?  The figures, and the answer in words that follow from them."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

import numpy as np

from scaloft_fi.results.situations import orders
from scaloft_fi.results.situations.chance import firsts
from scaloft_fi.results.situations.curves import ARRAYS, ORDERS, Band, Curve, Curves
from scaloft_fi.results.situations.trial import Trial, sub_cube


@dataclass(frozen=True)
class Correlation:
    """Kendall's tau-b of t-way coverage against mutants killed, over random suites.

    Attributes:
        strength: t.
        within: among suites of k = 1, 2, ... situations; None where either number is the same for all of them.
        pooled: over suites of all sizes together: it is high because both grow with the size.
    """

    strength: int
    within: tuple[float | None, ...]
    pooled: float | None

    @property
    def median(self) -> float | None:
        """Of the tau within one size."""
        found = [tau for tau in self.within if tau is not None]
        return float(np.median(found)) if found else None


@dataclass(frozen=True)
class Prediction:
    """What one campaign says about coverage as a predictor.

    Attributes:
        correlations: one per strength.
        sub_cubes: per t, the mutants that die exactly where t axes have certain values: for these, kills at k random
            situations are t-way coverage; None: mutants whose kills are no such block.
        answer: sentences.
    """

    correlations: tuple[Correlation, ...]
    sub_cubes: tuple[tuple[int | None, int], ...]
    answer: tuple[str, ...]


def predict(found: Curves) -> Prediction:
    """Judge a campaign's curves."""
    correlations = correlate(found.trial)
    cubes = _sub_cubes(found.trial)
    return Prediction(correlations, cubes, _answer(found, correlations, cubes))


def correlate(trial: Trial) -> tuple[Correlation, ...]:
    """Kendall's tau-b over the first k situations of random orders, within each k and pooled.

    Within a size only, because size is what both follow (Inozemtseva and Holmes, ICSE 2014); the pooled value is there
    to show how much that is (Simpson's paradox).
    """
    situations = len(trial.situations)
    positions = orders.random(situations, ORDERS, "correlation")
    killed = _at_sizes(firsts(trial.kills, positions), situations)
    found = []
    for strength, combinations, _ in trial.followed:
        covered = _at_sizes(firsts(combinations, positions), situations)
        within = tuple(_tau(covered[:, k], killed[:, k]) for k in range(situations))
        found.append(Correlation(strength, within, _tau(covered.ravel(), killed.ravel())))
    return tuple(found)


def _at_sizes(first: np.ndarray, situations: int) -> np.ndarray:
    """(orders, k): how many things the first k + 1 situations of each order meet."""
    return np.stack([(first <= k).sum(axis=1) for k in range(situations)], axis=1)


def _tau(one: np.ndarray, other: np.ndarray) -> float | None:
    from scipy.stats import kendalltau

    if len(set(one.tolist())) < 2 or len(set(other.tolist())) < 2:
        return None
    return float(kendalltau(one, other).statistic)


def _sub_cubes(trial: Trial) -> tuple[tuple[int | None, int], ...]:
    """Over the killed mutants; none at all where the trial lacks a part of the grid, as a block may end outside."""
    if len(trial.situations) < len(trial.space.points):
        return ()
    keys = np.array(trial.situations)
    counts = Counter(sub_cube(trial.space, keys[row].tolist()) for row in trial.kills if row.any())
    return tuple((t, counts[t]) for t in (*range(len(trial.space.axes) + 1), None) if counts[t])


def _answer(
    found: Curves, correlations: tuple[Correlation, ...], cubes: tuple[tuple[int | None, int], ...]
) -> tuple[str, ...]:
    trial = found.trial
    size, mutants, killed = len(trial.situations), len(trial.mutants), int(trial.kills.any(axis=1).sum())
    said = [f"{mutants} default mutants were flown in the same {size} situations, which kill {killed} of them."]
    if not killed or size < 2:
        return (*said, "Nothing follows about coverage: that needs kills, and situations to choose from.")
    random = found.curve("random")
    assert random is not None
    arrays = [(strength, curve) for strength in ARRAYS if (curve := found.curve(f"{strength}-way"))]
    said += [_array(strength, curve, random) for strength, curve in arrays]
    said += [_distinct(len(trial.kill_sets), arrays)] if arrays else []
    said += [_whole(curve) for name in ("greedy", "lexicographic") if (curve := found.curve(name))]
    said += [_correlation(one) for one in correlations if one.strength == 2]
    if cubes:
        blocks = sum(count for t, count in cubes if t is not None)
        said.append(
            f"The kills of {blocks} of {killed} mutants are a block of the grid, fixed by t axes: for those the chance "
            "of a kill by k random situations is the expected t-way coverage, by identity."
        )
    return (*said, _verdict([curve for _, curve in arrays]))


def _array(strength: int, curve: Curve, random: Curve) -> str:
    assert curve.difference is not None
    k = len(curve.kills.mean)
    covered = dict(curve.t_way).get(strength, (0.0,))[-1]
    by_chance = dict(random.t_way).get(strength, (0.0,) * k)[k - 1]
    worth = f", as many as {curve.matched:.1f} random ones" if curve.matched is not None else ""
    return (
        f"A {strength}-way covering array of {k} situations has {100 * covered:.0f} % of the {strength}-way "
        f"combinations, {k} random situations {100 * by_chance:.0f} %; it kills {curve.kills.mean[-1]:.1f} mutants "
        f"against {random.kills.mean[k - 1]:.1f}{worth}: {_interval(curve.difference, k - 1)}."
    )


def _distinct(sets: int, arrays: list[tuple[int, Curve]]) -> str:
    parts = [f"{t}-way {_interval(one.distinct, len(one.kills.mean) - 1)}" for t, one in arrays if one.distinct]
    return (
        f"Mutants that die in the same situations say the same: with each of the {sets} different kill sets counted "
        f"once, the arrays' differences are {', '.join(parts)}."
    )


def _whole(curve: Curve) -> str:
    assert curve.difference is not None
    at = [k for k in (4, 8, 16) if k < len(curve.kills.mean)]
    parts = ", ".join(f"{_interval(curve.difference, k - 1)} at {k}" for k in at)
    return (
        f"Against random order, the {curve.name} kills {parts}."
        if parts
        else f"The {curve.name} has too few situations."
    )


def _correlation(one: Correlation) -> str:
    if one.median is None or one.pooled is None:
        return f"Kendall's tau of {one.strength}-way coverage and kills has no value here."
    inside = [tau for tau in one.within if tau is not None]
    return (
        f"Kendall's tau of {one.strength}-way coverage and kills is {one.pooled:.2f} over random suites of all sizes "
        f"together, and {min(inside):.2f} to {max(inside):.2f} (median {one.median:.2f}) among suites of one size: "
        "what lies between is the size of the suites."
    )


def _verdict(arrays: list[Curve]) -> str:
    """One sentence, by whether the intervals of the arrays' differences to random contain 0."""
    said = "Does coverage predict kills beyond the number of situations?  "
    ends = [(curve.difference.low[-1], curve.difference.high[-1]) for curve in arrays if curve.difference]
    if not ends:
        return said + "Not judged: there is no covering array to compare."
    more, fewer = sum(low > 0 for low, _ in ends), sum(high < 0 for _, high in ends)
    if not more and not fewer:
        return said + "Not here: every covering array kills what as many random situations kill, within the interval."
    if more and not fewer:
        gain = max(curve.matched - len(curve.kills.mean) for curve in arrays if curve.matched is not None)
        return (
            f"{said}Here yes, for {more} of {len(ends)} covering arrays: at best an array is worth "
            f"{gain:.1f} random situations more than it has."
        )
    if fewer and not more:
        return said + f"No: {fewer} of {len(ends)} covering arrays kill fewer than as many random situations."
    return said + f"Not in one direction: of {len(ends)} covering arrays {more} kill more than random, {fewer} fewer."


def _interval(band: Band, k: int) -> str:
    return f"{band.mean[k]:+z.1f} [{band.low[k]:+z.1f}, {band.high[k]:+z.1f}]"
