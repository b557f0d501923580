"""Is HAZOP worth its name?  As many random faults as default mutants, under the same test.

    python -m experiments.random_faults [--jobs N] [--output FILE]

The faults are those of `random_draw.py`, kept in `results/published/random_faults.jsonl`.  Finished flights are kept
beside the page, in `random_faults_flights.jsonl.gz`, at the latest after ten seconds; the same command flies only the
flights that are missing there.  Delete the file after a change of the study or of the code.
"""

from __future__ import annotations

import experiments.published_kernels  # noqa: F401 - it must be imported before numpy

# isort: split

import json
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from functools import cached_property
from operator import attrgetter
from pathlib import Path

import numpy as np
from scipy.stats import fisher_exact

from experiments import PUBLISHED
from experiments.flights import fly_arms, outcomes, published
from experiments.pages import Row, blocks, table, write
from scaloft_fi.analysis.detection import ALPHA, Pool, Spending, State
from scaloft_fi.analysis.score import MutantScore, mutant_score
from scaloft_fi.judge.outcome import BASELINE, Outcome
from scaloft_fi.judge.requirement import Kind
from scaloft_fi.judge.space import Space
from scaloft_fi.judge.status import Ruled, Rulings, rulings_of
from scaloft_fi.mutants.catalogue import realise
from scaloft_fi.mutants.mutant import Mutant
from scaloft_fi.mutants.operators import OPERATORS
from scaloft_fi.streams import generator
from scaloft_fi.study import Study

FAULTS = 114
"""As many random faults as there are default mutants of credible cells."""
SEEDS, POOL = 3, 10
"""Seeds of a fault, and of the unmutated drone, in each situation."""
SITUATIONS = 32
FLIGHTS = SITUATIONS * (SEEDS * FAULTS + POOL)
LEVEL = 0.05
"""Two-sided p at which the arms differ."""
REDRAWS = 200
"""How often the seeds are drawn again."""
PERMUTATIONS = 10_000


def names_of(faults: Sequence[str], situations: Sequence[str], draws: int | None = None) -> Iterator[str]:
    """Yield the names of the flights: of the first `draws` draws of seed and situation, or of all."""
    pairs = [(seed, key) for seed in range(POOL) for key in situations]
    for seed, key in pairs[:draws]:
        for subject in (BASELINE, *(faults if seed < SEEDS else ())):
            yield f"{subject}/{key}/{seed}"


Kills = frozenset[tuple[str, str]]
"""Situations and requirements that kill a fault."""


@dataclass(frozen=True)
class Arm:
    """The flights of an arm.

    Attributes:
        name: of the arm.
        outcomes: of the baselines that form the pool, and of the faults.
        space: the grid.
    """

    name: str
    outcomes: Sequence[Outcome]
    space: Space

    @classmethod
    def of(cls, name: str, outcomes: Iterable[Outcome], faults: Iterable[str], space: Space) -> Arm:
        """The arm of these faults, with the seeds that the experiment counts."""
        seeds = {**dict.fromkeys(faults, SEEDS), BASELINE: POOL}
        return cls(name, [one for one in outcomes if one.seed < seeds.get(one.mutant, 0)], space)

    @cached_property
    def rulings(self) -> Rulings:
        """The rulings of its flights."""
        return rulings_of(self.outcomes)

    @cached_property
    def scores(self) -> tuple[MutantScore, ...]:
        """The score of each fault."""
        return self.scored(range(SEEDS), range(POOL))

    def scored(self, seeds: Sequence[int], pool: Sequence[int]) -> tuple[MutantScore, ...]:
        """The scores from these seeds of the faults and of the pool, in which a seed may come more than once."""
        clean: dict[int, list[Outcome]] = {}
        for baseline in self.rulings.baselines:
            clean.setdefault(baseline.seed, []).append(baseline)
        pooled = Pool.of(baseline for seed in pool for baseline in clean.get(seed, ()))

        def drawn(flights: Sequence[Ruled]) -> list[Ruled]:
            return [one for seed in seeds for one in flights if one.seed == seed]

        found = []
        for subject, situations in self.rulings.mutants.items():
            own = {key: drawn(flights) for key, flights in situations.items()}
            found.append(mutant_score(subject, own, self.space, pooled, Spending(ALPHA), firm=False))
        return tuple(found)

    @cached_property
    def clean(self) -> Mapping[tuple[str, int], str]:
        """The digests of the valid baselines."""
        return {(one.situation, one.seed): one.digest for one in self.rulings.baselines if not one.invalid}

    @cached_property
    def states(self) -> Mapping[tuple[str, str], State]:
        """The state of each pair of situation and safety requirement in the pool."""
        pool = Pool.of(self.rulings.baselines)
        return {place: pair.state for place, pair in pool.pairs.items() if pair.kind is Kind.SAFETY}

    @property
    def behaviours(self) -> int:
        """Different vectors of digests that are not the baseline's."""
        return len({self.rulings.behaviours[one.subject.id] for one in self.scores if not one.without_effect})


