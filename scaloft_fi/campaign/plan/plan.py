"""Which flights a campaign flies, in a stable order: baselines, PLACEBO beside each, mutants, then the pool."""

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
        baselines: one for each situation and seed.
        mutants: PLACEBO in the same, then every mutant in the same.
        canary: the control that is flown once, in a situation chosen when the baselines are known; None when the
            controls are among the mutants.
        seeds: of the mutants' flights, over the whole run of which this may be a shard.
        pool_seeds: of the baseline pool in the situations where a mutant infects; None = enough for a pool.
    """

    baselines: tuple[Flight, ...]
    mutants: tuple[Flight, ...]
    canary: Mutant | None
    seeds: tuple[int, ...] = ()
    pool_seeds: tuple[int, ...] | None = ()

    @property
    def known(self) -> tuple[Flight, ...]:
        """The flights that are planned before any is flown, each once."""
        return *self.baselines, *self.mutants

    def with_pool(self, seeds: Sequence[int] | None = None) -> Plan:
        """The same with a baseline pool: of these seeds and the mutants' own, by default as many as a pool needs."""
        return replace(self, pool_seeds=None if seeds is None else tuple(seeds))

    def pool(self, situation: Situation, enough: int) -> tuple[Flight, ...]:
        """The baselines that are flown in a situation once a mutant has infected there.

        Args:
            situation: one of the plan.
            enough: how many baselines make a pool, those of the mutants' own seeds counted.
        """
        own = [flight.seed for flight in self.baselines if flight.situation == situation]
        if self.pool_seeds is None:
            others = (seed for seed in count() if seed not in own)
            more = list(islice(others, max(0, enough - len(own))))
        else:
            more = [seed for seed in self.pool_seeds if seed not in own]
        return tuple(Flight(None, situation, seed) for seed in more)

    def infected(self, outcomes: Iterable[Outcome]) -> tuple[Situation, ...]:
        """The situations where a mutant's fault changed a sample, in the plan's order."""
        keys = {outcome.situation for outcome in outcomes if infects(outcome)}
        return tuple(dict.fromkeys(flight.situation for flight in self.baselines if flight.situation.key in keys))

    def shard(self, number: int, shards: int) -> Plan:
        """Every `shards`-th situation and seed, from the `number`-th (counted from 1) on."""
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
    """The flights of `mutants` in `situations` with `seeds`, and what has to be flown to believe them."""
    return plan_draws([(situation, seed) for situation in situations for seed in seeds], mutants, canary)


def plan_draws(draws: Sequence[tuple[Situation, int]], mutants: Iterable[Mutant], canary: Mutant | None) -> Plan:
    """The same where each situation comes with its own seeds."""
    flown = [PLACEBO, *(mutant for mutant in mutants if mutant != PLACEBO)]
    return Plan(
        baselines=tuple(Flight(None, *draw) for draw in draws),
        mutants=tuple(Flight(mutant, *draw) for mutant in flown for draw in draws),
        canary=None if canary in flown else canary,
        seeds=tuple(sorted({seed for _, seed in draws})),
    )


def infects(outcome: Outcome) -> bool:
    """Whether a mutant's fault changed a sample in this flight."""
    return outcome.altered > 0 and outcome.mutant != PLACEBO.id and not outcome.invalid


def canary_flight(planned: Plan, baselines: Iterable[Outcome]) -> Flight | None:
    """The canary where its baseline holds most, so that it has something to violate; None without a canary."""
    if planned.canary is None or not planned.baselines:
        return None
    held = {(outcome.situation, outcome.seed): held_requirements(outcome) for outcome in baselines}
    best = max(planned.baselines, key=lambda flight: held.get((flight.situation.key, flight.seed), 0))
    return Flight(planned.canary, best.situation, best.seed)


def held_requirements(baseline: Outcome) -> int:
    """How many requirements that count the baseline held to its end."""
    counting = [reading for reading in baseline.readings if reading.kind is not Kind.REPORTED]
    return sum(not (reading.violated or reading.open) for reading in counting)
