"""A run: what the store lacks of the plan is flown, every outcome is saved as it comes, the gates are held."""

from __future__ import annotations

import signal
import threading
import time
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import FrameType

from scaloft_fi.campaign import gates
from scaloft_fi.campaign.fly import Flyer, Physics, Worker, left_of, lost
from scaloft_fi.campaign.folder import LOG_NAME, STORE_NAME, promising, writable
from scaloft_fi.campaign.fork import CAN_FORK
from scaloft_fi.campaign.held import held_in
from scaloft_fi.campaign.key import flight_key
from scaloft_fi.campaign.plan import Flight, Plan, canary_flight
from scaloft_fi.campaign.pool import Pool
from scaloft_fi.campaign.progress import Progress
from scaloft_fi.campaign.task import Task, alone, together
from scaloft_fi.errors import InputError, ScaloftError
from scaloft_fi.results.fingerprint import differences, fingerprint
from scaloft_fi.results.mission_log import mission_log, to_json, violation_line
from scaloft_fi.results.outcome import Outcome
from scaloft_fi.results.requirement import Kind
from scaloft_fi.results.store import Planned, Store
from scaloft_fi.study import Study

ECHO_S = 1.0
"""A second signal within this time is the first one's echo: a terminal and a wrapper may both pass it on [s, wall]."""


class Interrupted(ScaloftError):  # noqa: N818 - an event, not an error
    """The user stopped the run; everything flown is saved."""

    exit_code = 130


@dataclass(frozen=True)
class Report:
    """What a run knows when it ends: the outcomes of the whole plan, how many of them it flew itself."""

    outcomes: tuple[Outcome, ...]
    flown: int


def run(
    study: Study,
    planned: Plan,
    folder: Path,
    *,
    jobs: int,
    progress: Progress,
    share: bool = CAN_FORK,
    shard: bool = False,
    flyer: Flyer | None = None,
) -> Report:
    """Fly what is missing of `planned`, save it, write the mission log, hold the gates.

    Args:
        study: what is flown.
        planned: which flights.
        folder: of the campaign; made when it does not exist.
        jobs: number of worker processes.
        progress: what a person sees meanwhile.
        share: whether mutants are flown only from where they leave their baseline; nothing that is saved depends on it.
        shard: whether `planned` is part of a run that others fly the rest of; the gates that need all of it are theirs
            who merge it.
        flyer: what flies; PyBullet when None.

    Raises:
        GateError: a gate failed.
        InputError: the folder or the store cannot be written.
        Interrupted: the user stopped it.
    """
    promising(folder)
    flyer = flyer or Physics()
    with _interruptible() as stopped:
        if not _all_flown(study, planned, folder / STORE_NAME):
            flyer.prepare(study, progress.line)
        with Store(writable(folder) / STORE_NAME) as store:
            _remember_platform(store, progress)
            pool = Pool(Worker(study, flyer), jobs, left=left_of, lost=lost, stop=stopped)
            crew = _Crew(study, store, pool, progress, jobs if share else 0)
            report = _fly(study, planned, folder, crew)
    if stopped():
        saved = f"{len(report.outcomes)} of {planned.flights} flights are saved in {folder}"
        raise Interrupted(f"interrupted: {saved}; the same command resumes")
    whole_grid = {flight.situation.key for flight in planned.baselines} == study.space.point.keys()
    judged = planned.canary.id if planned.canary else None
    gates.check(report.outcomes, study.roster, canary=judged, whole_grid=whole_grid, part=shard, repeats=crew.repeats)
    return report


def _fly(study: Study, planned: Plan, folder: Path, crew: _Crew) -> Report:
    """Fly until all is flown or the user stops it; returns what the plan has now."""
    crew.expect([*planned.baselines, *planned.mutants], canaries=int(planned.canary is not None))
    crew.plan([*planned.baselines, *planned.mutants])
    crew.fly([*planned.baselines, *planned.mutants])
    canary = canary_flight(planned, crew.outcomes(planned.baselines))
    if canary is not None:
        crew.plan([canary], canary=True)
        crew.fly([canary])
    crew.repeat(planned.baselines)
    crew.progress.close()
    outcomes = crew.outcomes((*planned.baselines, *planned.mutants, *([canary] if canary else [])))
    write_log(study, folder, held_in(study, crew.store, folder).current)
    return Report(outcomes, crew.flown)


def _all_flown(study: Study, planned: Plan, path: Path) -> bool:
    """Whether the store at `path`, which need not exist, has everything but the canary."""
    if not path.is_file():
        return False
    with Store(path, create=False) as store:
        keys = {flight_key(study, flight) for flight in (*planned.baselines, *planned.mutants)}
        return store.known(keys) == keys


