"""Ask whether the situations that kill a mutant detect a real bug of its kind.

    python -m experiments.bugs [--jobs N] [--output FILE]

The page states the bugs, the flights and the rules.  Finished flights are kept beside the page, in
`bugs_flights.jsonl.gz`, at the latest after ten seconds; the same command flies only what is missing there.  Delete the
file after a change of the study or of the code.

Situations are keys; a set of them *detects* a bug if the score's own test, restricted to that set, does.
"""

from __future__ import annotations

import experiments.published_kernels  # noqa: F401 - it must be imported before numpy

# isort: split

import math
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations, pairwise
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import hypergeom

from experiments.bug_stacks import BUGS, Bug, StackStudy, declare
from experiments.flights import Flights, fly_arms, names_of, outcomes, published
from experiments.pages import Row, blocks, table, write
from scaloft_fi.analysis.detection import Detection, Pool, Sample, Spending, detect
from scaloft_fi.analysis.score import MutantScore, score
from scaloft_fi.judge.outcome import BASELINE, Outcome
from scaloft_fi.judge.requirement import Kind
from scaloft_fi.registry import grouped
from scaloft_fi.streams import generator
from scaloft_fi.study import Study

SEEDS = tuple(range(3))
SITUATIONS = 32
TOGETHER = 3
"""Size of the small sets that are drawn besides single situations."""
LEVEL = 0.05
REFERENCE = "reference"
"""Arm of the flights of the reference stack."""
FLIGHTS = (len(BUGS) + 1) * SITUATIONS * len(SEEDS)


POOL = range(10)
"""Seeds of the baselines that a bug is compared with."""
TWO_OF_TWO = 2 / math.comb(len(POOL) + 2, 2)
"""p of two violations of two beside none of the pool, by Holm over two requirements."""
Samples = Mapping[str, Sample]
"""A bug's flights by situation."""


@dataclass(frozen=True)
class Published:
    """The published campaign.

    Attributes:
        mutants: the score of each default mutant, by cell.
        pool: of ten seeds.
        violated: requirements that each baseline violates, by name of the flight.
        alpha: the study's.
    """

    mutants: Mapping[str, MutantScore]
    pool: Pool
    violated: Mapping[str, frozenset[str]]
    alpha: float

    @property
    def tested(self) -> frozenset[str]:
        """The situations with a steady safety requirement: only they put a fault to the test."""
        return frozenset(place[0] for place in self.pool.pairs if self.pool.steady(place[0], Kind.SAFETY))

    def killing(self, cell: str) -> frozenset[str]:
        """The situations in which the cell's default mutant is killed."""
        return frozenset(kill.situation for kill in self.mutants[cell].kills)


def campaign_of(study: Study, rows: Iterable[Mapping[str, Any]]) -> Published:
    """The published campaign, of the rows of its export."""
    listed = list(rows)
    flown = outcomes(study, listed)
    by_id = {mutant.subject.id: mutant for mutant in score(flown, study.roster, study.space).mutants}
    clean = [outcome for outcome in flown if outcome.mutant == BASELINE]
    scores = {cell: by_id[mutant] for cell, mutant in study.roster.defaults.items() if mutant in by_id}
    pool = Pool.of(outcome for outcome in clean if outcome.seed in POOL)
    return Published(scores, pool, {outcome.name: violated_by(outcome) for outcome in clean}, study.alpha)


def violated_by(flown: Outcome) -> frozenset[str]:
    """The requirements that a flight violates."""
    return frozenset(violation.requirement for violation in flown.violations)


def samples(flights: Iterable[Outcome], reference: Mapping[str, Outcome]) -> Samples:
    """A bug's flights by situation; one differs if its digest is not that of the reference stack's flight.

    Args:
        flights: of the bug.
        reference: flights of the reference stack on the same machine, by name.
    """
    by_situation: dict[str, list[Outcome]] = {}
    for outcome in sorted(flights, key=lambda outcome: outcome.seed):
        by_situation.setdefault(outcome.situation, []).append(outcome)
    differs = {key: any(one.digest != reference[one.name].digest for one in own) for key, own in by_situation.items()}
    return {
        key: replace(Sample.of(own), infected=differs[key], seeds=tuple(one.seed for one in own))
        for key, own in by_situation.items()
    }


def verdict(bug: str, own: Samples, seen: Published, situations: Collection[str]) -> Detection:
    """The score's verdict on a bug, of its flights in some of the situations."""
    chosen = [sample for key, sample in own.items() if key in situations]
    return detect(bug, chosen, seen.pool, Spending(seen.alpha), Kind.SAFETY)


