"""Does situation coverage predict fault detection?  The figures, and the answer in words that follow from them."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

import numpy as np

from experiments.coverage_against_kills import orders
from experiments.coverage_against_kills.chance import firsts
from experiments.coverage_against_kills.curves import ARRAYS, ORDERS, Band, Curve, Curves
from experiments.coverage_against_kills.trial import Trial, sub_cube

FEW_SEEDS = 5
"""Below, the sets of seeds that may come out of a draw are too few for more than a rough interval."""


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
        sub_cubes: per t, the mutants killed exactly where t axes have certain values: for these, kills at k random
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
    """Sentences; the last one is the verdict, with what it rests on."""
    trial = found.trial
    size, sets = len(trial.situations), len(trial.kill_sets)
    flown = (
        f"{_count(len(trial.mutants), 'default mutant')} of this matrix, flown in the same {_count(size, 'situation')}"
    )
    killed = f"{trial.killed} of them are killed, in {_count(sets, 'different set')} of situations (kill sets)"
    said = [f"{flown}, have {_count(len(trial.seeds), 'seed')} in common; {killed}."]
    if trial.unkilled:
        said.append(f"Detected, but killed in no situation and so in no curve: {', '.join(trial.unkilled)}.")
    if not trial.killed or size < 2:
        return (
            *said,
            "Nothing follows about coverage: that needs kills, and so a baseline pool, and situations to choose from.",
        )
    random = found.curve("random")
    assert random is not None
    arrays = [(strength, curve) for strength in ARRAYS if (curve := found.curve(f"{strength}-way"))]
    said.append(
        "Mutants killed in the same situations share a kill set, which counts once; in parentheses, each mutant."
    )
    said += [_array(strength, curve, random, sets) for strength, curve in arrays]
    said += [_whole(curve) for name in ("greedy", "lexicographic") if (curve := found.curve(name))]
    said += [_correlation(one) for one in correlations if one.strength == 2]
    if cubes:
        blocks = sum(count for t, count in cubes if t is not None)
        said.append(
            f"The kills of {blocks} of {trial.killed} mutants are a block of the grid, fixed by t axes: for those the "
            "chance of a kill by k random situations is the expected t-way coverage, by identity."
        )
    return (*said, f"{_verdict(arrays, sets)}  {_carried(trial)}")


def _array(strength: int, curve: Curve, random: Curve, sets: int) -> str:
    k = len(curve.kill_sets.mean)
    covered = dict(curve.t_way).get(strength, (0.0,))[-1]
    by_chance = dict(random.t_way).get(strength, (0.0,) * k)[k - 1]
    worth = f", as many as {curve.matched:.1f} random ones" if curve.matched is not None else ""
    return (
        f"A {strength}-way covering array of {k} situations has {100 * covered:.0f} % of the {strength}-way "
        f"combinations, {k} random situations {100 * by_chance:.0f} %; it meets {curve.kill_sets.mean[-1]:.1f} of "
        f"{_count(sets, 'kill set')} against {random.kill_sets.mean[k - 1]:.1f}{worth}: {_both(curve, k)}."
    )


def _whole(curve: Curve) -> str:
    at = [k for k in (4, 8, 16) if k < len(curve.kill_sets.mean)]
    if not at:
        return f"The {curve.name} has too few situations."
    return f"Kill sets more than in random order, {curve.name}: {', '.join(f'{_both(curve, k)} at {k}' for k in at)}."


def _both(curve: Curve, k: int) -> str:
    assert curve.distinct is not None
    assert curve.difference is not None
    return f"{interval(curve.distinct, k)} (mutants {interval(curve.difference, k)})"


def _correlation(one: Correlation) -> str:
    if one.median is None or one.pooled is None:
        return f"Kendall's tau of {one.strength}-way coverage and kills has no value here."
    inside = [tau for tau in one.within if tau is not None]
    return (
        f"Kendall's tau of {one.strength}-way coverage and mutants killed is {one.pooled:.2f} over random suites of "
        f"all sizes together, and {min(inside):.2f} to {max(inside):.2f} (median {one.median:.2f}) among suites of one "
        "size: what lies between is the size of the suites."
    )


def _verdict(arrays: list[tuple[int, Curve]], sets: int) -> str:
    """By whether the intervals of the arrays' differences to random, as they are printed, contain 0."""
    said = "Does coverage predict kills beyond the number of situations?  "
    told = [(t, curve.distinct, len(curve.distinct.mean)) for t, curve in arrays if curve.distinct]
    if not told:
        return said + "Not judged: there is no covering array to compare."
    more = sum(round(band.low[-1], 1) > 0 for _, band, _ in told)
    fewer = sum(round(band.high[-1], 1) < 0 for _, band, _ in told)
    some = more or fewer
    meet = f"{some} of {_count(len(told), 'covering array')} meet{'s' * (some == 1)}"
    beside = "kill sets than as many random situations"
    if more and fewer:
        answer = f"Not in one direction: {meet} more {beside}, {fewer} fewer"
    elif some:
        answer = f"Here yes: {meet} more {beside}" if more else f"No: {meet} fewer {beside}"
    else:
        answer = f"Not shown here: {meet} more {beside}, or fewer"
    listed = ", ".join(f"{t}-way with {k} {interval(band, k)}" for t, band, k in told)
    return f"{said}{answer} ({listed}; {_count(sets, 'kill set')} in all)."


def _carried(trial: Trial) -> str:
    """What was sampled, and so what the figures carry."""
    sampled = "the mutants of this matrix within their parameter (or its kill sets)"
    situations = len(trial.situations)
    if trial.seed_sets:
        said = (
            f"The 95 % intervals resample {len(trial.seeds)} seeds and {sampled}: the figures carry to other seeds"
            f"{', roughly as there are so few,' if len(trial.seeds) < FEW_SEEDS else ''} and to mutants like these."
        )
    else:
        said = (
            f"The 95 % intervals resample {sampled}, but no seeds, as the mutants have "
            f"{'only one' if trial.seeds else 'none'} in common: the figures carry to mutants like these, and nothing "
            f"follows beyond {'this seed' if trial.seeds and not trial.more_seeds else 'the seeds flown'}."
        )
    census = (
        f"the {situations} situations are the whole grid, a census and no sample"
        if situations == len(trial.space.points)
        else f"the {situations} situations are those that were flown, no sample of others"
    )
    return f"{said}  They do not carry to another grid or another drone: this is one of each, and {census}."


def _count(number: int, noun: str) -> str:
    return f"{number} {noun}{'s' * (number != 1)}"


def interval(band: Band, k: int) -> str:
    """A difference at k situations with its interval."""
    return f"{band.mean[k - 1]:+z.1f} [{band.low[k - 1]:+z.1f}, {band.high[k - 1]:+z.1f}]"
