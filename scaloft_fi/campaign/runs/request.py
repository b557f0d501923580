r"""A request for a run: situations chosen, seeds or looks, read into a plan, then flown.

A Sobol sequence continues: a larger choice includes every smaller one, and points that no situation has are skipped
(constraints, `--situation`).  A Latin hypercube allows neither.  On seven axes of 2 to 4 values, means of 60 seeds: 8
points of both have 85 % of the pairs of values (random: 75 %), 32 points have 96 % of the triples (Latin hypercube:
91 %, random: 88 %).

A plugin declares a strategy with one decorated function, in a module that its entry point in the group
`scaloft_fi.plugins` names:

    @strategy("last", r"last:([1-9]\d*)", "last:N")
    def last(asked):
        return asked.each(asked.pool[-int(asked.match[1]):])
"""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from itertools import count, pairwise
from pathlib import Path
from typing import TYPE_CHECKING

from scaloft_fi.analysis.coverage import covering_array
from scaloft_fi.analysis.detection import LEAST, LOOKS, Look, Verdict
from scaloft_fi.analysis.score import score
from scaloft_fi.campaign.flights.fly import Flight, Flyer
from scaloft_fi.campaign.plan import Plan, canary, parse_mutants, plan, plan_draws
from scaloft_fi.campaign.progress import Progress
from scaloft_fi.campaign.runs.gates import ONE_PROCESS, RunOptions
from scaloft_fi.campaign.runs.run import Budget, Report, finish, fly_pool, opened, run
from scaloft_fi.campaign.store.archive import STORE_NAME, borrowed, promising, remember_grid, writable
from scaloft_fi.campaign.store.held import CHOICE, remember_seeds
from scaloft_fi.campaign.store.store import Store
from scaloft_fi.errors import InputError
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.judge.requirement import Kind
from scaloft_fi.judge.status import Rulings, rulings_of
from scaloft_fi.mutants.mutant import PLACEBO, Mutant
from scaloft_fi.registry import Registry
from scaloft_fi.sim.grid import ALL
from scaloft_fi.sim.situation import Situation
from scaloft_fi.streams import key_words
from scaloft_fi.study import Study

if TYPE_CHECKING:
    from scaloft_fi.judge.space import Space


MOST_LOG2 = 17
"""The search ends after 2^17 points of the sequence."""


def spread(pool: Sequence[Situation], space: Space, count: int, seed: int) -> tuple[Situation, ...]:
    """The first `count` distinct situations of the sequence, fewer if the search ends before.

    Args:
        pool: situations of the grid to choose from.
        space: the grid.
        count: how many.
        seed: seed of the choice, which scrambles the sequence.
    """
    from scipy.stats import qmc  # takes longer to import than other verbs take

    ranges = dict(space.ranges)
    levels = {axis: sorted({one[axis] for one in pool}) for axis in space.axes}
    for axis, range_ in ranges.items():
        levels[axis].sort(key=range_.ids.index)  # neighbouring numbers in neighbouring bins
    varied = [axis for axis in space.axes if axis in ranges or len(levels[axis]) > 1]
    scramble = key_words("choice", "sobol", seed)[0]
    known = {one.levels for one in pool}
    found: dict[Situation, None] = {}
    for log2 in range(min((count - 1).bit_length(), MOST_LOG2), MOST_LOG2 + 1):
        sequence = qmc.Sobol(max(1, len(varied) + len(space.free)), scramble=True, seed=scramble)
        for point in sequence.random_base2(log2).tolist():
            shares = dict(zip((*varied, *(axis for axis, _ in space.free)), point, strict=False))
            bins, numbers = {}, {}
            for axis, ids in levels.items():
                place, rest = divmod(shares.get(axis, 0.0) * len(ids), 1.0)
                bins[axis] = ids[int(place)]
                if axis in ranges:
                    numbers[axis] = ranges[axis].draw(bins[axis], rest)
            for axis, free in space.free:
                number = free.drawn(shares[axis]) if free.goes_with(bins) else None
                if number is not None and number != free.benign:
                    numbers[axis] = number
            if tuple(bins.items()) in known:
                found[Situation.of(bins, numbers)] = None
            if len(found) == count:
                return tuple(found)
    return tuple(found)


OPTION = "--choose"
Draws = tuple[tuple[Situation, int], ...]
"""Situation and seed of each test case, in the order in which they are chosen."""