def coupling(bug: Bug, own: Samples, seen: Published, twins: int) -> Coupling:
    """The bug beside its cell's mutant; `twins` bugs, itself among them, have the same flights."""
    alone = frozenset(key for key in own if verdict(bug.key, own, seen, {key}).detected)
    return Coupling(bug.key, seen.killing(bug.cell), alone, 1.0 / twins)


RELABELLINGS = 9_999
DRAWS = 1_000
"""Sets that are drawn where there are more than that."""
Detects = Callable[[Collection[str]], bool]
"""Whether a set of situations detects a bug."""


@dataclass(frozen=True)
class Coupling:
    """A bug beside the mutant of its cell.

    Attributes:
        key: of the bug.
        killing: situations that kill the mutant.
        alone: situations that detect the bug, each by itself.
        weight: 1 divided by the number of bugs with the same flights.
    """

    key: str
    killing: frozenset[str]
    alone: frozenset[str]
    weight: float = 1.0

    def excess(self, population: Collection[str]) -> float:
        """How much oftener a killing situation detects the bug than one of the population does."""
        return share(self.alone, self.killing) - share(self.alone, population)

    def p(self, population: Collection[str]) -> float:
        """Chance that as many situations of the population, drawn at random, hold as many that detect the bug."""
        whole, detecting = len(population), len(self.alone & set(population))
        return tail(whole, detecting, len(self.killing), len(self.alone & self.killing))


def share(part: Collection[str], whole: Collection[str]) -> float:
    """The share of `whole` that lies in `part`.

    >>> share("ab", "bc")
    0.5
    """
    return len(set(part) & set(whole)) / len(whole)


def tail(whole: int, marked: int, drawn: int, least: int) -> float:
    """Chance that `drawn` of `whole`, without putting back, hold at least `least` of the `marked`.

    >>> round(tail(4, 2, 2, 2), 9), tail(4, 2, 2, 0)
    (0.166666667, 1.0)
    """
    return float(hypergeom.sf(least - 1, whole, marked, drawn))


def mean_excess(bugs: Sequence[Coupling], population: Collection[str]) -> float:
    """The weighted mean of the bugs' excess."""
    return sum(bug.weight * bug.excess(population) for bug in bugs) / sum(bug.weight for bug in bugs)


def relabelled_p(bugs: Sequence[Coupling], *strata: Collection[str]) -> float:
    """Chance of at least the mean excess if the names of the situations tell nothing of kills.

    Each of `RELABELLINGS` keyed draws permutes the names in all sets of killing situations at once, so that the sets
    keep their sizes and what they have in common.

    Args:
        bugs: the bugs; their killing situations lie in the strata.
        strata: the situations; a name stays in its stratum.
    """
    names = [name for stratum in strata for name in sorted(stratum)]
    begins = np.cumsum([0, *map(len, strata)])
    killing = np.array([[name in bug.killing for name in names] for bug in bugs], float)
    alone = np.array([[name in bug.alone for name in names] for bug in bugs], float)
    alone *= np.array([[bug.weight / len(bug.killing)] for bug in bugs])
    random = generator("bugs", "relabelling")
    seen = float((killing * alone).sum())

    def relabelled() -> float:
        order = [low + random.permutation(high - low) for low, high in pairwise(begins)]
        return float((killing[:, np.concatenate(order)] * alone).sum())

    drawn = (relabelled() for _ in range(RELABELLINGS))
    return (1 + sum(value >= seen - 1e-9 for value in drawn)) / (1 + RELABELLINGS)


def detecting_share(detects: Detects, population: Collection[str], size: int, *name: object) -> float:
    """The share of sets of `size` situations of the population that detect a bug.

    All of them where there are at most `DRAWS`, else that many draws of the stream `name`.
    """
    names = sorted(population)
    if math.comb(len(names), size) <= DRAWS:
        sets = list(combinations(names, size))
    else:
        random = generator("bugs", "sets", *name)
        sets = [tuple(names[i] for i in random.permutation(len(names))[:size]) for _ in range(DRAWS)]
    return sum(map(detects, sets)) / len(sets)


