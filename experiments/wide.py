"""Compare the wide grid with the paper's: which faults each detects, on the half of the mutants that chose nothing.

    python -m experiments.wide [--output FILE]

Flies nothing: the flights of the wide grid, three seeds and twenty of the baseline, ten of which are the pool, stand in
`wide_outcomes.parquet` beside the page.  The paper's side comes from `results/published/reference/outcomes.parquet`:
the same three seeds, and the first ten of its pool.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from statistics import mean

import numpy as np

from experiments import ROOT
from experiments.flights import GRIDS, Row, counted, outcomes, own_s, published, rows_of
from experiments.pages import blocks, registered, table, write
from scaloft_fi.analysis.detection import Pool, Sample, Spending, State, adjusted, firmness, reaches
from scaloft_fi.analysis.kill_matrix import kill_matrix
from scaloft_fi.analysis.score import MutantScore, Redraw, Score, mutant_score, redraw, sample, score
from scaloft_fi.analysis.survivor import backgrounds
from scaloft_fi.judge.outcome import BASELINE, Outcome, Subject
from scaloft_fi.judge.requirement import Kind
from scaloft_fi.judge.status import INVALID, Rulings, Situations, rulings_of
from scaloft_fi.streams import key_words
from scaloft_fi.study import Study
from scaloft_fi.verbs.verdict import short_units, survivors

PARAMETERS = ("goal", "collision", "pose", "waypoint", "battery")
"""The parameters of which the paper's grid shows least."""


def halves(defaults: Mapping[str, str]) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """The choosing and the judging half.

    Args:
        defaults: the default mutant of each credible cell, by the cell's name such as `LATE-human`.

    >>> halves({"NO-a": "NO-a", "MORE-a": "MORE-a@1", "NO-b": "NO-b"})
    (('MORE-a@1', 'NO-b'), ('NO-a',))
    """
    ordered = sorted(defaults.items(), key=lambda entry: (entry[0].split("-")[1], key_words("wide half", entry[1])))
    dealt = [mutant for _, mutant in ordered]
    return tuple(dealt[0::2]), tuple(dealt[1::2])


SEEDS, POOL, REDRAWN = range(3), range(10), range(20)


@dataclass(frozen=True)
class Side:
    """One of the two grids.

    Attributes:
        score: its score, of three seeds and a pool of ten.
        own_s: simulated time flown for each mutant, and for the baseline; a mutant shares its baseline up to its first
            altered sample.
        situations: number of situations.
        flights: the flights that the score counts.
    """

    score: Score
    own_s: Mapping[str, float]
    situations: int
    flights: tuple[Outcome, ...]

    @property
    def by_id(self) -> Mapping[str, MutantScore]:
        """Scores by mutant."""
        return {mutant.subject.id: mutant for mutant in self.score.mutants}

    @property
    def detected(self) -> frozenset[str]:
        """The mutants that the safety requirements detect."""
        return frozenset(id_ for id_, mutant in self.by_id.items() if mutant.detected)

    def flown_s(self, half: Iterable[str]) -> float:
        """Simulated time of the baselines and of these mutants [s]."""
        return self.own_s[BASELINE] + sum(self.own_s.get(mutant, 0.0) for mutant in half)

    def seeds(self, half: Iterable[str]) -> int:
        """Seeds that each of these mutants was flown with in each situation."""
        scores = self.by_id
        return min(result.flown for mutant in half if mutant in scores for result in scores[mutant].results)


def side(study: Study, rows: Sequence[Row], seeds: Collection[int] = SEEDS) -> Side:
    """The score of the default mutants: of each half, those of the seeds with which all of it was flown everywhere."""
    clean, chosen = counted(rows, (), (), POOL), list[Row]()
    situations = {row["situation"] for row in clean}
    for half in halves(study.roster.defaults):
        flown = counted(rows, half, seeds, ())
        number = Counter(row["seed"] for row in flown)
        chosen += [row for row in flown if number[row["seed"]] == len(half) * len(situations)]
    spent_s = {BASELINE: sum(float(row["duration_s"]) for row in clean)}
    for row in chosen:
        spent_s[row["mutant"]] = spent_s.get(row["mutant"], 0.0) + own_s(row)
    flights = tuple(outcomes(study, [*clean, *chosen]))
    return Side(score(flights, study.roster, study.space), spent_s, len(situations), flights)


