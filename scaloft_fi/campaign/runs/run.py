"""A run: fly the flights of the plan that the store lacks, save every outcome when it arrives, check the gates.

The published log counts test cases; here a test case is a pair of situation and seed, for any subject.
"""

from __future__ import annotations

import math
import re
import time
from collections import Counter
from collections.abc import Callable, Hashable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import InitVar, dataclass, field, replace
from functools import partial
from itertools import pairwise
from pathlib import Path
from threading import Event
from typing import Any, TypeVar

from scaloft_fi.analysis.detection import LEAST, Spending
from scaloft_fi.analysis.roster import Roster
from scaloft_fi.campaign.flights.fly import Batch, Flight, Flyer
from scaloft_fi.campaign.flights.physics import flyer_of
from scaloft_fi.campaign.plan import Plan, alone, canary_flight, in_runs, infects, together
from scaloft_fi.campaign.progress import Progress, Reporter
from scaloft_fi.campaign.runs import gates
from scaloft_fi.campaign.runs.gates import ONE_PROCESS, RunOptions, prove_platform
from scaloft_fi.campaign.store import archive, held
from scaloft_fi.campaign.store.held import Keys, counting_flights, current_in, flight_named
from scaloft_fi.campaign.store.platforms import Pair, Platforms, claim, fingerprint
from scaloft_fi.campaign.store.store import Store, read_store
from scaloft_fi.campaign.workers import Interrupted, Local, Workers, interruptible
from scaloft_fi.errors import GateError, InputError
from scaloft_fi.judge.outcome import Outcome, Violation
from scaloft_fi.judge.requirement import Kind
from scaloft_fi.judge.space import Space
from scaloft_fi.mutants.mutant import PLACEBO
from scaloft_fi.output import json_text, write_own
from scaloft_fi.registry import grouped
from scaloft_fi.sim.situation import Situation
from scaloft_fi.sources import PACKAGE
from scaloft_fi.streams import key_words
from scaloft_fi.study import Study

Item = TypeVar("Item")

UNITS_S = (3600, 60, 1)
GROUP = 16
"""Approximate number of mutants that share one flight of a baseline; each group flies the baseline again."""


def budget_s(text: str) -> float:
    """Parse a duration such as `1h30m` [s].

    >>> [budget_s(text) for text in ("90s", "10m", "1h30m")]
    [90.0, 600.0, 5400.0]

    Raises:
        InputError: the text is no duration above 0.
    """
    match = re.fullmatch(r"(?:(\d{1,6})h)?(?:(\d{1,6})m)?(?:(\d{1,6})s)?", text.strip())
    parts = match.groups(default="0") if match else ("0", "0", "0")
    total_s = sum(int(part) * unit for part, unit in zip(parts, UNITS_S, strict=True))
    if not total_s:
        raise InputError(f"--budget={text!r} must be a time above 0 with its unit, such as 90s, 10m or 1h30m")
    return float(total_s)


class Budget:
    """A budget of wall time; its clock starts at its creation.

    Args:
        seconds: size of the budget [s]; None = unlimited.
        clock: monotonic wall clock [s].
    """

    def __init__(self, seconds: float | None, clock: Callable[[], float] = time.monotonic) -> None:
        self._end_s = None if seconds is None else clock() + seconds
        self._clock = clock

    @property
    def left_s(self) -> float:
        """Remaining time [s]; infinite for an unlimited budget."""
        return math.inf if self._end_s is None else max(0.0, self._end_s - self._clock())

    def while_it_lasts(
        self, batches: Iterable[Batch], needs_s: Callable[[Batch], float] = lambda _task: 0.0
    ) -> Iterator[Batch]:
        """Yield `batches` until the budget is used up; a batch that was handed out is flown to its end.

        A batch that stops in the middle would keep the mutants that are flown first, which infect early.  The first
        batch that is not expected to end in time ends the run; a shorter batch instead would favour short flights.

        Args:
            batches: batches in the order of flight.
            needs_s: expected wall time of a batch [s].
        """
        for batch in batches:
            if self.left_s <= needs_s(batch):
                return
            yield batch