def useful(score: MutantScore) -> bool:
    """Whether a fault is detected and not trivial."""
    return score.detected and not score.trivial


def kills_of(score: MutantScore) -> Kills:
    """The pairs that kill a fault."""
    return frozenset((kill.situation, kill.requirement) for kill in score.kills)


def kill_sets(scores: Iterable[MutantScore]) -> frozenset[Kills]:
    """The different sets of kills, without the empty one."""
    return frozenset(filter(None, map(kills_of, scores)))


class Answer(StrEnum):
    """What rule 1 says of HAZOP."""

    BETTER = "better"
    WORSE = "worse"
    NO_DIFFERENCE = "no difference is shown"


@dataclass(frozen=True)
class Counts:
    """Numbers of faults of an arm.

    Attributes:
        faults: scored.
        detected, trivial, useful: as the plan defines them.
        kill_sets: different sets of kills.
    """

    faults: int
    detected: int
    trivial: int
    useful: int
    kill_sets: int

    @classmethod
    def of(cls, scores: Sequence[MutantScore]) -> Counts:
        """Counted of scores."""
        detected, plain, good = (sum(map(test, scores)) for test in (lambda s: s.detected, lambda s: s.trivial, useful))
        return cls(len(scores), detected, plain, good, len(kill_sets(scores)))


MEASURES = {"detected": "detected", "trivial": "trivial", "useful": "useful", "kill_sets": "different sets of kills"}
"""The words of the page by attribute of `Counts`."""


def fisher(one: int, of_one: int, other: int, of_other: int) -> float:
    """Two-sided p of Fisher's exact test."""
    return float(fisher_exact([[one, of_one - one], [other, of_other - other]]).pvalue)


def answer(hazop: Counts, random: Counts) -> tuple[Answer, float]:
    """What rule 1 says, and its p."""
    p = fisher(hazop.useful, hazop.faults, random.useful, random.faults)
    if p > LEVEL:
        return Answer.NO_DIFFERENCE, p
    better = hazop.useful * random.faults > random.useful * hazop.faults
    return (Answer.BETTER if better else Answer.WORSE), p


def permuted(one: Sequence[Kills], other: Sequence[Kills], permutations: int = PERMUTATIONS) -> float:
    """Two-sided p that labels exchanged between the arms leave as great a difference of different sets of kills.

    The empty set counts as none.

    >>> permuted([frozenset()] * 3, [frozenset()] * 3, permutations=9)
    1.0
    """
    numbers = {kills: number for number, kills in enumerate(sorted({*one, *other} - {frozenset()}, key=sorted))}
    own = np.array([numbers.get(kills, -1) for kills in (*one, *other)])
    seen = abs(_difference(own, len(one)))
    rng = generator("random faults", "permutation")
    least = sum(abs(_difference(rng.permutation(own), len(one))) >= seen for _ in range(permutations))
    return float((1 + least) / (1 + permutations))


def _difference(numbers: np.ndarray[tuple[int], np.dtype[np.int64]], first: int) -> int:
    one, other = (set(part.tolist()) - {-1} for part in (numbers[:first], numbers[first:]))
    return len(one) - len(other)


def redrawn(hazop: Arm, random: Arm, redraws: int = REDRAWS) -> Mapping[str, tuple[list[int], list[int]]]:
    """By measure the numbers of both arms, seeds drawn again with replacement, the same ones in both arms."""
    rng = generator("random faults", "seeds")
    found: dict[str, tuple[list[int], list[int]]] = {measure: ([], []) for measure in MEASURES}
    for _ in range(redraws):
        seeds, pool = (sorted(rng.integers(most, size=most).tolist()) for most in (SEEDS, POOL))
        for place, arm in enumerate((hazop, random)):
            counts = Counts.of(arm.scored(seeds, pool))
            for measure in MEASURES:
                found[measure][place].append(getattr(counts, measure))
    return found