def whys_of(study: Study, flown: Side) -> dict[str, str]:
    """Why each mutant that is not detected is not, by mutant."""
    matrix = kill_matrix(flown.score, study.roster, study.space)
    known = backgrounds(study.matrix, [mutant.subject.id for mutant in flown.score.mutants])
    listed = survivors(flown.flights, flown.score, matrix, known, short_units(study.requirements), "wide")
    return {survivor.mutant: survivor.why for survivor in listed}


def by_one_seed(study: Study, rows: Sequence[Row]) -> tuple[int, ...]:
    """How many mutants of the judging half each seed alone detects."""
    _, judging = halves(study.roster.defaults)
    return tuple(len(side(study, rows, [seed]).detected & set(judging)) for seed in SEEDS)


def results(
    paper: Side,
    wide: Side,
    defaults: Mapping[str, str],
    alone: Sequence[Sequence[int]],
    redrawn: Sequence[Redraw],
    whys: Mapping[str, str],
) -> str:
    """The section with the results.

    Args:
        paper, wide: the two grids.
        defaults: the default mutant of each credible cell.
        alone: what each seed alone detects of the judging half, in the paper's grid and in the wide grid.
        redrawn: what redraws of the unmutated drone gave there.
        whys: why a mutant that the wide grid does not detect is not detected.
    """
    choosing, judging = halves(defaults)
    parts = {"judging": judging, "choosing (selected)": choosing, "all (half selected)": (*choosing, *judging)}
    found = paper.detected, wide.detected, paper.detected | wide.detected
    first, second = (", ".join(map(str, counts)) for counts in alone)
    chance = ", ".join(f"{one.safety.part} of {one.safety.whole}" for one in redrawn)
    parameters = {
        parameter: {mutant for cell, mutant in defaults.items() if cell.split("-")[1] == parameter}
        for parameter in dict.fromkeys(cell.split("-")[1] for cell in defaults)
    }
    halved = ((n, *(f"{len(set(half) & some)} of {len(half)}" for some in found)) for n, half in parts.items())
    by_parameter = ((n, len(own), *(len(own & some) for some in found)) for n, own in parameters.items())
    of_these = [one for cell, one in defaults.items() if cell.split("-")[1] in PARAMETERS and one not in wide.detected]
    every = (
        (one, "judging" if one in judging else "choosing", *_verdict(paper, one), *_verdict(wide, one))
        for one in defaults.values()
    )
    return blocks(
        "## Flown",
        _cost(paper, wide, choosing, judging),
        table(("half", "paper's grid", "wide grid", "both together"), halved),
        f"One seed alone detects {first} of the judging half in the paper's grid, {second} in the wide grid.",
        f"The unmutated drone in the place of a mutant, three of its first {len(REDRAWN)} seeds beside ten\n"
        f"others: {chance} redraws are called detected, in the paper's grid and in the wide grid.",
        "By parameter, both halves:",
        table(("parameter", "defaults", "paper's grid", "wide grid", "both"), by_parameter),
        f"What stops the others of {', '.join(PARAMETERS)} in the wide grid:",
        table(("mutant", "why"), ((mutant, whys.get(mutant, "not flown")) for mutant in of_these)),
        *_baselines(wide),
        "Every default mutant; kills: situations where most of its flights violate, of those that put it to the test.",
        table(("mutant", "half", "paper's grid", "kills", "wide grid", "kills"), every),
    )


def _cost(paper: Side, wide: Side, choosing: Sequence[str], judging: Sequence[str]) -> Iterator[str]:
    ours_s, theirs_s = wide.flown_s(judging), paper.flown_s(judging)
    times, first, second = ours_s / theirs_s, wide.seeds(judging), wide.seeds(choosing)
    yield f"{wide.situations} situations of the wide grid beside the paper's {paper.situations}.  The baselines and the"
    yield f"judging half took {ours_s:,.0f} simulated s beside {theirs_s:,.0f}: {times:.2f} times the flying.  Seeds in"
    yield f"the wide grid: {first} of the judging half, {second} of the other; what has fewer than {len(SEEDS)}"
    yield "is judged by these alone.  The first seed of all mutants was flown first; nothing was decided by it."