@dataclass(frozen=True)
class Asked:
    """The input of a strategy.

    Attributes:
        text: text of the user.
        match: match of the strategy's pattern with the text.
        pool: situations to choose from.
        seeds: seeds of the flights.
        seed: seed of the choice; a strategy draws from `streams.key_words("choice", name, seed, ...)`.
        space: the grid.
        place: where the text stands, for errors.
    """

    text: str
    match: re.Match[str]
    pool: tuple[Situation, ...]
    seeds: tuple[int, ...]
    seed: int
    space: Space
    place: str = OPTION

    def each(self, situations: Iterable[Situation]) -> Draws:
        """Every situation with every seed."""
        return tuple((situation, seed) for situation in situations for seed in self.seeds)

    def drawn(self, situation: Situation, *stream: object) -> Situation:
        """The situation with a number drawn from each range of its axes, inside the bin that it has there.

        Bins have equal probability, so a number in a random bin follows the distribution of the range.  A number that
        the situation has already is kept.  Most free axes stay at their benign values.

        Args:
            situation: a situation of the pool.
            stream: name of the stream of the numbers, beside the seed of the choice.
        """
        numbers = dict(situation.numbers)
        for axis, range_ in self.space.ranges:
            numbers.setdefault(axis, range_.draw(situation[axis], self._share(*stream, axis)))
        for axis, free in self.space.free:
            number = free.drawn(self._share(*stream, axis)) if free.goes_with(dict(situation.levels)) else None
            if number is not None and number != free.benign:
                numbers.setdefault(axis, number)
        order = [axis for axis, _ in (*self.space.ranges, *self.space.free) if axis in numbers]  # as in keys
        return Situation.of(dict(situation.levels), {axis: numbers[axis] for axis in order})

    def _share(self, *stream: object) -> float:
        return (key_words("choice", *stream[:-1], self.seed, stream[-1])[0] >> 11) / 2**53  # exact, below 1

    def error(self, allowed: str) -> InputError:
        """The error that refuses the text; `allowed` completes its message."""
        return InputError(f"{self.place}={self.text!r} {allowed}")


@dataclass(frozen=True)
class Strategy:
    """A declared strategy.

    Attributes:
        pattern: pattern of the texts that the strategy accepts.
        form: form of these texts, for messages.
        draw: returns the test cases; raises `Asked.error` where the text exceeds the grid.
    """

    pattern: re.Pattern[str]
    form: str
    draw: Callable[[Asked], Draws]


STRATEGIES = Registry[Strategy]("strategy")


def strategy(name: str, pattern: str, form: str) -> Callable[[Callable[[Asked], Draws]], Callable[[Asked], Draws]]:
    """Declare the decorated function as the strategy for texts that `pattern` matches in full.

    Raises:
        ValueError: the name is taken.
    """

    def declare(draw: Callable[[Asked], Draws]) -> Callable[[Asked], Draws]:
        STRATEGIES.declare(name, Strategy(re.compile(pattern), form, draw))
        return draw

    return declare


@strategy("all", "all", "all")
def every(asked: Asked) -> Draws:
    """Every situation."""
    return asked.each(asked.pool)


@strategy("random", r"random:([1-9]\d{0,8})", "random:N")
def at_random(asked: Asked) -> Draws:
    """Distinct situations at random; a larger choice includes every smaller one of the same seed."""
    ordered = sorted(asked.pool, key=lambda one: key_words("choice", "random", asked.seed, one.key))
    return asked.each(asked.drawn(one, "random", one.key) for one in ordered[: _count(asked)])


@strategy("draws", r"draws:([1-9]\d{0,8}|([1-9]\d?(?:\.\d+)?|100)%)", "draws:N, draws:P%")
def draws(asked: Asked) -> Draws:
    """Draws with replacement: N draws, or draws until P % of the pool was drawn; a repetition takes the next seed."""
    if len(asked.seeds) > 1:
        raise asked.error("gives each draw a seed of its own: --seeds must name one, the first")
    share, seen, times, made = asked.match[2], set[Situation](), Counter[Situation](), list[tuple[Situation, int]]()
    target = math.ceil(Fraction(share) / 100 * len(asked.pool)) if share else None
    for number in count() if target else range(int(asked.match[1])):
        # 64 bits modulo the pool: no situation is favoured by more than 1 in 10^13
        one = asked.pool[key_words("choice", "draws", asked.seed, number)[0] % len(asked.pool)]
        situation = asked.drawn(one, "draws", number)
        made.append((situation, asked.seeds[0] + times[situation]))
        times[situation] += 1
        seen.add(one)
        if len(seen) == target:  # the stopping condition of SCALOFT's loop
            break
    return tuple(made)


