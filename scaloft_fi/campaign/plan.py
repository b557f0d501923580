"""The plan: which flights are flown, in which order, in which batches; what the command line names is parsed here."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import count, islice
from typing import TYPE_CHECKING

from scaloft_fi.campaign.flights.fly import Batch, Flight
from scaloft_fi.defaults import Seeds
from scaloft_fi.errors import InputError
from scaloft_fi.hazop.matrix import CellStatus
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.judge.requirement import Kind
from scaloft_fi.mutants.catalogue import defaults, select
from scaloft_fi.mutants.mutant import PLACEBO, Mutant
from scaloft_fi.registry import grouped
from scaloft_fi.study import Study

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

    @cached_property
    def subjects(self) -> frozenset[str]:
        """Ids of the mutants, and of PLACEBO."""
        return frozenset(flight.subject.id for flight in self.mutants)

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
        own = {flight.pair for flight in self.baselines[number - 1 :: shards]}

        def ours(flights: tuple[Flight, ...]) -> tuple[Flight, ...]:
            return tuple(flight for flight in flights if flight.pair in own)

        return replace(
            self, baselines=ours(self.baselines), mutants=ours(self.mutants), canary=self.canary if own else None
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
    best = max(planned.baselines, key=lambda flight: held.get(flight.pair, 0))
    return Flight(planned.canary, best.situation, best.seed)


def held_requirements(baseline: Outcome) -> int:
    """The number of safety and operability requirements that the baseline held to its end."""
    counting = [reading for reading in baseline.readings if reading.kind is not Kind.REPORTED]
    return sum(not (reading.violated or reading.open) for reading in counting)


MOST_SEEDS = 100_000


def parse_seeds(given: Seeds, option: str = "--seeds") -> tuple[int, ...]:
    """`N` means 0..N-1, `A-B` means A to B, both included.

    >>> parse_seeds("3"), parse_seeds("4-5"), parse_seeds(2), parse_seeds([7, 9])
    ((0, 1, 2), (4, 5), (0, 1), (7, 9))

    Raises:
        InputError: the seeds have another form, are not different, or there is none.
    """
    if isinstance(given, str):
        return _seeds_in(given, option)
    if isinstance(given, int):
        listed = () if isinstance(given, bool) else tuple(range(min(given, MOST_SEEDS + 1)))
    else:
        listed = tuple(given) if isinstance(given, range | list | tuple) else ()
    whole = all(isinstance(one, int) and not isinstance(one, bool) and one >= 0 for one in listed)
    if not 0 < len(set(listed)) == len(listed) <= MOST_SEEDS or not whole:
        raise InputError(
            f"{option}={given!r} must be a number of seeds from 1 to {MOST_SEEDS}, a text such as '4-6', or different "
            "seeds, none below 0"
        )
    return listed


def _seeds_in(text: str, option: str) -> tuple[int, ...]:
    match = re.fullmatch(r"(\d{1,9})(?:-(\d{1,9}))?", text.strip())
    if match:
        first, last = (0, int(match[1]) - 1) if match[2] is None else (int(match[1]), int(match[2]))
        if 0 <= last - first < MOST_SEEDS:
            return tuple(range(first, last + 1))
    raise InputError(f"{option}={text!r} must be N for seeds 0..N-1 (N >= 1), or A-B with A <= B")


def parse_shard(text: str) -> tuple[int, int]:
    """`k/n`: the k-th of n shards.

    >>> parse_shard("2/3")
    (2, 3)

    Raises:
        InputError: the text is no such pair.
    """
    match = re.fullmatch(r"(\d{1,6})/(\d{1,6})", text.strip())
    if match and 1 <= int(match[1]) <= int(match[2]):
        return int(match[1]), int(match[2])
    raise InputError(f"--shard={text!r} must be K/N with 1 <= K <= N, as in 1/4")


def parse_mutants(study: Study, patterns: Sequence[str]) -> tuple[Mutant, ...]:
    """The mutants to fly in addition to PLACEBO: those that match, or by default every cell's default and the controls.

    Raises:
        InputError: a pattern matches no mutant.
    """
    if not patterns:
        return defaults(study.matrix)
    wanted = [pattern for pattern in patterns if pattern != PLACEBO.id]
    return select(wanted, study.matrix, study.catalogue)


def canary(study: Study) -> Mutant | None:
    """The control whose flight proves that faults reach the drone; None in a study without controls."""
    matrix = study.matrix
    controls = [mutant for mutant in defaults(matrix) if matrix.cell(mutant.cell).status is CellStatus.CONTROL]
    seams = study.stack.canaries
    steady = sorted((m for m in controls if m.seam in seams), key=lambda m: seams.index(m.seam))
    return next(iter([*steady, *controls]), None)


SHARES_PER_JOB = 2
"""A batch is at most 1 / this of the remaining work of one process, so that all processes end at about one time."""
LEAST_SHARING = 8
"""A baseline is flown once more for another process only if at least this number of mutants share it."""


def alone(flights: Iterable[Flight]) -> list[Batch]:
    """One batch for each flight, flown whole."""
    return [Batch((flight,)) for flight in flights]


def in_runs(flights: Iterable[Flight], runner: Callable[[Situation], str]) -> list[Batch]:
    """One batch for the flights that one run flies, none of them shared."""
    runs = grouped(flights, lambda flight: (flight.subject.id, flight.seed, runner(flight.situation)))
    return [Batch(tuple(flown)) for flown in runs.values()]


def together(flights: Sequence[Flight], weight_s: Callable[[Flight], float], jobs: int) -> list[Batch]:
    """Batches of mutants with the baseline of their situation and seed; a baseline outside `flights` is flown again.

    Batches get smaller towards the end (Polychronopoulos and Kuck, Guided self-scheduling, IEEE Trans. Computers
    36(12), 1987): the duration of a flight is unknown beforehand, and small last batches balance the processes.

    Args:
        flights: the flights.
        weight_s: expected duration of a flight [s].
        jobs: number of processes; several processes fly a baseline with many mutants if that keeps them busy.

    Returns:
        The batches; the longest batch is first.
    """
    batches = alone(flight for flight in flights if flight.mutant == PLACEBO)
    sharing: list[tuple[float, Flight, list[Flight]]] = []
    draws: dict[Flight, list[Flight]] = {}
    for flight in flights:
        if flight.mutant != PLACEBO:  # which shares no baseline
            theirs = draws.setdefault(Flight(None, flight.situation, flight.seed), [])
            theirs += [flight] if flight.mutant is not None else []
    for baseline, mutants in draws.items():
        if len(mutants) == 1 and baseline not in flights:  # the baseline would cost more than it saves
            batches += alone(mutants)
        else:
            sharing.append((weight_s(baseline) * (1 + len(mutants)), baseline, mutants))

    def whole_s(batch: Batch) -> float:
        return sum(map(weight_s, batch.flights))

    left_s = sum(map(whole_s, batches)) + sum(own_s for own_s, _, _ in sharing)
    for own_s, baseline, mutants in sorted(sharing, key=lambda entry: entry[0], reverse=True):
        most = len(mutants) // LEAST_SHARING if jobs > 1 else 1
        pieces = max(1, min(most, math.ceil(own_s * SHARES_PER_JOB * jobs / left_s) if left_s else 1))
        batches += [Batch((baseline, *mutants[piece::pieces]), shared=True) for piece in range(pieces)]
        left_s -= own_s
    return sorted(batches, key=whole_s, reverse=True)