def _baselines(wide: Side) -> Iterator[str | Iterable[str]]:
    safety = [pair for pair in wide.score.pool.pairs.values() if pair.kind is Kind.SAFETY]
    states = {state: sum(pair.state is state for pair in safety) for state in State}
    counted = ", ".join(f"{number} {state.value}" for state, number in states.items() if number)
    yield f"Pairs of situation and safety requirement in the wide grid: {counted}."
    yield "The unmutated drone violates:"
    rows = ((one.situation, one.requirement, f"{one.violated} of {one.flights}") for one in safety if one.violated)
    yield table(("situation", "requirement", "flights"), rows)


def _verdict(side: Side, mutant: str) -> tuple[str, str]:
    scored = side.by_id.get(mutant)
    if scored is None:
        return "not flown", ""
    killed = len({kill.situation for kill in scored.kills})
    return scored.verdict.value, f"{killed}/{sum(result.tested for result in scored.results)}"


def page(_study: Study, _jobs: int, folder: Path) -> str:
    """The page behind its plan, from the published flights of the wide grid."""
    studies, rows = (Study.open(ROOT), Study.open(ROOT, "wide")), (published(), rows_of(folder / GRIDS["wide"].name))
    paper, wide = map(side, studies, rows)
    alone, clean = list(map(by_one_seed, studies, rows)), [counted(own, (), (), REDRAWN) for own in rows]
    redrawn = [redraw(outcomes(of, own), len(SEEDS), of.alpha) for of, own in zip(studies, clean, strict=True)]
    defaults = studies[0].roster.defaults
    told = results(paper, wide, defaults, alone, redrawn, whys_of(studies[1], wide))
    paper_grid, wide_grid = map(grid_of, studies, rows)
    again = registered("wide", "\n## Told again", "\n| half | paper's grid: detected")
    return told + again + section(paper_grid, wide_grid, halves(defaults)[1])


def grid_of(study: Study, rows: Sequence[Row]) -> Grid:
    """Three seeds of each default mutant, twenty of the baseline."""
    return Grid(study, rulings_of(outcomes(study, counted(rows, study.roster.defaults.values(), SEEDS, REDRAWN))))


# told again: all twenty baseline seeds, firm beside detected, and what other pools of ten say.

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

    def pool(self, seeds: Collection[int]) -> Pool:
        """The pool of these baseline seeds."""
        return Pool.of(one for one in self.rulings.baselines if one.seed in seeds)

    def scores(self, seeds: Collection[int], *, firm: bool = False) -> Mapping[str, MutantScore]:
        """The score of each default mutant beside these seeds of the baseline, by id."""
        space, pool, spending = self.study.space, self.pool(seeds), Spending(self.study.alpha)
        own = self.counted.items()
        return {one.id: mutant_score(one, flights, space, pool, spending, firm=firm) for one, flights in own}

    @cached_property
    def counted(self) -> Mapping[Subject, Situations]:
        """The flights of each default mutant."""
        counted = set(self.study.roster.defaults.values())
        return {subject: own for subject, own in self.rulings.mutants.items() if subject.id in counted}

    @cached_property
    def samples(self) -> Mapping[str, Sequence[Sample]]:
        """The flights of each default mutant that count, by id: they are the same beside every pool."""
        found: dict[str, list[Sample]] = {}
        for subject, own in self.counted.items():
            valid = {key: [one for one in own[key] if one.ruling is not INVALID] for key in own}
            found[subject.id] = [
                sample(key, valid[key]) for key in sorted(valid, key=self.study.space.rank) if valid[key]
            ]
        return found

    def detected(self, seeds: Collection[int]) -> frozenset[str]:
        """The mutants that are detected beside these seeds of the baseline."""
        pool = self.pool(seeds)
        return frozenset(id_ for id_ in self.samples if self._detects(id_, pool))

    def firm(self, seeds: Collection[int]) -> Mapping[str, bool]:
        """Of each mutant that is detected beside these seeds of the baseline, whether it is firm."""
        pool, spending = self.pool(seeds), Spending(self.study.alpha)
        detected = {id_: own for id_, own in self.samples.items() if self._detects(id_, pool)}
        return {id_: firmness(id_, own, pool, spending, Kind.SAFETY).firm for id_, own in detected.items()}

    def _detects(self, mutant: str, pool: Pool) -> bool:
        """The verdict of `detect` alone, without what an undecided mutant would need, which no draw asks for."""
        samples, names = self.samples[mutant], pool.requirements(Kind.SAFETY)
        if not any(one.infected and pool.steady(one.situation, Kind.SAFETY) for one in samples):
            return False
        return reaches(min(adjusted(samples, pool, names).values()), self.study.alpha)