def fair_order(
    study: Study, planned: Plan, arrange: Callable[[Sequence[Flight]], Iterable[Batch]], missing: Iterable[Flight]
) -> Iterator[Batch]:
    """Batches of the `missing` flights of a plan in random, stratified order.

    Each turn draws every pair of situation and seed once, in random order, each with one random group of mutants in
    which every parameter has its share; the turns end when every pair has had every group.  So at any time every
    planned flight of a mutant had the same chance, and the numbers of draws of two situations, or of two groups, differ
    by at most one.  The baseline and PLACEBO are flown at the first draw of their situation.  The order depends on the
    study only, so a run with another budget continues where the last run ended.
    """
    seed = study.inputs["sim"], study.inputs["requirements"]
    wanted = set(missing)
    draws = interleaved(
        planned.baselines,
        lambda flight: flight.situation.key,
        lambda flight: f"{flight.situation.key}/{flight.seed}",
        (*seed, "draws"),
    )
    mutants = list(dict.fromkeys(f.mutant for f in planned.mutants if f.mutant is not None and f.mutant != PLACEBO))
    order = interleaved(mutants, lambda mutant: mutant.parameter, lambda mutant: mutant.id, (*seed, "mutants"))
    count = max(1, round(len(order) / GROUP))
    bounds = [len(order) * group // count for group in range(count + 1)]
    groups = [order[low:high] for low, high in pairwise(bounds)]
    for turn in range(len(groups)):
        for place, draw in enumerate(draws):
            members = (*([None, PLACEBO] if turn == 0 else []), *groups[(place + turn) % len(groups)])
            unit = [Flight(member, draw.situation, draw.seed) for member in members]
            yield from arrange([flight for flight in unit if flight in wanted])


def interleaved(
    items: Sequence[Item], stratum: Callable[[Item], Hashable], name: Callable[[Item], str], seed: Sequence[str]
) -> list[Item]:
    """The items in a random order in which every stretch has its share of each stratum, up to one item.

    Systematic sampling: the n members of a stratum, shuffled, get the positions (i + u) / n with one random u.

    Args:
        items: the items, each once.
        stratum: stratum of an item.
        name: unique name of an item.
        seed: name of the random stream; the order of `items` does not matter.
    """

    def chance(*parts: str) -> float:
        return key_words(*seed, *parts)[0] / 2**64

    shuffled = sorted(items, key=lambda item: (chance("shuffle", name(item)), name(item)))
    placed = [
        ((index + chance("offset", str(key))) / len(members), chance("tie", name(item)), item)
        for key, members in grouped(shuffled, stratum).items()
        for index, item in enumerate(members)
    ]
    return [item for _, _, item in sorted(placed, key=lambda entry: entry[:2])]


def mission_log(
    outcomes: Iterable[Outcome], roster: Roster, space: Space, planned: int | None = None
) -> dict[str, Any]:
    """The log as plain JSON values.

    Args:
        outcomes: outcomes of a campaign.
        roster: gives the order of the mutants.
        space: the grid.
        planned: number of planned test cases; None = size of the grid times the flown seeds.
    """
    valid = [outcome for outcome in outcomes if not outcome.invalid]
    listed = sorted(valid, key=lambda o: (roster.rank(o.mutant), space.rank(o.situation), o.seed))
    draws = sorted({(o.situation, o.seed) for o in listed}, key=lambda draw: (space.rank(draw[0]), draw[1]))
    situations = {situation for situation, _ in draws}
    seeds = {seed for _, seed in draws}
    safety = [_entry(o, v) for o in listed for v in o.violations if v.kind is Kind.SAFETY]
    return {
        "total_test_cases": planned if planned is not None else len(space.points) * max(1, len(seeds)),
        "generated_test_cases": len(draws),
        "generated_situations": [_situation(space, key, seed) for key, seed in draws],
        "safety_violation_ids": [entry["id"] for entry in safety],
        "violations": safety,
        "operability_violations": [_entry(o, v) for o in listed for v in o.violations if v.kind is Kind.OPERABILITY],
        "coverage": {
            "distinct_situations": {
                "part": len({space.point[key] for key in situations if key in space.point}),
                "whole": len(space.points),
            },
            "draws": len(draws),
        },
    }


def _situation(space: Space, key: str, seed: int) -> dict[str, Any]:
    """`type` and `parameters` as in the published log: the values that are not benign, and the value on each axis."""
    point = space.point.get(key, ())
    words = space.words_of(key) if point else ()
    unusual = [words[axis] for axis, value in enumerate(point) if value != space.values[axis][0]]
    drawn = Situation.parse(key) if point and key not in space.order else None
    parameters = dict(zip(space.axes, point, strict=False)) | (dict(drawn.numbers) if drawn else {})
    return {"type": "+".join(unusual) or "none", "parameters": parameters, "situation": key, "seed": seed}


def _entry(outcome: Outcome, violation: Violation) -> dict[str, Any]:
    return {
        # unique, because a flight has one first violation of a requirement; `replay` takes what follows the colon
        "id": f"{violation.requirement}:{outcome.name}",
        "requirement": violation.requirement,
        "t_s": violation.t_s,
        "position": [violation.x, violation.y, violation.z],
        "struck": violation.struck,
        "mutant": outcome.mutant,
        "situation": outcome.situation,
        "seed": outcome.seed,
    }


Arrange = Callable[[Sequence[Flight]], Iterable[Batch]]
"""Arranges flights in batches, in the order in which the workers get them."""


@dataclass(eq=False)
class Run:
    """Flies the flights that the store lacks.

    Args:
        study: the study.
        folder: folder of the campaign.
        store: store of the campaign.
        workers: workers that fly.
        progress: progress display.
        options: options of the run.
        stopped: whether the user asked to stop.

    Attributes:
        flown: number of flown flights that the store lacked.
        repeats: outcomes of repeated flights.
        reporter: reports progress to the user.
    """

    study: Study
    folder: Path
    store: Store
    workers: Workers
    progress: InitVar[Progress]
    options: RunOptions
    stopped: Callable[[], bool]
    flown: int = 0
    repeats: list[Outcome] = field(default_factory=list)

    def __post_init__(self, progress: Progress) -> None:
        log, warns = self.folder / archive.LOG_NAME, self.options.warnings
        self.reporter = Reporter(self.study, progress, log, share=self._shares, warnings=warns)
        self._keys, self._ours, self._platforms = Keys(self.study), fingerprint(), Platforms(self.store)
        self._claimed, self._pools = set[Pair](), dict[Situation, tuple[Flight, ...]]()
        self._untested, self._needed, self._spared = Counter[Situation](), 0, 0

    @property
    def spending(self) -> Spending:
        """The spending of alpha on the mutants of the campaign."""
        return Spending(self.study.alpha, held.grown_in(self.store))

    def prepare(self) -> None:
        """Prepare this process for flights; processes that are forked from it inherit that."""
        self.workers.ready()

    def plan(self, flights: Iterable[Flight], *, canary: bool = False) -> None:
        """Record planned flights in the store."""
        self.store.plan(self._keys.planned(flight, canary=canary) for flight in flights)

    def arrange(self, flights: Sequence[Flight], jobs: int | None = None) -> list[Batch]:
        """Arrange flights in batches, the longest first; with the option `share`, mutants with their baseline.

        Args:
            flights: the flights.
            jobs: number of processes; None = those of the run.
        """
        if self._shares:
            return together(flights, self.weight_s, jobs or self.workers.jobs)
        return in_runs(flights, self.study.runner)

    @property
    def _shares(self) -> bool:
        """Whether mutants fly with their baseline, which needs a stack that forks and repeats its bits."""
        stack = self.study.stack
        return self.options.share and self.study.command is None and stack.forks and stack.deterministic

    def fly(self, flights: Iterable[Flight], arrange: Arrange | None = None) -> None:
        """Fly the `flights` that the store lacks, and the baselines that they share.

        Where the store has flights of another platform in the same situation and seed, they are flown again too.

        Args:
            flights: the requested flights.
            arrange: arranges the flights in batches; `self.arrange` when None.
        """
        missing = self._missing(flights)
        if not missing:
            return
        missing |= self._beside(missing.values())
        self.reporter.expect(missing.values())
        draws = {Flight(None, flight.situation, flight.seed): None for flight in missing.values()}
        keys = {flight.name: key for key, flight in missing.items()}
        asked = {flight.name: flight for flight in (*draws, *missing.values())}
        due = set(keys)
        for outcome in self._outcomes((arrange or self.arrange)(tuple(missing.values()))):
            pair = outcome.situation, outcome.seed
            if not outcome.invalid and self._foreign(pair):  # this platform becomes that of the pair
                claim(self.store, [pair], self._ours)
                self._claimed.add(pair)
            news = outcome.name in keys and self.store.put(keys[outcome.name], outcome)
            if outcome.name in due:
                due.remove(outcome.name)
                self.flown += 1
            elif not news:
                self.repeats.append(outcome)
            self.reporter.arrived(asked[outcome.name], outcome, news=news)
            self._ask_for_pool(asked[outcome.name], outcome)

    def announce_pool(self, planned: Plan) -> None:
        """Announce the baseline pool of each situation as soon as a mutant of the plan infects there."""
        needed, pools = set(planned.infected(self.outcomes(planned.mutants))), dict[Situation, tuple[Flight, ...]]()
        for flight in planned.baselines:
            pools.setdefault(flight.situation, self.missing(planned.pool(flight.situation, LEAST)))
        self.reporter.expect(flight for situation in needed for flight in pools.pop(situation))
        mutants = [flight for flight in planned.mutants if flight.mutant != PLACEBO and flight.situation in pools]
        self._untested = Counter(flight.situation for flight in self.missing(mutants))
        self._pools = {situation: pool for situation, pool in pools.items() if self._untested[situation]}
        self._needed, self._spared = len(needed), 0
        self._count_pools()

    def _ask_for_pool(self, flight: Flight, outcome: Outcome) -> None:
        """Announce the pool of a situation at its first infection; forget it when no mutant is left that could infect.

        The time left counts the other pools at the share of the situations that needed theirs so far.
        """
        situation = flight.situation
        if situation not in self._pools or flight.mutant in (None, PLACEBO):
            return
        self._untested[situation] -= 1
        if infects(outcome):
            self._needed += 1
            self.reporter.expect(self._pools.pop(situation))
        elif not self._untested[situation]:
            self._spared += 1
            del self._pools[situation]
        else:
            return
        self._count_pools()

    def _count_pools(self) -> None:
        share = (self._needed + 1) / (self._needed + self._spared + 1)
        self.reporter.maybe_s = share * sum(self.reporter.cost_s(one) for pool in self._pools.values() for one in pool)

    def repeat(self, flights: Sequence[Flight]) -> None:
        """Repeat the shortest of the stored `flights`, if this run flew any; a gate compares the digests."""
        missing = set(self.missing(flights))
        done = [flight for flight in flights if flight not in missing and not self._foreign(flight.pair)]
        if self.flown and done:
            self.repeats += self._outcomes(alone([min(done, key=self.weight_s)]))

    def altered_by_plugins(self, flights: Iterable[Flight]) -> list[list[Flight]]:
        """The stored `flights` that an operator of a plugin altered, by operator, most altered samples first."""
        modules = self.study.operator_modules.items()
        theirs = {name for name, module in modules if not module.startswith(f"{PACKAGE}.")}
        flown = {flight.name: flight for flight in flights if flight.mutant and flight.mutant.operator in theirs}
        altered = sorted(filter(infects, self.outcomes(flown.values())), key=lambda one: one.altered, reverse=True)
        again = (flown[outcome.name] for outcome in altered)
        return list(grouped(again, lambda flight: flight.mutant and flight.mutant.operator).values())

    def outcomes(self, flights: Iterable[Flight]) -> tuple[Outcome, ...]:
        """The stored outcomes of `flights`."""
        return tuple(self.store.outcomes(map(self._keys.key, flights)))

    def missing(self, flights: Iterable[Flight]) -> tuple[Flight, ...]:
        """The `flights` without a valid outcome in the store."""
        return tuple(self._missing(flights).values())

    def weight_s(self, flight: Flight) -> float:
        """Expected duration of a flight [s, simulated]."""
        return self.study.expected_s(flight.situation)

    def wall_s(self, batch: Batch) -> float:
        """Expected wall time of a batch in one process at the current rate [s]; 0 before the first outcome."""
        return self.reporter.wall_s(batch.flights) * self.workers.jobs

    def hold_gates(self, asked: Plan, outcomes: Sequence[Outcome], *, part: bool = False) -> None:
        """Check the gates on the outcomes of the plan `asked`; `part` when only a part of the plan was flown.

        Raises:
            GateError: a gate failed.
        """
        again = gates.differing(outcomes, self.repeats) if self.study.stack.deterministic else ()
        for one in again:
            held.remember_differed(self.store, self._keys.key(self._flight_of(one)), one)

        now, part = held.Now(self.study, self.store), part or self.options.part
        whole = {flight.situation.key for flight in asked.baselines} == self.study.space.point.keys()
        failed = gates.failed_gates(
            [now.whole(outcome) if gates.asks_for_track(outcome) else outcome for outcome in outcomes],
            self.study.roster,
            controls=None if whole else {asked.canary.id} if asked.canary else (),
            part=part,
            differed=held.differed_in(now),
            max_invalid=self.options.max_invalid,
            deterministic=self.study.stack.deterministic,
            spending=self.spending,
        )
        held.remember_allowed(self.store, self.options.max_invalid)
        told = f"gate failed: {'; '.join(failed)}" if failed else "" if part else gates.failed_in(now, self.folder)
        if told:
            raise GateError(told)

    def _flight_of(self, outcome: Outcome) -> Flight:
        return flight_named(self.study, outcome.mutant, outcome.situation, outcome.seed)

    def raise_if_stopped(self, saved: str) -> None:
        """Raise if the user asked to stop.

        Args:
            saved: subject and verb of the message, such as `3 flights are`.

        Raises:
            Interrupted: the user asked to stop; the message names the command that resumes.
        """
        if self.stopped():
            again = f"the same command resumes: {self.options.command}".removesuffix(": ")
            raise Interrupted(f"interrupted: {saved} saved in {self.folder}; {again}")

    def _outcomes(self, batches: Iterable[Batch]) -> Iterator[Outcome]:
        self.workers.ready()
        self.reporter.progress.start()
        return self.workers.map(batches)

    def _foreign(self, pair: Pair) -> bool:
        """Whether the flights of a pair are of another platform, or would be taken for such flights."""
        return pair not in self._claimed and not self._platforms.equal(self._platforms.of(pair), self._ours)

    def _beside(self, flights: Iterable[Flight]) -> dict[str, Flight]:
        """The stored flights of another platform in the situations and seeds of `flights`, by key."""
        pairs = {pair for pair in (flight.pair for flight in flights) if self._foreign(pair)}
        stored = counting_flights(self.study, self.store) if pairs else []
        again = {
            flown.key: flight_named(self.study, flown.mutant, flown.situation, flown.seed)
            for flown in stored
            if (flown.situation, flown.seed) in pairs
        }
        if again:
            self.reporter.progress.line(
                f"{len(again)} stored flights of another platform are flown again, because new flights of the same "
                "situation and seed must have a baseline of this platform"
            )
        return again

    def _missing(self, flights: Iterable[Flight]) -> dict[str, Flight]:
        """The flights without a valid outcome in the store, by key."""
        keyed = {self._keys.key(flight): flight for flight in flights}
        known = self.store.known(keyed)
        return {key: flight for key, flight in keyed.items() if key not in known}


@contextmanager
def opened(
    study: Study, folder: Path, options: RunOptions, *, progress: Progress, flyer: Flyer | None, first: Sequence[Flight]
) -> Iterator[Run]:
    """Open the campaign in `folder`; a missing folder is created.

    Args:
        study: the study.
        folder: folder of the campaign.
        options: options of the run.
        progress: progress display.
        flyer: flies; when None as `flyer_of` says.
        first: first requested flights.  If the store lacks any of them, the flyer is prepared before anything is
            written, so that a study that cannot be flown leaves no files.

    Raises:
        GateError: the platform has changed, and none of the stored flights could be flown again on it.
        InputError: the folder or the store cannot be written, or the study cannot be flown.
    """
    archive.promising(folder)
    executor = options.executor or Local(options.jobs)
    stopped = Event()
    flies = flyer or flyer_of(study)
    with executor.workers(study, flies, stop=stopped.is_set, say=progress.line) as workers:
        with read_store(folder / archive.STORE_NAME) as known:
            keys = set(map(Keys(study).key, first))
            all_flown = known is not None and known.known(keys) == keys
        if not all_flown:
            workers.ready()  # may take half a minute in compilers, which poll no flag: a signal ends it at once
        with interruptible(stopped), Store(archive.writable(folder) / archive.STORE_NAME, say=progress.line) as store:
            archive.remember_grid(store, study)
            prove_platform(
                study, store, workers, say=progress.line, stopped=stopped.is_set, same_platform=options.same_platform
            )
            yield Run(study, folder, store, workers, progress, options, stopped.is_set)
            store.confirm()


@dataclass(frozen=True)
class Report:
    """The result of a run.

    Attributes:
        outcomes: all outcomes of the plan.
        flown: number of flights that this run flew.
        left: flights of the plan without an outcome, because the run ended early.
        spending: the campaign's spending of alpha on its mutants.
        mixture: sentences about the platforms of the outcomes and a change of the study; empty for one, without any.
    """

    outcomes: tuple[Outcome, ...]
    flown: int
    left: tuple[Flight, ...] = ()
    spending: Spending = field(default_factory=Spending)
    mixture: str = ""


def run(
    study: Study,
    planned: Plan,
    folder: Path,
    options: RunOptions = ONE_PROCESS,
    *,
    progress: Progress,
    flyer: Flyer | None = None,
) -> Report:
    """Fly the missing flights of `planned`, save their outcomes, write the mission log, check the gates.

    Args:
        study: the study.
        planned: the plan.
        folder: folder of the campaign; a missing folder is created.
        options: options of the run.
        progress: progress display.
        flyer: flies; PyBullet when None.

    Raises:
        GateError: a gate failed.
        InputError: the folder or the store cannot be written.
        Interrupted: the user stopped the run.
    """
    budget = Budget(options.budget_s)
    with opened(study, folder, options, progress=progress, flyer=flyer, first=planned.known) as campaign:
        report = _fly(planned, campaign, budget)
        campaign.raise_if_stopped(f"{len(report.outcomes)} flights are")
        campaign.hold_gates(planned, report.outcomes, part=bool(report.left))
    return report


def _fly(planned: Plan, campaign: Run, budget: Budget) -> Report:
    """Fly until the plan is complete, the budget is used up or the user stops the run."""
    flights = planned.known
    held.remember_seeds(campaign.store, (flight.subject.id for flight in planned.mutants), planned.seeds)
    campaign.plan(flights)
    campaign.reporter.progress.most_s = lambda: budget.left_s
    campaign.reporter.progress.stored = lambda: (
        campaign.study,
        current_in(campaign.study, campaign.store),
        campaign.spending,
    )
    campaign.announce_pool(planned)
    one_by_one = partial(campaign.arrange, jobs=1)  # batches for one process
    campaign.fly(
        flights,
        lambda missing: budget.while_it_lasts(
            fair_order(campaign.study, planned, one_by_one, missing)
            if campaign.options.budget_s
            else campaign.arrange(missing),
            campaign.wall_s,
        ),
    )
    pool = fly_pool(planned, campaign, budget)
    done = {outcome.name for outcome in campaign.outcomes((*flights, *pool))}
    left = tuple(flight for flight in (*flights, *pool) if flight.name not in done)
    return finish(campaign, planned, (*flights, *pool), left)


def finish(campaign: Run, planned: Plan, flights: Sequence[Flight], left: tuple[Flight, ...] = ()) -> Report:
    """Fly the canary, unless flights are `left`, repeat flights and write the mission log; what a run ends with.

    A baseline is repeated, and of each operator that a plugin declares a flight that it altered.
    """
    canary = canary_flight(planned, campaign.outcomes(planned.baselines)) if not left else None
    if canary is not None:
        campaign.plan([canary], canary=True)
        campaign.fly([canary])
    for alike in (planned.baselines, *campaign.altered_by_plugins(planned.mutants)):
        campaign.repeat(alike)
    campaign.reporter.close()
    outcomes = campaign.outcomes((*flights, *([canary] if canary else [])))
    write_log(campaign.study, campaign.folder, current_in(campaign.study, campaign.store))
    mixture = "  ".join(filter(None, (Platforms(campaign.store).mixture(outcomes), changed_since(campaign.study))))
    return Report(outcomes, campaign.flown, left, campaign.spending, mixture)


def changed_since(study: Study) -> str:
    """A sentence about the parts of a study that differ from what it flew; empty where none does."""
    try:
        now = replace(study).inputs
    except InputError:  # a file is being written, or cannot be read any more
        now = {}
    if parts := [part for part, value in study.inputs.items() if now.get(part) != value]:
        return f"the study changed during the run ({', '.join(parts)}), so its flights do not count from now on"
    return ""


def fly_pool(planned: Plan, campaign: Run, budget: Budget) -> tuple[Flight, ...]:
    """Fly the baseline pool in the situations in which a mutant of the plan infects; returns its flights."""
    situations = planned.infected(campaign.outcomes(planned.mutants))
    pool = tuple(flight for situation in situations for flight in planned.pool(situation, LEAST))
    campaign.plan(pool)
    campaign.fly(pool, lambda missing: budget.while_it_lasts(campaign.arrange(missing), campaign.wall_s))
    return pool


def write_log(study: Study, folder: Path, outcomes: Sequence[Outcome]) -> None:
    """Write the campaign's mission log.

    Raises:
        InputError: the file cannot be written.
    """
    told = {"stack": study.stack.title, **mission_log(outcomes, study.roster, study.space)}
    text = json_text(told, indent=2)
    write_own(folder / archive.LOG_NAME, f"{text}\n".encode())