def flown(bugs: Sequence[Bug], flights: Flights, seen: Published) -> str:
    """The section with the results of the bugs.

    Args:
        bugs: the bugs.
        flights: by key of the bug, or `REFERENCE`, and name of the flight.
        seen: the published campaign.
    """
    own = {bug.key: samples(flights[bug.key].values(), flights[REFERENCE]) for bug in bugs}
    same = {bug.key: [other.key for other in bugs if _alike(flights[bug.key], flights[other.key])] for bug in bugs}
    counted = [bug for bug in bugs if seen.killing(bug.cell)]
    apart = [bug for bug in bugs if not seen.killing(bug.cell)]

    def beside(own: Mapping[str, Samples], group: Sequence[Bug], seen: Published) -> list[Coupling]:
        twins = [sum(other.key in same[bug.key] for other in group) for bug in group]
        return [coupling(bug, own[bug.key], seen, number) for bug, number in zip(group, twins, strict=True)]

    found = {one.key: one for group in (counted, apart) for one in beside(own, group, seen)}
    fewer = replace(seen, alpha=TWO_OF_TWO)
    without = [
        beside(
            {key: {place: one.without(seed) for place, one in of.items()} for key, of in own.items()}, counted, fewer
        )
        for seed in SEEDS
    ]
    other = sum(violated_by(one) != seen.violated[name] for name, one in flights[REFERENCE].items())
    return blocks(
        "## Flown",
        [*_answer([found[bug.key] for bug in counted], seen), *_without_a_seed(without, seen.tested)],
        f"{other} of {len(flights[REFERENCE])} flights of the reference stack violate other requirements than the "
        "published ones.",
        _twins(same),
        _couplings(counted, found, own, seen),
        *_sets(counted, own, seen),
        *_others(counted, found, seen),
        *_apart(apart, found, own, seen),
        *_violations(bugs, flights),
    )


def _alike(one: Mapping[str, Outcome], other: Mapping[str, Outcome]) -> bool:
    return {name: o.digest for name, o in one.items()} == {name: o.digest for name, o in other.items()}


def _answer(counted: Sequence[Coupling], seen: Published) -> Iterator[str]:
    populations = {"that put a fault to the test": seen.tested, "of the grid": frozenset(seen.pool.flown)}
    for number, (words, population) in enumerate(populations.items()):
        excess, p = mean_excess(counted, population), relabelled_p(counted, population)
        told = f"{excess:+.3f} (p = {p:.2g}, {len(counted)} bugs, {len(population)} situations {words})"
        if number == 0:
            shown = "Yes: killing" if excess > 0 and p <= LEVEL else "These bugs do not show that killing"
            yield f"**{shown} situations detect the bug of their cell oftener than random ones.**  Mean excess {told}."
        else:
            yield f"The easier comparison: mean excess {told}."
    yield from _without_the_greatest(counted, seen.tested)
    alike = grouped(sorted(seen.tested), lambda key: seen.pool.steady(key, Kind.SAFETY))
    strata = sorted(alike.values(), key=len, reverse=True)
    sizes = " and ".join(str(len(keys)) for keys in strata)
    yield (
        "Not registered: with names permuted only among situations that put the same safety requirements to the test "
        f"({sizes}) p = {relabelled_p(counted, *strata):.2g}."
    )


def _without_the_greatest(counted: Sequence[Coupling], tested: frozenset[str]) -> Iterator[str]:
    """How much of the answer one bug carries; this was not registered."""
    rest = sorted(counted, key=lambda one: one.excess(tested))[:-1]
    if rest:
        told = f"{mean_excess(rest, tested):+.3f} (p = {relabelled_p(rest, tested):.2g}, {len(rest)} bugs)"
        yield f"Not registered: without the bug of the greatest excess the mean is {told}."


def _without_a_seed(without: Sequence[Sequence[Coupling]], tested: frozenset[str]) -> Iterator[str]:
    """What remains of the answer without each seed of the bugs; this was not registered."""
    told = "; ".join(f"{mean_excess(left, tested):+.3f} (p = {relabelled_p(left, tested):.2g})" for left in without)
    yield f"Not registered: without each of the bugs' seeds in turn the mean is {told}."
    yield f"Alpha is {TWO_OF_TWO:.2g} there: one situation detects by two violations of two beside none of ten."


def _twins(same: Mapping[str, Sequence[str]]) -> str:
    groups = sorted({tuple(keys) for keys in same.values() if len(keys) > 1})
    told = "; ".join(" and ".join(keys) for keys in groups)
    return f"Bit-identical flights: {told}." if groups else ""