def section(paper: Grid, wide: Grid, judging: Collection[str]) -> str:
    """What the rules of the section *Told again* ask for, as text."""
    return blocks(*_headline(paper, wide, judging), *_pools(wide, judging), _splits(wide), _named(wide), _failing(wide))


def _headline(paper: Grid, wide: Grid, judging: Collection[str]) -> Iterator[str | Iterable[str]]:
    scored = [grid.scores(ALL, firm=True) for grid in (paper, wide)]
    every = wide.study.roster.defaults.values()
    halves = {"judging": judging, "choosing (selected)": set(every) - set(judging), "all (half selected)": every}

    def counts(half: Collection[str]) -> Iterator[str]:
        for scores in scored:
            own = [scores[id_] for id_ in half if id_ in scores]
            yield from (f"{sum(getattr(one, name) for one in own)} of {len(half)}" for name in ("detected", "firm"))

    head = ("half", "paper's grid: detected", "firm", "wide grid: detected", "firm")
    yield table(head, ((name, *counts(half)) for name, half in halves.items()))
    hangs = [id_ for id_ in every if scored[1][id_].detected and not scored[1][id_].firm]
    yield f"Not firm in the wide grid: {', '.join(hangs)}."


def _pools(wide: Grid, judging: Collection[str]) -> Iterator[str | Iterable[str]]:
    def told(seeds: Collection[int]) -> str:
        detected = wide.detected(seeds)
        return f"{len(detected)} ({len(detected & set(judging))})"

    draw = np.random.Generator(np.random.PCG64(SEED))
    drawn = [wide.detected(set(draw.permutation(len(ALL))[:10].tolist())) for _ in range(POOLS)]
    counts, theirs = [len(one) for one in drawn], [len(one & set(judging)) for one in drawn]
    as_many = 100 * mean(count >= len(wide.detected(FIRST)) for count in counts)
    yield "Detected in the wide grid (of these in the judging half), by the pool:"
    rows = {
        "seeds 0-9, as published": told(FIRST),
        "seeds 10-19": told(SECOND),
        "all twenty": told(ALL),
        f"{POOLS} random pools of ten: mean": f"{mean(counts):.1f} ({mean(theirs):.1f})",
        "... range": f"{min(counts)} to {max(counts)} ({min(theirs)} to {max(theirs)})",
        "... as many as seeds 0-9 or more": f"{as_many:.0f} %",
    }
    yield table(("pool", "detected"), rows.items())


def _splits(wide: Grid) -> Iterator[str]:
    """Of mutants detected beside ten seeds, how many are detected beside the other ten."""
    draw = np.random.Generator(np.random.PCG64(SEED + 1))
    again = {True: [0, 0], False: [0, 0]}
    for _ in range(SPLITS):
        order = draw.permutation(len(ALL)).tolist()
        other = wide.detected(order[10:])
        for id_, firm in wide.firm(order[:10]).items():
            again[firm][0] += id_ in other
            again[firm][1] += 1
    steadfast, rest = (f"{100 * part / whole:.1f} % of {whole}" for part, whole in (again[True], again[False]))
    yield f"Over {SPLITS} random splits of the twenty seeds into tens, of the mutants that are firm beside one ten"
    yield f"{steadfast} are detected beside the other, of those detected and not firm {rest}."


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


if __name__ == "__main__":
    write(__doc__, "wide", page)
