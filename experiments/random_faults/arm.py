"""One arm of the experiment: its faults, scored, and what is counted of them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

from experiments.random_faults.plan import POOL, SEEDS
from scaloft_fi.analysis.detection import ALPHA, Spending
from scaloft_fi.analysis.pool import Pool, State
from scaloft_fi.analysis.score import MutantScore, mutant_score
from scaloft_fi.judge.outcome import BASELINE, Outcome
from scaloft_fi.judge.requirement import Kind
from scaloft_fi.judge.space import Space
from scaloft_fi.judge.status import Rulings, rulings_of

Kills = frozenset[tuple[str, str]]
"""Situations and requirements that kill a fault."""
Draw = tuple[str, int]
"""Situation and seed."""


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
        known = set(faults)
        counted = [
            outcome
            for outcome in outcomes
            if (outcome.mutant in known and outcome.seed < SEEDS)
            or (outcome.mutant == BASELINE and outcome.seed < POOL)
        ]
        return cls(name, counted, space)

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
        chosen = {
            subject: {
                key: [one for seed in seeds for one in flights if one.seed == seed]
                for key, flights in situations.items()
            }
            for subject, situations in self.rulings.mutants.items()
        }
        return tuple(
            mutant_score(subject, own, self.space, pooled, Spending(ALPHA), firm=False)
            for subject, own in chosen.items()
        )

    @cached_property
    def digests(self) -> Mapping[str, Mapping[Draw, str]]:
        """The digests of each fault's valid flights, by its id."""
        found: dict[str, dict[Draw, str]] = {}
        for outcome in self.outcomes:
            if not outcome.invalid:
                found.setdefault(outcome.mutant, {})[outcome.situation, outcome.seed] = outcome.digest
        return found

    @cached_property
    def states(self) -> Mapping[tuple[str, str], State]:
        """The state of each pair of situation and safety requirement in the pool."""
        pool = Pool.of(self.rulings.baselines)
        return {place: pair.state for place, pair in pool.pairs.items() if pair.kind is Kind.SAFETY}

    @property
    def behaviours(self) -> int:
        """Different vectors of digests that are not the baseline's."""
        return len({tuple(sorted(own.items())) for mutant, own in self.digests.items() if self.acts(mutant)})

    def acts(self, mutant: str) -> bool:
        """Whether a flight of a fault has another digest than the baseline of its situation and seed."""
        clean = self.digests.get(BASELINE, {})
        flown = self.digests.get(mutant, {})
        return mutant != BASELINE and any(clean.get(draw) != digest for draw, digest in flown.items())

    @property
    def stopped(self) -> int:
        """Faults that make the stack raise an error in a flight."""
        return len({outcome.mutant for outcome in self.outcomes if outcome.stack_error})

    @property
    def invalid(self) -> int:
        """Flights whose harness failed."""
        return sum(bool(outcome.invalid) for outcome in self.outcomes)


def useful(score: MutantScore) -> bool:
    """Whether a fault is detected and not trivial."""
    return score.detected and not score.trivial


def kills_of(score: MutantScore) -> Kills:
    """The pairs that kill a fault."""
    return frozenset((kill.situation, kill.requirement) for kill in score.kills)


def kill_sets(scores: Iterable[MutantScore]) -> frozenset[Kills]:
    """The different sets of kills, without the empty one."""
    return frozenset(filter(None, map(kills_of, scores)))
