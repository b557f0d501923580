"""The wide grid told again: all twenty baseline seeds, firm beside detected, and what other pools of ten say."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from statistics import mean

import numpy as np

from scaloft_fi.analysis.detection import Spending
from scaloft_fi.analysis.pool import Pool, State
from scaloft_fi.analysis.score import MutantScore, mutant_score
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.judge.requirement import Kind
from scaloft_fi.judge.status import Rulings, rulings_of
from scaloft_fi.study import Study

ALL, FIRST, SECOND = range(20), range(10), range(10, 20)
POOLS, SPLITS, SEED = 300, 200, 20_252


@dataclass(frozen=True)
class Grid:
    """The flights of a grid: three seeds of each default mutant, twenty of the baseline.

    Attributes:
        study: with the grid.
        rulings: of the flights.
    """

    study: Study
    rulings: Rulings

    @classmethod
    def of(cls, study: Study, outcomes: Sequence[Outcome]) -> Grid:
        """The grid of these outcomes."""
        return cls(study, rulings_of(outcomes))

    def pool(self, seeds: Collection[int]) -> Pool:
        """The pool of these baseline seeds."""
        return Pool.of(one for one in self.rulings.baselines if one.seed in seeds)

    def scores(self, seeds: Collection[int], *, firm: bool = False) -> Mapping[str, MutantScore]:
        """The score of each default mutant beside these seeds of the baseline, by id."""
        pool, counted = self.pool(seeds), set(self.study.roster.defaults.values())
        spending = Spending(self.study.alpha)
        return {
            subject.id: mutant_score(subject, flights, self.study.space, pool, spending, firm=firm)
            for subject, flights in self.rulings.mutants.items()
            if subject.id in counted
        }

    def detected(self, seeds: Collection[int]) -> frozenset[str]:
        """The mutants that are detected beside these seeds of the baseline."""
        return frozenset(id_ for id_, score in self.scores(seeds).items() if score.detected)


def section(paper: Grid, wide: Grid, judging: Collection[str]) -> str:
    """What the rules of `AGAIN` ask for, as text."""
    return "\n".join(
        [
            "",
            *_headline(paper, wide, judging),
            "",
            *_pools(wide, judging),
            "",
            *_splits(wide),
            "",
            *_named(wide),
            "",
            *_failing(wide),
            "",
        ]
    )


def _headline(paper: Grid, wide: Grid, judging: Collection[str]) -> Iterator[str]:
    yield "| half | paper's grid: detected | firm | wide grid: detected | firm |"
    yield "|---|---|---|---|---|"
    scored = [grid.scores(ALL, firm=True) for grid in (paper, wide)]
    every = wide.study.roster.defaults.values()
    halves = {"judging": judging, "choosing (selected)": set(every) - set(judging), "all (half selected)": every}
    for name, half in halves.items():
        counts = []
        for scores in scored:
            own = [scores[id_] for id_ in half if id_ in scores]
            counts += [
                f"{sum(one.detected for one in own)} of {len(half)}",
                f"{sum(one.firm for one in own)} of {len(half)}",
            ]
        yield f"| {name} | {' | '.join(counts)} |"
    hangs = [id_ for id_ in every if scored[1][id_].detected and not scored[1][id_].firm]
    yield ""
    yield f"Not firm in the wide grid: {', '.join(hangs)}."


def _pools(wide: Grid, judging: Collection[str]) -> Iterator[str]:
    def told(detected: Collection[str]) -> str:
        return f"{len(detected)} ({len(set(detected) & set(judging))})"

    yield "Detected in the wide grid (of these in the judging half), by the pool:"
    yield ""
    yield "| pool | detected |"
    yield "|---|---|"
    for name, seeds in (("seeds 0-9, as published", FIRST), ("seeds 10-19", SECOND), ("all twenty", ALL)):
        yield f"| {name} | {told(wide.detected(seeds))} |"
    draw = np.random.Generator(np.random.PCG64(SEED))
    drawn = [wide.detected(set(draw.permutation(len(ALL))[:10].tolist())) for _ in range(POOLS)]
    counts, theirs = [len(one) for one in drawn], [len(one & set(judging)) for one in drawn]
    most = len(wide.detected(FIRST))
    yield f"| {POOLS} random pools of ten: mean | {mean(counts):.1f} ({mean(theirs):.1f}) |"
    yield f"| ... range | {min(counts)} to {max(counts)} ({min(theirs)} to {max(theirs)}) |"
    yield f"| ... as many as seeds 0-9 or more | {100 * sum(count >= most for count in counts) / POOLS:.0f} % |"


def _splits(wide: Grid) -> Iterator[str]:
    """Of mutants detected beside ten seeds, how many are detected beside the other ten."""
    draw = np.random.Generator(np.random.PCG64(SEED + 1))
    again = {True: [0, 0], False: [0, 0]}
    for _ in range(SPLITS):
        order = draw.permutation(len(ALL)).tolist()
        other = wide.detected(order[10:])
        for id_, score in wide.scores(order[:10], firm=True).items():
            if score.detected:
                again[score.firm][0] += id_ in other
                again[score.firm][1] += 1
    firm, rest = (f"{100 * part / whole:.1f} % of {whole}" for part, whole in (again[True], again[False]))
    yield f"Over {SPLITS} random splits of the twenty seeds into tens, of the mutants that are firm beside one ten"
    yield f"{firm} are detected beside the other, of those detected and not firm {rest}."


def _named(wide: Grid) -> Iterator[str]:
    first, every = wide.detected(FIRST), wide.detected(ALL)
    yield f"Detected beside seeds 0-9 and not beside all twenty: {', '.join(sorted(first - every)) or 'none'}."
    yield f"Detected beside all twenty and not beside seeds 0-9: {', '.join(sorted(every - first)) or 'none'}."
    ten, pool = wide.pool(FIRST), wide.pool(ALL)
    lucky = [
        f"{situation} by {name}"
        for (situation, name), state in ten.states.items()
        if state is State.STEADY is not pool.states[situation, name] and ten.pairs[situation, name].kind is Kind.SAFETY
    ]
    yield f"Steady in seeds 0-9 alone: {', '.join(lucky) or 'none'}."


def _failing(wide: Grid) -> Iterator[str]:
    pairs = [pair for pair in wide.pool(ALL).pairs.values() if pair.kind is Kind.OPERABILITY]
    failing = {pair.situation for pair in pairs if 10 * pair.violated > pair.flights}
    kept = [one for one in wide.scores(ALL).values() if one.detected and any(key not in failing for key in one.killing)]
    yield f"The unmutated drone violates OP1 in over a tenth of its flights in {len(failing)} of {len(pairs)}"
    yield f"situations: {', '.join(sorted(failing)) or 'none'}."
    yield f"Killed in some other situation: {len(kept)} of the detected."
