"""Fly what a proposal needs: logs of mutants and of the unmutated drone, a choice on some seeds, a test on fresh ones.

The store keeps no signals, so the flights are flown again.  The choice sees the first seeds.  Each chosen requirement
is then judged on seeds that neither the choice nor the campaign flew, by the score's own exact test: the mutant's
flights beside those of the unmutated drone, in the situations in which nine in ten of the latter hold it.  All that
were chosen share the level, so the chance that any is confirmed for a fault that does nothing is at most alpha.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from scaloft_fi.analysis.detection import Stratum, p_value, reaches
from scaloft_fi.analysis.proposal import Array, Candidates, Choice, choose
from scaloft_fi.analysis.roster import Ratio
from scaloft_fi.campaign.flights.fly import Flight, fly_log, reason_of
from scaloft_fi.campaign.flights.physics import Physics
from scaloft_fi.campaign.processes import PATIENCE_S, ProcessPool
from scaloft_fi.campaign.progress import Progress
from scaloft_fi.errors import InputError
from scaloft_fi.judge.outcome import BASELINE
from scaloft_fi.judge.requirement import Requirement, judge
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
    """A mutant that violates nothing, and the situations in which it changes samples."""

    mutant: Mutant
    situations: tuple[str, ...]


@dataclass(frozen=True)
class Seeds:
    """The seeds of the choice, then those of the test, each of the mutants and of the unmutated drone."""

    chosen: Sequence[int]
    chosen_pool: Sequence[int]
    fresh: Sequence[int]
    fresh_pool: Sequence[int]


@dataclass(frozen=True)
class Tested:
    """A chosen requirement on fresh seeds.

    Attributes:
        mutant: id of the mutant that it was chosen for.
        choice: the choice.
        requirement: as it is judged.
        shown: fresh flights of the mutant that violate it, of all.
        alarms: fresh flights of the unmutated drone that violate it, in any situation, of all.
        p: chance of as many violations more if the mutant did nothing, times the number of requirements tested.
        confirmed: whether that is at most alpha.
        others: the other mutants that it shows in the same way, each by itself.
    """

    mutant: str
    choice: Choice
    requirement: Requirement
    shown: Ratio
    alarms: Ratio
    p: float
    confirmed: bool
    others: tuple[str, ...]


@dataclass(frozen=True)
class Found:
    """What a search for requirements found.

    Attributes:
        tested: the chosen requirements, in the order of the mutants.
        same: mutants of which every flight equals the unmutated drone's to the bit.
        apart: the other mutants for which no candidate separates the flights.
    """

    tested: tuple[Tested, ...]
    same: tuple[str, ...]
    apart: tuple[str, ...]


def candidates_of(study: Study) -> Candidates:
    """The candidates over the log of a study."""
    world = study.grid.recorded
    signals = (*truth_signals(world.surfaces, world.signals), *belief_signals(study.stack.beliefs))
    definitions = dict(one for requirement in study.requirements for one in requirement.definitions)
    return Candidates(signals, tuple(definitions.items()), tuple(world.surfaces))


def propose(study: Study, sought: Sequence[Sought], seeds: Seeds, jobs: int, progress: Progress) -> Found:
    """Choose a requirement for each mutant on some seeds, and test it on fresh ones.

    Args:
        study: the study.
        sought: the mutants.
        seeds: of the flights.
        jobs: number of processes.
        progress: told of each flight.

    Raises:
        InputError: the study cannot be flown, or a flight failed in the harness.
    """
    candidates = candidates_of(study)
    work = partial(_work, study, candidates)
    progress.stage = "choosing"
    with ProcessPool(work, jobs, left=_left, lost=_lost, patience_s=PATIENCE_S) as pool:
        Physics().prepare(study, progress.line)
        fly = partial(_flown, study, pool, progress)
        first = fly(sought, seeds.chosen, seeds.chosen_pool, ())
        chosen, same, apart = dict[str, Choice](), list[str](), list[str]()
        for one in sought:
            clean = [
                told.reaches
                for (mutant, _, _), told in first.items()
                if mutant == BASELINE and told.reaches is not None
            ]
            traces = [
                told.reaches
                for (mutant, key, seed), told in first.items()
                if mutant == one.mutant.id
                and told.reaches is not None
                and told.digest != first[BASELINE, key, seed].digest
            ]
            choice = (
                choose(candidates.listed, np.array(clean), np.array(traces), LEAST) if len(traces) >= LEAST else None
            )
            if choice is not None:
                chosen[one.mutant.id] = choice
            else:
                (apart if traces else same).append(one.mutant.id)
        progress.stage = "testing"
        requirements = {id_: choice.requirement(f"P-{id_}", candidates.definitions) for id_, choice in chosen.items()}
        fresh = fly(sought, seeds.fresh, seeds.fresh_pool, tuple(requirements.values())) if chosen else {}
    tested = _tested(chosen, requirements, fresh, study.alpha)
    return Found(tuple(tested), tuple(same), tuple(apart))


_Flown = Mapping[tuple[str, str, int], Told]


def _tested(
    chosen: Mapping[str, Choice], requirements: Mapping[str, Requirement], fresh: _Flown, alpha: float
) -> Iterator[Tested]:
    mutants = list(dict.fromkeys(mutant for mutant, _, _ in fresh if mutant != BASELINE))
    for number, (id_, choice) in enumerate(chosen.items()):
        clean = [told.violated[number] for (mutant, _, _), told in fresh.items() if mutant == BASELINE]
        own = [told.violated[number] for (mutant, _, _), told in fresh.items() if mutant == id_]
        chances = {mutant: p_value(_strata(mutant, number, fresh)) for mutant in mutants}
        p = min(1.0, len(chosen) * chances[id_])
        others = tuple(
            one for one in mutants if one != id_ and reaches(len(chosen) * len(mutants) * chances[one], alpha)
        )
        yield Tested(
            id_,
            choice,
            requirements[id_],
            Ratio(sum(own), len(own)),
            Ratio(sum(clean), len(clean)),
            p,
            reaches(p, alpha),
            others,
        )


def _strata(mutant: str, number: int, fresh: _Flown) -> Iterator[Stratum]:
    """The flights of a mutant beside those of the unmutated drone, by situation."""
    for key in dict.fromkeys(key for one, key, _ in fresh if one == mutant):
        counts = []
        for subject in (mutant, BASELINE):
            flown = [t.violated[number] for (one, at, _), t in fresh.items() if one == subject and at == key]
            counts += [sum(flown), len(flown)]
        yield Stratum(*counts)


def _flown(
    study: Study,
    pool: ProcessPool[Task, Told],
    progress: Progress,
    sought: Sequence[Sought],
    seeds: Collection[int],
    pool_seeds: Collection[int],
    requirements: tuple[Requirement, ...],
) -> _Flown:
    """Fly the mutants and the unmutated drone; each of the mutant's flights has its own baseline in the first stage."""
    situations = list(dict.fromkeys(key for one in sought for key in one.situations))
    own = set() if requirements else set(seeds)
    flights = [Flight(None, study.grid.situation(key), s) for key in situations for s in sorted({*pool_seeds, *own})]
    flights += [
        Flight(one.mutant, study.grid.situation(key), s) for one in sought for key in one.situations for s in seeds
    ]
    progress.flights += len(flights)
    found: dict[tuple[str, str, int], Told] = {}
    for told in pool.map(Task(flight, requirements) for flight in flights):
        if told.invalid:
            raise InputError(f"{told.flight.name} failed in the harness: {told.invalid}")
        progress.advance()
        found[told.flight.subject.id, told.flight.situation.key, told.flight.seed] = told
    names = [(flight.subject.id, flight.situation.key, flight.seed) for flight in flights]
    return {name: found[name] for name in names}


def _work(study: Study, candidates: Candidates, task: Task, report: Callable[[Told], None]) -> None:
    if study.stack.forks:
        report(_told(study, candidates, task))
        return
    work = partial(_alone, study, candidates)
    with ProcessPool(work, 1, left=_left, lost=_lost, patience_s=PATIENCE_S) as apart:
        for told in apart.map([task]):
            report(told)


def _alone(study: Study, candidates: Candidates, task: Task, report: Callable[[Told], None]) -> None:
    report(_told(study, candidates, task))


def _told(study: Study, candidates: Candidates, task: Task) -> Told:
    try:
        log = fly_log(study, task.flight)
    except Exception as error:  # noqa: BLE001 - a failure of the harness is told, whatever it is
        return Told(task.flight, invalid=reason_of(error))
    if task.requirements:
        return Told(task.flight, violated=tuple(judge(one, log).violated for one in task.requirements))
    return Told(task.flight, candidates.reaches(log.signals), digest=log.digest)


def _left(task: Task, results: Sequence[Told]) -> Task | None:
    return None if results else task


def _lost(task: Task, reason: str) -> list[Told]:
    return [Told(task.flight, invalid=reason)]