def _couplings(
    counted: Sequence[Bug], found: Mapping[str, Coupling], own: Mapping[str, Samples], seen: Published
) -> Iterator[str]:
    def row(bug: Bug) -> Row:
        one, tested = found[bug.key], seen.tested
        told = verdict(bug.key, own[bug.key], seen, own[bug.key]).verdict.words
        hits, every = len(one.alone & one.killing), f"{len(one.alone & tested)} of {len(tested)}"
        excess, p = f"{one.excess(tested):+.3f}", f"{one.p(tested):.2g}"
        return bug.key, bug.cell, told, len(one.killing), hits, every, excess, p, _coupled(one, tested)

    head = "bug", "cell", "verdict on the bug", "killing situations", "detect it alone", "of all that test"
    return table((*head, "excess", "p", "coupled"), map(row, counted))


def _coupled(one: Coupling, tested: frozenset[str]) -> str:
    if not one.alone:
        return "no situation detects it"
    if tested <= one.alone:
        return "every situation detects it"
    return "yes" if one.excess(tested) > 0 and one.p(tested) <= LEVEL else "no"


def _sets(counted: Sequence[Bug], own: Mapping[str, Samples], seen: Published) -> Iterator[str | Iterable[str]]:
    def row(bug: Bug) -> Row:
        killing, flights, key = seen.killing(bug.cell), own[bug.key], bug.key

        def detects(chosen: Collection[str]) -> bool:
            return verdict(key, flights, seen, chosen).detected

        few = min(TOGETHER, len(killing))
        shares = (
            detecting_share(detects, killing, few, key, "killing"),
            detecting_share(detects, seen.tested, few, key, "random"),
            float(detects(killing)),
            detecting_share(detects, seen.tested, len(killing), key, "as many"),
        )
        return key, *(f"{value:.2f}" for value in shares)

    yield "Share of sets of situations that detect the bug:"
    head = "bug", f"{TOGETHER} killing", f"{TOGETHER} random", "all killing", "as many random"
    yield table(head, map(row, counted))


def _others(counted: Sequence[Bug], found: Mapping[str, Coupling], seen: Published) -> Iterator[str | Iterable[str]]:
    def row(bug: Bug) -> Row:
        parameter, alone = bug.cell.split("-")[1], found[bug.key].alone
        sets = [seen.killing(cell) for cell in seen.mutants if cell.split("-")[1] != parameter]
        others = [share(alone, killing) for killing in sets if killing]
        mean = f"{sum(others) / len(others):.2f} ({len(others)})" if others else "none"
        return bug.key, f"{share(alone, found[bug.key].killing):.2f}", mean

    yield "Share of killing situations that detect the bug alone: of its own cell, and mean over the cells of other\n\
parameters whose default mutant has kills:"
    yield table(("bug", "own cell", "other cells"), map(row, counted))


def _apart(
    apart: Sequence[Bug], found: Mapping[str, Coupling], own: Mapping[str, Samples], seen: Published
) -> Iterator[str | Iterable[str]]:
    def row(bug: Bug) -> Row:
        flights = own[bug.key]
        verdicts = seen.mutants[bug.cell].verdict.words, verdict(bug.key, flights, seen, flights).verdict.words
        differs = f"{sum(sample.infected for sample in flights.values())} of {len(flights)}"
        return bug.key, bug.cell, *verdicts, differs, len(found[bug.key].alone)

    yield "Apart, because the mutant of the cell is killed nowhere:"
    verdicts = "verdict on the mutant", "verdict on the bug"
    yield table(("bug", "cell", *verdicts, "situations where it differs", "detect it alone"), map(row, apart))


def _violations(bugs: Sequence[Bug], flights: Flights) -> Iterator[str | Iterable[str]]:
    def row(bug: Bug) -> Row:
        own = flights[bug.key].values()
        counts = (sum(name in violated_by(one) for one in own) for name in ("SR1", "SR2", "OP1"))
        return bug.key, len(own), *counts, sum(bool(one.stack_error) for one in own)

    yield f"Flights of each bug that violate, over {SITUATIONS} situations:"
    yield table(("bug", "flights", "SR1", "SR2", "OP1", "stack raised an error"), map(row, bugs))


def results(study: Study, jobs: int, folder: Path) -> str:
    """Fly what is missing, and tell."""
    declare()
    names = names_of([BASELINE], [situation.key for situation in study.grid.situations], SEEDS)
    stacks = {REFERENCE: study, **{bug.key: StackStudy(study.folder, stack_name=bug.key) for bug in BUGS}}
    arms = {arm: (copy, (), names) for arm, copy in stacks.items()}
    return flown(BUGS, fly_arms(folder / "bugs_flights.jsonl.gz", jobs, arms), campaign_of(study, published()))


if __name__ == "__main__":
    write(__doc__, "bugs", results)