class _Crew:
    """Flies what the store lacks.

    Args:
        study: what is flown.
        store: what is flown already.
        pool: who flies.
        progress: what a person sees.
        sharing: for how many processes the flights that share a baseline's beginning are cut into tasks; 0 = each is
            flown whole.

    Attributes:
        flown: how many flights are home that the store lacked.
        repeats: outcomes of flights that it had.
    """

    def __init__(self, study: Study, store: Store, pool: Pool[Task, Outcome], progress: Progress, sharing: int) -> None:
        self.store, self.progress = store, progress
        self._study, self._pool, self._sharing = study, pool, sharing
        self.flown = 0
        self.repeats: list[Outcome] = []

    def expect(self, flights: Sequence[Flight], canaries: int) -> None:
        """Tell the progress what is to come; a canary is only counted when anything else is to be flown."""
        missing = self._missing(flights)
        expected_s = sum(map(self._weight_s, missing.values()))
        self.progress.expect(len(missing) + canaries * bool(missing), expected_s)

    def plan(self, flights: Iterable[Flight], *, canary: bool = False) -> None:
        """Write down what is to be flown."""
        self.store.plan(
            Planned(flight_key(self._study, flight), flight.subject.id, flight.situation.key, flight.seed, canary)
            for flight in flights
        )

    def fly(self, flights: Iterable[Flight]) -> None:
        """Fly those of `flights` that the store lacks, and the baselines that they share."""
        missing = self._missing(flights)
        keys = {flight.name: key for key, flight in missing.items()}
        due = {flight.name: flight for flight in missing.values()}
        wanted = tuple(missing.values())
        tasks = together(wanted, self._weight_s, self._sharing) if self._sharing else alone(wanted)
        for outcome in self._pool.map(tasks):
            first = due.pop(outcome.name, None)
            if outcome.name in keys and self.store.put(keys[outcome.name], outcome):
                for line in _warnings(outcome):
                    self.progress.line(line)
            elif first is None:
                self.repeats.append(outcome)
            if first is not None:
                self.flown += 1
                self.progress.advance(self._weight_s(first))

    def repeat(self, flights: Sequence[Flight]) -> None:
        """The shortest of `flights` again, when anything was flown at all: it must be the first one's twin."""
        if self.flown and flights:
            self.repeats += self._pool.map(alone([min(flights, key=self._weight_s)]))

    def outcomes(self, flights: Iterable[Flight]) -> tuple[Outcome, ...]:
        """What the store has of `flights`."""
        return tuple(self.store.outcomes(flight_key(self._study, flight) for flight in flights))

    def _missing(self, flights: Iterable[Flight]) -> dict[str, Flight]:
        """By key, those of `flights` of which the store has no outcome that counts."""
        keyed = {flight_key(self._study, flight): flight for flight in flights}
        known = self.store.known(keyed)
        return {key: flight for key, flight in keyed.items() if key not in known}

    def _weight_s(self, flight: Flight) -> float:
        return self._study.expected_s(flight.situation)


def _warnings(outcome: Outcome) -> Iterator[str]:
    if outcome.invalid:
        yield f"warning: invalid, not counted: {outcome.name}: {outcome.invalid}"
    for violation in outcome.violations:
        if violation.kind is not Kind.REPORTED:
            yield f"warning: {violation_line(outcome, violation)}"


def _remember_platform(store: Store, progress: Progress) -> None:
    """Keep the platform of the campaign's first flight, and say when this one is another: its bits may differ."""
    ours, theirs = fingerprint(), store.meta()
    if theirs and (changed := differences(ours, theirs)):
        progress.line(f"warning: the campaign began on another platform, digests may differ: {', '.join(changed)}")
    store.set_meta(ours)


def write_log(study: Study, folder: Path, outcomes: Sequence[Outcome]) -> None:
    """Write the campaign's mission log.

    Raises:
        InputError: it cannot be written.
    """
    path = folder / LOG_NAME
    try:
        path.write_text(to_json(mission_log(outcomes, study.roster, study.space)), encoding="utf-8")
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {error.strerror}") from error


@contextmanager
def _interruptible() -> Iterator[_Flag]:
    """While it lasts, the first Ctrl-C (or SIGTERM) asks to stop, the second stops at once."""
    flag = _Flag()
    if threading.current_thread() is not threading.main_thread():  # only the main thread hears of signals
        yield flag
        return
    before = {number: signal.signal(number, flag.raise_it) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield flag
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


class _Flag:
    """Whether the user asked to stop."""

    def __init__(self) -> None:
        self._since_s: float | None = None

    def __call__(self) -> bool:
        return self._since_s is not None

    def raise_it(self, number: int, frame: FrameType | None) -> None:
        now_s = time.monotonic()
        if self._since_s is None:
            self._since_s = now_s
        elif now_s - self._since_s > ECHO_S:
            raise KeyboardInterrupt