@strategy("sobol", r"sobol:([1-9]\d{0,8})", "sobol:N")
def sobol(asked: Asked) -> Draws:
    """Distinct situations spread evenly over all axes; a larger choice includes every smaller one of the same seed."""
    if not (asked.space.ranges or asked.space.free):
        _count(asked)
    drawn = next((one.key for one in asked.pool if one.numbers), None)
    if drawn is not None:
        raise asked.error(f"draws the numbers of ranges itself: --situation must name none, as in {drawn!r}")
    most = int(asked.match[1])
    found = spread(asked.pool, asked.space, most, asked.seed)
    if len(found) < most:
        raise asked.error(f"must ask for at most {len(found)}, the distinct situations that it finds")
    return asked.each(found)


@strategy("first", r"first:([1-9]\d{0,8})", "first:N")
def first(asked: Asked) -> Draws:
    """The first situations of the grid."""
    return asked.each(asked.pool[: _count(asked)])


@strategy("covering", r"([1-9]\d?)-way", "a covering array such as 2-way")
def covering(asked: Asked) -> Draws:
    """A small set of situations that covers every combination of the values of t axes."""
    strength = int(asked.match[1])
    if strength > len(asked.space.axes):
        raise asked.error(f"must be 1-way to {len(asked.space.axes)}-way, the number of axes")
    by_key = {situation.key: situation for situation in asked.pool}
    return asked.each(by_key[key] for key in covering_array(asked.space, tuple(by_key), strength, asked.seed))


def _count(asked: Asked) -> int:
    most = int(asked.match[1])
    if most > len(asked.pool):
        raise asked.error(f"must ask for at most {len(asked.pool)}, the situations to choose from")
    return most


def hint() -> str:
    """The accepted forms of `--choose`, in words."""
    forms = [strategy.form for strategy in STRATEGIES.values()]
    return f"{', '.join(forms[:-1])} or {forms[-1]}"


@dataclass(frozen=True)
class Choice:
    """The test cases of a run.

    Attributes:
        text, seed: values of `--choose` and `--choose-seed`.
        pool: number of situations to choose from.
        draws: situation and seed of each test case, in the order of the choice.
    """

    text: str
    seed: int
    pool: int
    draws: Draws

    @property
    def situations(self) -> tuple[Situation, ...]:
        """The situations, each once."""
        return tuple(dict.fromkeys(situation for situation, _ in self.draws))


def choose_situations(
    text: str, pool: Sequence[Situation], seeds: Sequence[int], seed: int, space: Space, place: str = OPTION
) -> Choice:
    """Choose test cases; the same for the same arguments on every platform.

    Args:
        text: text for a declared strategy, such as `random:8`.
        pool: situations to choose from.
        seeds: seeds of the flights.
        seed: seed of the choice.
        space: the grid.
        place: where the text stands, for errors.

    Raises:
        InputError: no strategy accepts the text, or the strategy refuses it.
    """
    for strategy in STRATEGIES.values():
        match = strategy.pattern.fullmatch(text)
        if match:
            draws = strategy.draw(Asked(text, match, tuple(pool), tuple(seeds), seed, space, place))
            return Choice(text, seed, len(pool), tuple(draws))
    raise InputError(f"{place}={text!r} must be {hint()}")


def remember_choice(study: Study, folder: Path, choice: Choice) -> None:
    """Record a choice, and the grid of which it is one, in the campaign's store; all situations are no choice.

    Raises:
        InputError: the store cannot be written.
    """
    if choice.text == ALL:
        return
    draws = [[situation.key, number] for situation, number in choice.draws]
    promising(folder)
    with Store(writable(folder) / STORE_NAME) as store:
        remember_grid(store, study)
        store.remember(CHOICE, {"choose": choice.text, "seed": choice.seed, "pool": choice.pool, "draws": draws})


