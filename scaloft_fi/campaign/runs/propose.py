"""Fly what a proposal needs: logs of mutants and of the unmutated drone, a choice on some seeds, a test on fresh ones.

The store keeps no signals, so the flights are flown again.  The choice sees the first seeds.  Each chosen requirement
is then judged on seeds that neither the choice nor the campaign flew, by the score's own exact test: the mutant's
flights beside those of the unmutated drone, in the situations in which nine in ten of the latter hold it.  All that
were chosen share the level, so the chance that any is confirmed for a fault that does nothing is at most alpha.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Annotated

import numpy as np

from scaloft_fi.analysis.detection import Stratum, p_value, reaches
from scaloft_fi.analysis.proposal import Array, Candidates, Choice, choose
from scaloft_fi.analysis.roster import Ratio
from scaloft_fi.aside import foreign
from scaloft_fi.campaign.flights.fly import Flight, fly_log, reason_of
from scaloft_fi.campaign.flights.physics import Physics
from scaloft_fi.campaign.processes import PATIENCE_S, ProcessPool, Start, forked
from scaloft_fi.campaign.progress import Progress
from scaloft_fi.errors import InputError
from scaloft_fi.judge.outcome import BASELINE
from scaloft_fi.judge.requirement import Requirement, judge
from scaloft_fi.marks import About
from scaloft_fi.mutants.mutant import Mutant
from scaloft_fi.sim.log import belief_signals, truth_signals
from scaloft_fi.study import Study

LEAST = 3
"""Fewest flights of a mutant that have to pass the limit that is chosen."""


@dataclass(frozen=True)
class Task:
    """A flight, and the requirements that judge it; without any, its reaches are wanted."""

    flight: Flight
    requirements: tuple[Requirement, ...] = ()


@dataclass(frozen=True, eq=False)
class Told:
    """What a flight tells: its reaches or which requirements it violates, the digest of its log, why it failed."""

    flight: Flight
    reaches: Array | None = None
    violated: tuple[bool, ...] = ()
    digest: str = ""
    invalid: str = ""


@dataclass(frozen=True)
class Sought:
    """A subject that violates nothing, and the situations in which it changes samples.

    Attributes:
        id: its name.
        mutant: the mutant; None for the unmutated drone.
        situations: keys of the situations.
    """

    id: str
    mutant: Mutant | None
    situations: tuple[str, ...]

    def flights(self, study: Study, seeds: Sequence[int]) -> list[Flight]:
        """Its flights with these seeds."""
        return [Flight(self.mutant, study.grid.situation(key), seed) for key in self.situations for seed in seeds]


@dataclass(frozen=True)
class Seeds:
    """The seeds of the choice, then those of the test, each of the mutants and of the unmutated drone."""

    chosen: Sequence[int]
    chosen_pool: Sequence[int]
    fresh: Sequence[int]
    fresh_pool: Sequence[int]


@dataclass(frozen=True)
class Tested:
    """A requirement that shows a fault which violates none of the study's.

    Attributes:
        mutant: id of the fault.
        choice: the choice.
        requirement: as it is judged.
        shown: fresh flights of the mutant that violate it.
        alarms: fresh flights of the unmutated drone that violate it, in any situation.
        p: by the exact test on fresh seeds, after Bonferroni over the requirements tested.
        confirmed: whether p is at most alpha.
        firm: whether it is confirmed without any one seed too, of the mutant's or of the unmutated drone's.
        others: the other mutants that it shows on fresh seeds, each after Bonferroni over requirements and mutants.
    """

    KEYS = (
        "mutant", "requirement.title", "requirement.trigger", "requirement.text", "requirement.unit", "choice.margin",
        "shown", "alarms", "p", "confirmed", "firm", "others",
    )  # fmt: skip

    mutant: str
    choice: Choice
    requirement: Requirement
    shown: Ratio
    alarms: Ratio
    p: Annotated[float, About("p (0..1)")]
    confirmed: bool
    firm: bool
    others: tuple[str, ...]


@dataclass(frozen=True)
class Few:
    """A fault for which no requirement was sought.

    Attributes:
        mutant: id of the fault.
        traces: flights that leave a trace, of those flown for the choice.
        needed: how many of them a choice needs.
        seeds: seeds of the mutant that give as many, if as large a share of their flights leaves a trace.
    """

    mutant: str
    traces: Ratio
    needed: int
    seeds: int


@dataclass(frozen=True)
class Found:
    """The requirements that are missing.

    Attributes:
        tested: one for each fault for which a requirement separates its flights from the unmutated drone's, the
            confirmed ones first.
        same: faults of which every flight equals the unmutated drone's to the bit.
        apart: faults that leave a trace for which no requirement of the templates separates the flights.
        few: faults of which too few flights leave a trace, so that no requirement was sought.
    """

    KEYS = ("proposals=tested", "same", "none=apart", "few")

    tested: tuple[Tested, ...]
    same: tuple[str, ...]
    apart: tuple[str, ...]
    few: tuple[Few, ...]


def candidates_of(study: Study) -> Candidates:
    """The candidates over the log of a study."""
    world = study.grid.recorded
    signals = (*truth_signals(world.surfaces, world.signals), *belief_signals(study.stack.beliefs))
    definitions = dict(one for requirement in study.requirements for one in requirement.definitions)
    return Candidates(signals, tuple(definitions.items()), tuple(world.surfaces))


def propose(
    study: Study, sought: Sequence[Sought], seeds: Seeds, jobs: int, progress: Progress, start: Start = forked
) -> Found:
    """Choose a requirement for each subject on some seeds, and test it on fresh ones.

    Args:
        study: the study.
        sought: the subjects.
        seeds: of the flights.
        jobs: number of processes.
        progress: told of each flight.
        start: starts a process.

    Raises:
        InputError: the study cannot be flown, or a flight failed in the harness.
    """
    candidates = candidates_of(study)
    work = partial(_alone if study.stack.forks else _apart, study, candidates)
    progress.stage = "choosing"
    with ProcessPool(work, jobs, left=_left, lost=_lost, patience_s=PATIENCE_S, start=start) as pool:
        Physics().prepare(study, progress.line)
        fly = partial(_flown, pool, progress)
        unmutated = Sought(BASELINE, None, tuple(dict.fromkeys(key for one in sought for key in one.situations)))
        clean = unmutated.flights(study, seeds.chosen_pool)
        beside = unmutated.flights(study, seeds.chosen)
        own = {one.id: one.flights(study, seeds.chosen) for one in sought}
        first = fly([*clean, *beside, *(flight for flights in own.values() for flight in flights)], ())
        same_seed = {flight.pair: first[flight.name].digest for flight in beside}
        reached = np.array([first[name].reaches for name in dict.fromkeys(f.name for f in (*clean, *beside))])
        chosen, same, apart, few = dict[str, Choice](), list[str](), list[str](), list[Few]()
        for one in sought:
            told = [first[flight.name] for flight in own[one.id]]
            traces = [t.reaches for t in told if t.digest != same_seed.get(t.flight.pair)]
            if not traces:
                same.append(one.id)
            elif (count := len(traces)) < LEAST:
                few.append(Few(one.id, Ratio(count, len(told)), LEAST, -(-LEAST * len(seeds.chosen) // count)))
            elif choice := choose(candidates.listed, reached, np.array(traces), LEAST):
                chosen[one.id] = choice
            else:
                apart.append(one.id)
        progress.stage = "testing"
        requirements = {id_: choice.requirement(f"P-{id_}", candidates.definitions) for id_, choice in chosen.items()}
        own = {one.id: one.flights(study, seeds.fresh) for one in sought} if chosen else {}
        clean = unmutated.flights(study, seeds.fresh_pool) if chosen else []
        fresh = fly([*clean, *(f for flights in own.values() for f in flights)], tuple(requirements.values()))
    violated = {id_: [fresh[flight.name] for flight in flights] for id_, flights in own.items()}
    tested = _tested(chosen, requirements, violated, [fresh[flight.name] for flight in clean], study.alpha)
    return Found(tuple(sorted(tested, key=lambda one: not one.confirmed)), tuple(same), tuple(apart), tuple(few))


def _tested(
    chosen: Mapping[str, Choice],
    requirements: Mapping[str, Requirement],
    fresh: Mapping[str, Sequence[Told]],
    clean: Sequence[Told],
    alpha: float,
) -> Iterator[Tested]:
    """The chosen requirements on fresh flights, of each subject by its id and of the unmutated drone."""
    for number, (id_, choice) in enumerate(chosen.items()):

        def chance(subject: Sequence[Told], pool: Sequence[Told], number: int = number) -> float:
            return p_value(_strata(subject, pool, number))

        p = min(1.0, len(chosen) * chance(fresh[id_], clean))
        lacking = [
            *((_without(fresh[id_], seed), clean) for seed in {told.flight.seed for told in fresh[id_]}),
            *((fresh[id_], _without(clean, seed)) for seed in {told.flight.seed for told in clean}),
        ]
        others = (
            one
            for one, flown in fresh.items()
            if one != id_ and reaches(len(chosen) * len(fresh) * chance(flown, clean), alpha)
        )
        yield Tested(
            id_,
            choice,
            requirements[id_],
            Ratio(sum(told.violated[number] for told in fresh[id_]), len(fresh[id_])),
            Ratio(sum(told.violated[number] for told in clean), len(clean)),
            p,
            reaches(p, alpha),
            reaches(p, alpha) and all(reaches(len(chosen) * chance(*pair), alpha) for pair in lacking),
            tuple(others),
        )


def _without(flown: Iterable[Told], seed: int) -> list[Told]:
    return [told for told in flown if told.flight.seed != seed]


def _strata(subject: Iterable[Told], clean: Iterable[Told], number: int) -> Iterator[Stratum]:
    """The flights of a subject beside those of the unmutated drone, by situation."""
    counts: dict[str, list[int]] = {}
    for place, flown in enumerate((subject, clean)):
        for told in flown:
            row = counts.setdefault(told.flight.situation.key, [0, 0, 0, 0])
            row[2 * place] += told.violated[number]
            row[2 * place + 1] += 1
    return (Stratum(*row) for row in counts.values() if row[1])


def _flown(
    pool: ProcessPool[Task, Told], progress: Progress, flights: Iterable[Flight], requirements: tuple[Requirement, ...]
) -> Mapping[str, Told]:
    """Fly each flight once; by name."""
    tasks = [Task(flight, requirements) for flight in {flight.name: flight for flight in flights}.values()]
    progress.flights += len(tasks)
    found = {}
    for told in pool.map(tasks):
        if told.invalid:
            raise InputError(f"{told.flight.name} failed in the harness: {told.invalid}")
        progress.advance()
        found[told.flight.name] = told
    return found


def _alone(study: Study, candidates: Candidates, task: Task, report: Callable[[Told], None]) -> None:
    report(_told(study, candidates, task))


def _apart(study: Study, candidates: Candidates, task: Task, report: Callable[[Told], None]) -> None:
    """As `_alone`, in a process of its own, for a stack that leaves threads or processes behind."""
    work = partial(_alone, study, candidates)
    with ProcessPool(work, 1, left=_left, lost=_lost, patience_s=PATIENCE_S) as one:
        for told in one.map([task]):
            report(told)


def _told(study: Study, candidates: Candidates, task: Task) -> Told:
    try:
        log = fly_log(study, task.flight)
    except foreign() as error:  # a failure of the harness is told, whatever it is
        return Told(task.flight, invalid=reason_of(error))
    if task.requirements:
        return Told(task.flight, violated=tuple(judge(one, log).violated for one in task.requirements))
    return Told(task.flight, candidates.reaches(log.signals), digest=log.digest)


def _left(task: Task, results: Sequence[Told]) -> Task | None:
    return None if results else task


def _lost(task: Task, reason: str) -> list[Told]:
    return [Told(task.flight, invalid=reason)]