UNFINISHED = "Flights are missing, or baselines of the arms differ, so the rule is not decided."


def flown(hazop: Arm, random: Arm, faults: Mapping[str, Mutant], redraws: int = REDRAWS) -> str:
    """The section with the results.

    Args:
        hazop, random: the arms.
        faults: the mutants of both arms, by id, in the order of the page.
        redraws: how often the seeds are drawn again.
    """
    own, alike = _alike(hazop, random)
    complete = len(random.outcomes) == FLIGHTS and len(hazop.scores) == FAULTS and own == SITUATIONS * POOL
    comparable = random.states == hazop.states
    arms = hazop, random
    heads = "id", "operator", "arguments", "stage", "verdict", "killed", "first [s]", "trivial"
    return blocks(
        "## Flown",
        _told(random, alike, own, comparable=comparable),
        _decided(hazop, random, redraws) if complete and comparable else UNFINISHED,
        "### Arms",
        table(("", hazop.name, random.name), _counted(arms)),
        _same(hazop, random, faults),
        "### By seam",
        "Faults / detected / useful.",
        table(("seam", hazop.name, random.name), _by_seam(arms, faults)),
        "### Random faults",
        "Killed: situations with a kill, of those that test the fault; first: the earliest violation of a kill.",
        table(heads, _listed(random, faults)),
    )


def _told(random: Arm, alike: int, own: int, *, comparable: bool) -> str:
    invalid = sum(bool(outcome.invalid) for outcome in random.outcomes)
    return (
        f"{len(random.outcomes):,} of {FLIGHTS:,} flights of random faults and baselines, {invalid} of them "
        f"invalid.  {alike} of {own} baselines have the digest of the published ones; the pairs of situation and "
        f"safety requirement {'all have the same' if comparable else 'do not all have the same'} state in both pools."
    )


def _alike(hazop: Arm, random: Arm) -> tuple[int, int]:
    """Number of valid baselines of the random arm, and of those whose digest is that of the other arm."""
    return len(random.clean), sum(hazop.clean.get(draw) == digest for draw, digest in random.clean.items())


def _decided(hazop: Arm, random: Arm, redraws: int) -> Iterator[str]:
    first, second = Counts.of(hazop.scores), Counts.of(random.scores)
    told, p = answer(first, second)
    yield (
        f"**Rule 1: {told.value}.**  Useful are {first.useful} of {first.faults} default mutants and {second.useful} "
        f"of {second.faults} random faults; p = {p:.2g}."
    )
    yield ""
    again = redrawn(hazop, random, redraws)
    ps = {
        "detected": fisher(first.detected, first.faults, second.detected, second.faults),
        "trivial": fisher(first.trivial, first.detected, second.trivial, second.detected),
        "useful": p,
        "kill_sets": permuted([kills_of(s) for s in hazop.scores], [kills_of(s) for s in random.scores]),
    }
    rows = []
    for name in MEASURES:
        cells = (f"{getattr(n, name)} ({_spread(s)})" for n, s in zip((first, second), again[name], strict=True))
        rows.append((MEASURES[name], *cells, f"{ps[name]:.2g}"))
    yield "In brackets: the middle nine tenths with the seeds drawn again.  p of *trivial* is of the detected."
    yield ""
    yield from table(("faults", hazop.name, random.name, "p"), rows)


def _spread(numbers: Sequence[int]) -> str:
    least, most = np.quantile(numbers, (0.05, 0.95), method="nearest")
    return f"{least:g} to {most:g}"


COUNTED: Mapping[str, Callable[[MutantScore], bool]] = {
    "that change a sample": attrgetter("infected"),
    "that change a flight": lambda score: not score.without_effect,
    "put to the test": attrgetter("tested"),
    "detected": attrgetter("detected"),
    "of these trivial": attrgetter("trivial"),
    "- killed nearly wherever tested": attrgetter("killed_broadly"),
    "- killed right after take-off": attrgetter("killed_early"),
    "useful": useful,
}