def run_looks(
    study: Study,
    question: Plan,
    folder: Path,
    options: RunOptions = ONE_PROCESS,
    *,
    others: Sequence[Outcome] = (),
    progress: Progress,
    flyer: Flyer | None = None,
    reaches: Callable[[Flight], bool] = lambda _flight: True,
) -> tuple[Report, tuple[Look, ...]]:
    """Fly whole looks: all flights of a look are flown and judged before the next look is planned.

    Undecided mutants fly on in the situations whose pool has a steady pair; all other mutants stop.  The flights follow
    from the outcomes alone: neither the order of arrival nor an interruption changes them.  The store records the looks
    before the first one, so each look spends its share of alpha.

    Args:
        study: the study.
        question: mutants and situations; its seeds are not used.
        folder: folder of the campaign; a missing folder is created.
        options: options of the run.
        others: baselines of another campaign, used for the decisions.
        progress: progress display.
        flyer: flies; PyBullet when None.
        reaches: which flights of mutants are flown.

    Returns:
        The outcomes of all flights; the looks.

    Raises:
        GateError: a gate failed.
        InputError: the folder or the store cannot be written.
        Interrupted: the user stopped the run.
    """
    situations = list(dict.fromkeys(flight.situation for flight in question.baselines))
    mutants = list(dict.fromkeys(f.mutant for f in question.mutants if f.mutant is not None and f.mutant != PLACEBO))

    def planned(seeds: Sequence[int], canary: Mutant | None) -> Plan:
        made = plan(situations, seeds, mutants, canary)
        return replace(made, mutants=tuple(filter(reaches, made.mutants)), pool_seeds=question.pool_seeds)

    first = planned(range(LOOKS[0]), question.canary)
    flights, looks = list[Flight](), list[Look]()
    with opened(study, folder, options, progress=progress, flyer=flyer, first=first.known) as campaign:
        for seeds in LOOKS:
            remember_seeds(campaign.store, (mutant.id for mutant in mutants), range(seeds))
        campaign.announce_pool(first)
        for number, (before, seeds) in enumerate(pairwise((0, *LOOKS)), start=1):
            if not mutants or not situations or campaign.stopped():
                break
            campaign.reporter.progress.stage = f"look {number} of {len(LOOKS)}"
            due = planned(range(before, seeds), None)
            campaign.plan(due.known)
            campaign.fly(due.known)
            flights = list(dict.fromkeys((*flights, *due.known, *fly_pool(due, campaign, Budget(None)))))
            scored = score(campaign.outcomes(flights), study.roster, study.space, campaign.spending, others)
            judged = {one.subject.id: one.verdict for one in (*scored.mutants, *scored.controls)}
            verdicts = {mutant: judged.get(mutant.id, Verdict.NOT_TESTED) for mutant in mutants}
            count = sum(flight.mutant != PLACEBO for flight in due.mutants)
            looks.append(Look(seeds, len(mutants), count, *map([*verdicts.values()].count, Verdict)))
            mutants = [mutant for mutant, verdict in verdicts.items() if verdict is Verdict.UNDECIDED]
            situations = [one for one in situations if scored.pool.steady(one.key, Kind.SAFETY)]
        report = finish(campaign, first, flights)
        campaign.raise_if_stopped(f"{len(report.outcomes)} flights are")
        campaign.hold_gates(question, report.outcomes)
        return report, tuple(looks)


ONE_SEED = (0,)


@dataclass(frozen=True)
class Request:
    """A request for a run; everything in it decides which flights are flown.

    Attributes:
        mutants: names, ids or patterns of mutants; empty = every cell's default and the controls.
        situations: keys, aliases or patterns of situations; empty = those that `choose` chooses.
        choose: which of the situations, such as `random:8`; None = what the grid says, or all of `situations`.
        choose_seed: seed of the choice.
        seeds: seeds of the mutants' flights; None = seed 0.
        baseline_seeds: seeds of the baseline pool in addition to `seeds`; None = as many as a pool needs.
        baseline_from: name of a campaign that lends its baselines.
        sequential: whether to fly in looks at 1, 3, 5 and 10 seeds.
        shard: (k, n) for the k-th of n parts; `merge` joins them.
        budget_s: wall time after which no flight begins [s]; None = unlimited.
    """

    mutants: tuple[str, ...] = ()
    situations: tuple[str, ...] = ()
    choose: str | None = None
    choose_seed: int = 0
    seeds: tuple[int, ...] | None = None
    baseline_seeds: tuple[int, ...] | None = None
    baseline_from: str | None = None
    sequential: bool = False
    shard: tuple[int, int] | None = None
    budget_s: float | None = None

    @property
    def pool_seeds(self) -> tuple[int, ...] | None:
        """Seeds of the baseline pool; a campaign that lends its baselines makes more of them needless."""
        return () if self.baseline_seeds is None and self.baseline_from else self.baseline_seeds

    @property
    def short_of_pool(self) -> int | None:
        """The number of baseline seeds, where it is too small for a pool; else None."""
        if self.pool_seeds is None or self.baseline_from:
            return None
        flown = len({*self.pool_seeds, *(self.seeds or ONE_SEED)})
        return flown if flown < LEAST else None


