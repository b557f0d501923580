"""The plan: the flights of a campaign in a stable order: baselines, PLACEBO, mutants, then the pool."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import count, islice
from typing import TYPE_CHECKING

from scaloft_fi.campaign.plan.flight import Flight
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.judge.requirement import Kind
from scaloft_fi.mutants.mutant import PLACEBO, Mutant

if TYPE_CHECKING:
    from scaloft_fi.sim.situation import Situation


@dataclass(frozen=True)
class Plan:
    """All flights of one run.

    Attributes:
        baselines: one baseline for each situation and seed.
        mutants: flights of PLACEBO, then of every mutant, in the same situations and with the same seeds.
        canary: the control that is flown once, in a situation chosen after the baselines; None if the controls are
            among the mutants.
        seeds: seeds of the mutants' flights in the whole run, of which this plan may be a shard.
        pool_seeds: seeds of the baseline pool where a mutant infects; None = as many as a pool needs.
    """

    baselines: tuple[Flight, ...]
    mutants: tuple[Flight, ...]
    canary: Mutant | None
    seeds: tuple[int, ...] = ()
    pool_seeds: tuple[int, ...] | None = ()

    @property
    def known(self) -> tuple[Flight, ...]:
        """The flights that are planned before the first flight, each once."""
        return *self.baselines, *self.mutants

    def with_pool(self, seeds: Sequence[int] | None = None) -> Plan:
        """The plan with a baseline pool of these and the mutants' seeds; by default as many seeds as a pool needs."""
        return replace(self, pool_seeds=None if seeds is None else tuple(seeds))

    def pool(self, situation: Situation, enough: int) -> tuple[Flight, ...]:
        """The additional baselines of a situation in which a mutant infects.

        Args:
            situation: a situation of the plan.
            enough: number of baselines in a pool, including those with the mutants' seeds.
        """
        own = [flight.seed for flight in self.baselines if flight.situation == situation]
        if self.pool_seeds is None:
            others = (seed for seed in count() if seed not in own)
            more = list(islice(others, max(0, enough - len(own))))
        else:
            more = [seed for seed in self.pool_seeds if seed not in own]
        return tuple(Flight(None, situation, seed) for seed in more)

    def infected(self, outcomes: Iterable[Outcome]) -> tuple[Situation, ...]:
        """The situations in which a mutant changed a sample, in the plan's order."""
        keys = {outcome.situation for outcome in outcomes if infects(outcome)}
        return tuple(dict.fromkeys(flight.situation for flight in self.baselines if flight.situation.key in keys))

    def shard(self, number: int, shards: int) -> Plan:
        """The plan for every `shards`-th pair of situation and seed, beginning with the `number`-th (from 1)."""
        own = {(flight.situation.key, flight.seed) for flight in self.baselines[number - 1 :: shards]}

        def ours(flights: tuple[Flight, ...]) -> tuple[Flight, ...]:
            return tuple(flight for flight in flights if (flight.situation.key, flight.seed) in own)

        return replace(
            self,
            baselines=ours(self.baselines),
            mutants=ours(self.mutants),
            canary=self.canary if own else None,
        )


def plan(
    situations: Sequence[Situation], seeds: Sequence[int], mutants: Iterable[Mutant], canary: Mutant | None
) -> Plan:
    """Plan `mutants` in `situations` with `seeds`, with their baselines, PLACEBO and the canary."""
    return plan_draws([(situation, seed) for situation in situations for seed in seeds], mutants, canary)


def plan_draws(draws: Sequence[tuple[Situation, int]], mutants: Iterable[Mutant], canary: Mutant | None) -> Plan:
    """Plan `mutants` for pairs of situation and seed."""
    flown = [PLACEBO, *(mutant for mutant in mutants if mutant != PLACEBO)]
    return Plan(
        baselines=tuple(Flight(None, *draw) for draw in draws),
        mutants=tuple(Flight(mutant, *draw) for mutant in flown for draw in draws),
        canary=None if canary in flown else canary,
        seeds=tuple(sorted({seed for _, seed in draws})),
    )


def infects(outcome: Outcome) -> bool:
    """Whether the flight is of a mutant and its fault changed a sample."""
    return outcome.altered > 0 and outcome.mutant != PLACEBO.id and not outcome.invalid


def canary_flight(planned: Plan, baselines: Iterable[Outcome]) -> Flight | None:
    """The canary's flight, where its baseline holds most requirements, which it can violate; None without a canary."""
    if planned.canary is None or not planned.baselines:
        return None
    held = {(outcome.situation, outcome.seed): held_requirements(outcome) for outcome in baselines}
    best = max(planned.baselines, key=lambda flight: held.get((flight.situation.key, flight.seed), 0))
    return Flight(planned.canary, best.situation, best.seed)


def held_requirements(baseline: Outcome) -> int:
    """The number of safety and operability requirements that the baseline held to its end."""
    counting = [reading for reading in baseline.readings if reading.kind is not Kind.REPORTED]
    return sum(not (reading.violated or reading.open) for reading in counting)