def _counted(arms: Sequence[Arm]) -> Iterator[Row]:
    yield ("faults", *(len(arm.scores) for arm in arms))
    yield from ((name, *(sum(map(holds, arm.scores)) for arm in arms)) for name, holds in COUNTED.items())
    yield ("different sets of kills", *(len(kill_sets(arm.scores)) for arm in arms))
    yield ("different vectors of digests", *(arm.behaviours for arm in arms))
    yield ("detected by operability", *(sum(s.operability.detected for s in arm.scores) for arm in arms))
    stopped = ({outcome.mutant for outcome in arm.outcomes if outcome.stack_error} for arm in arms)
    yield ("that make the stack raise an error", *map(len, stopped))


def _same(hazop: Arm, random: Arm, faults: Mapping[str, Mutant]) -> str:
    one, other = kill_sets(hazop.scores), kill_sets(random.scores)
    patched = {_patch(faults[score.subject.id]) for score in hazop.scores}
    again = sum(_patch(faults[score.subject.id]) in patched for score in random.scores)
    return (
        f"Sets of kills in both arms: {len(one & other)}; {len(one - other)} are of HAZOP alone, {len(other - one)} of "
        f"random faults alone.  {again} random faults are default mutants too."
    )


def _patch(mutant: Mutant) -> tuple[object, ...]:
    """What is patched in, with the operator's own value for each argument that the mutant leaves out."""
    own = {name: argument.default for name, argument in OPERATORS[mutant.operator].arguments.items()}
    return mutant.seam, mutant.operator, mutant.event, *sorted({**own, **mutant.arguments}.items())


def _by_seam(arms: Sequence[Arm], faults: Mapping[str, Mutant]) -> Iterator[Row]:
    seams = dict.fromkeys(faults[score.subject.id].seam for arm in arms for score in arm.scores)
    for seam in seams:
        own = [[s for s in arm.scores if faults[s.subject.id].seam == seam] for arm in arms]
        cells = (f"{len(part)} / {sum(s.detected for s in part)} / {sum(map(useful, part))}" for part in own)
        yield seam, *cells


def _listed(random: Arm, faults: Mapping[str, Mutant]) -> Iterator[Row]:
    scores = {score.subject.id: score for score in random.scores}
    return (_row(scores[id_], fault) for id_, fault in faults.items() if id_ in scores)


def _row(score: MutantScore, mutant: Mutant) -> Row:
    told = ", ".join(f"{name}={value}" for name, value in mutant.arguments.items() if value != "")
    first = f"{score.first.t_s:.1f}" if score.kills and score.first else ""
    reasons = {"everywhere": score.killed_broadly, "early": score.killed_early}
    trivial = ", ".join(name for name, holds in reasons.items() if holds)
    stage, killed = score.status.value.replace("_", " "), f"{score.kill_rate.part}/{score.kill_rate.whole}"
    return mutant.id, mutant.operator, told, stage, score.verdict.words, killed, first, trivial


FILE = PUBLISHED / "random_faults.jsonl"
ARM = "random"
"""Name of the arm in the file of flights."""


def read_faults() -> tuple[Mutant, ...]:
    """The faults of the committed file."""
    return tuple(Mutant.from_json(json.loads(line)) for line in FILE.read_text(encoding="utf-8").splitlines())


def fly(study: Study, faults: Sequence[Mutant], path: Path, jobs: int, draws: int | None = None) -> list[Outcome]:
    """Fly what is missing in the file of flights; returns all flights of the file.

    Args:
        study: the study.
        faults: the random faults.
        path: the file of flights.
        jobs: number of processes.
        draws: number of draws of seed and situation; None = all.
    """
    keys = [situation.key for situation in study.grid.situations]
    names = names_of([fault.id for fault in faults], keys, draws)
    return list(fly_arms(path, jobs, {ARM: (study, faults, names)})[ARM].values())


def hazop_arm(study: Study) -> Arm:
    """The default mutants, from the published flights."""
    return Arm.of("HAZOP", outcomes(study, published()), study.roster.defaults.values(), study.space)


def results(study: Study, jobs: int, folder: Path) -> str:
    """Fly what is missing, and tell."""
    faults = read_faults()
    flights = fly(study, faults, folder / "random_faults_flights.jsonl.gz", jobs)
    defaults = [realise(study.matrix, mutant) for mutant in study.roster.defaults.values()]
    random = Arm.of("random", flights, [fault.id for fault in faults], study.space)
    return flown(hazop_arm(study), random, {mutant.id: mutant for mutant in (*defaults, *faults)})


if __name__ == "__main__":
    write(__doc__, "random_faults", results)