@dataclass(frozen=True)
class PlannedRun:
    """A request that was read and checked; nothing is written yet.

    Attributes:
        study: the study, with the grid of the campaign.
        request: what was asked for.
        chosen: the test cases.
        plan: the flights.
        others: baselines of the campaign that lends them.
    """

    study: Study
    request: Request
    chosen: Choice
    plan: Plan
    others: tuple[Outcome, ...]


@dataclass(frozen=True)
class FlownRun:
    """A run that ended.

    Attributes:
        planned: what was to be flown.
        report: the outcomes.
        looks: the looks of a sequential run.
    """

    planned: PlannedRun
    report: Report
    looks: tuple[Look, ...] = ()

    @cached_property
    def rulings(self) -> Rulings:
        """What each flight of the run shows beside its baseline."""
        return rulings_of(self.report.outcomes)


def planned_run(study: Study, request: Request) -> PlannedRun:
    """Read a request into a plan, and check the study in the situations of the plan.

    Raises:
        InputError: the request names something that the study lacks, contradicts itself or asks for no flight, or parts
            of the study contradict each other.
    """
    how, place = request.choose, OPTION
    if how is None:
        how = ALL if request.situations else study.grid.choose
        place = study.grid.chosen_at or place
    if request.sequential:
        _refuse_with_looks(request, how)
    pool = study.grid.select(request.situations)
    seeds = request.seeds or ONE_SEED
    chosen = choose_situations(how, pool, seeds, request.choose_seed, study.space, place)
    study.check(chosen.situations)
    mutants = parse_mutants(study, request.mutants)
    plan = plan_draws(chosen.draws, mutants, canary(study)).with_pool(request.pool_seeds)
    if request.shard is not None:
        plan = plan.shard(*request.shard)
        if not plan.baselines:
            shard = "{}/{}".format(*request.shard)
            raise InputError(f"--shard={shard!r} has no flights: there are fewer situations and seeds than shards")
    keys = [situation.key for situation in chosen.situations]
    others = borrowed(study, request.baseline_from, keys) if request.baseline_from else ()
    return PlannedRun(study, request, chosen, plan, others)


def fly(planned: PlannedRun, folder: Path, options: RunOptions, *, progress: Progress) -> FlownRun:
    """Fly what the campaign in `folder` lacks of a planned run; the same call resumes a run that was interrupted.

    Args:
        planned: the run.
        folder: folder of the campaign; a missing folder is created.
        options: options that change no outcome; part and budget are those of the request.
        progress: progress display.

    Raises:
        GateError: a gate failed.
        InputError: the folder or the store cannot be written.
        Interrupted: the user stopped the run.
    """
    study, asked = planned.study, planned.request
    options = replace(options, part=asked.shard is not None, budget_s=asked.budget_s)
    remember_choice(study, folder, planned.chosen)
    if asked.sequential:
        report, looks = run_looks(study, planned.plan, folder, options, others=planned.others, progress=progress)
        return FlownRun(planned, report, looks)
    return FlownRun(planned, run(study, planned.plan, folder, options, progress=progress))


def _refuse_with_looks(request: Request, how: str) -> None:
    """Refuse what contradicts a sequential run, whose looks have their own seeds.

    Raises:
        InputError: the message names the first contradiction.
    """
    values: Sequence[tuple[str, object]] = (
        ("seeds", request.seeds and f"{request.seeds[0]}-{request.seeds[-1]}"),
        ("budget", request.budget_s and f"{request.budget_s:g}s"),
        ("shard", request.shard and "{}/{}".format(*request.shard)),
        ("choose", how if how.startswith("draws") else None),  # a draw has one seed, a look several
    )
    for name, value in values:
        if value is not None:
            raise InputError(f"--sequential and --{name}={value} do not go together; leave one out")
