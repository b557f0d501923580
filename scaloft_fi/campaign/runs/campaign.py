"""An open campaign: it flies the flights that the store lacks, and saves every outcome when it arrives."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from scaloft_fi.analysis.pool import LEAST
from scaloft_fi.campaign.flights.commanded import Commanded
from scaloft_fi.campaign.flights.physics import Physics
from scaloft_fi.campaign.flights.worker import Flyer
from scaloft_fi.campaign.plan.arrange import alone, together
from scaloft_fi.campaign.plan.batch import Batch
from scaloft_fi.campaign.plan.flight import Flight
from scaloft_fi.campaign.plan.plan import Plan, infects
from scaloft_fi.campaign.progress.progress import Progress
from scaloft_fi.campaign.progress.reporter import Reporter
from scaloft_fi.campaign.runs import gates
from scaloft_fi.campaign.runs.options import RunOptions
from scaloft_fi.campaign.runs.platform import prove_platform
from scaloft_fi.campaign.runs.spending import spending_of
from scaloft_fi.campaign.store.fingerprint import fingerprint
from scaloft_fi.campaign.store.flown_grid import remember_grid
from scaloft_fi.campaign.store.folder import LOG_NAME, STORE_NAME, promising, writable
from scaloft_fi.campaign.store.held import counting_flights, flight_named
from scaloft_fi.campaign.store.key import Keys
from scaloft_fi.campaign.store.platforms import Pair, Platforms, claim
from scaloft_fi.campaign.store.store import EmptyError, Store
from scaloft_fi.campaign.workers.executor import Workers
from scaloft_fi.campaign.workers.interrupt import Flag, Interrupted, interruptible
from scaloft_fi.campaign.workers.local import Local
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.study import Study

if TYPE_CHECKING:
    from scaloft_fi.sim.situation import Situation

Arrange = Callable[[Sequence[Flight]], Iterable[Batch]]
"""Arranges flights in batches, in the order in which the workers get them."""


class Campaign:
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

    def __init__(
        self,
        study: Study,
        folder: Path,
        store: Store,
        workers: Workers,
        progress: Progress,
        options: RunOptions,
        stopped: Callable[[], bool],
    ) -> None:
        self.study, self.folder, self.store = study, folder, store
        self.options, self.stopped = options, stopped
        self.reporter = Reporter(study, progress, folder / LOG_NAME, share=self._shares, warnings=options.warnings)
        self._workers = workers
        self._keys = Keys(study)
        self._planned: Plan | None = None
        self._asking: set[str] = set()
        self._expected: set[Situation] = set()
        self._ours, self._platforms = fingerprint(), Platforms(store)
        self._claimed: set[Pair] = set()
        self.flown = 0
        self.repeats: list[Outcome] = []

    def prepare(self) -> None:
        """Prepare this process for flights; processes that are forked from it inherit that."""
        self._workers.ready()

    def plan(self, flights: Iterable[Flight], *, canary: bool = False) -> None:
        """Record planned flights in the store."""
        self.store.plan(self._keys.planned(flight, canary=canary) for flight in flights)

    def arrange(self, flights: Sequence[Flight]) -> list[Batch]:
        """Arrange flights in batches, the longest first; with the option `share`, mutants with their baseline."""
        return together(flights, self.weight_s, self._workers.jobs) if self._shares else alone(flights)

    def unit(self, flights: Sequence[Flight]) -> list[Batch]:
        """Arrange flights in batches for one process."""
        return together(flights, self.weight_s, 1) if self._shares else alone(flights)

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
            if not outcome.invalid:
                self._claim((outcome.situation, outcome.seed))
            news = outcome.name in keys and self.store.put(keys[outcome.name], outcome)
            if outcome.name in due:
                due.remove(outcome.name)
                self.flown += 1
            elif not news:
                self.repeats.append(outcome)
            self.reporter.arrived(asked[outcome.name], outcome, news=news)
            if outcome.mutant in self._asking and infects(outcome):
                self._expect_pool(asked[outcome.name].situation)

    def announce_pool(self, planned: Plan) -> None:
        """Announce the baseline pool of each situation as soon as a mutant of the plan infects there."""
        self._planned = planned
        self._asking = {flight.subject.id for flight in planned.mutants}

    def _expect_pool(self, situation: Situation) -> None:
        if self._planned is not None and situation not in self._expected:
            self._expected.add(situation)
            self.reporter.expect(self.missing(self._planned.pool(situation, LEAST)))

    def repeat(self, flights: Sequence[Flight]) -> None:
        """Repeat the shortest of the stored `flights`, if this run flew any; a gate compares the digests."""
        missing = set(self.missing(flights))
        done = [flight for flight in flights if flight not in missing and not self._foreign(_pair(flight))]
        if self.flown and done:
            self.repeats += self._outcomes(alone([min(done, key=self.weight_s)]))

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
        return self.reporter.wall_s(batch.flights) * self._workers.jobs

    def hold_gates(self, asked: Plan, outcomes: Sequence[Outcome], *, part: bool = False) -> None:
        """Check the gates on the outcomes of the plan `asked`; `part` when only a part of the plan was flown.

        Raises:
            GateError: a gate failed.
        """
        gates.check(
            [self._tracked(outcome) if gates.asks_for_track(outcome) else outcome for outcome in outcomes],
            self.study.roster,
            canary=asked.canary.id if asked.canary else None,
            whole_grid={flight.situation.key for flight in asked.baselines} == self.study.space.point.keys(),
            part=part or self.options.part,
            repeats=self.repeats,
            max_invalid=self.options.max_invalid,
            deterministic=self.study.stack.deterministic,
            spending=spending_of(self.study, self.store),
        )

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
        self._workers.ready()
        self.reporter.progress.start()
        return self._workers.map(batches)

    def _foreign(self, pair: Pair) -> bool:
        """Whether the flights of a pair are of another platform, or would be taken for such flights."""
        return pair not in self._claimed and not self._platforms.equal(self._platforms.of(pair), self._ours)

    def _claim(self, pair: Pair) -> None:
        """Make this platform that of a pair, at the pair's first flight on it."""
        if self._foreign(pair):
            claim(self.store, [pair], self._ours)
            self._claimed.add(pair)

    def _beside(self, flights: Iterable[Flight]) -> dict[str, Flight]:
        """The stored flights of another platform in the situations and seeds of `flights`, by key."""
        pairs = {pair for pair in map(_pair, flights) if self._foreign(pair)}
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

    def _tracked(self, baseline: Outcome) -> Outcome:
        """The baseline with its track, which the store keeps in another table."""
        flight = Flight(None, self.study.grid.situation(baseline.situation), baseline.seed)
        return self.store.get(self._keys.key(flight)) or baseline

    def _missing(self, flights: Iterable[Flight]) -> dict[str, Flight]:
        """The flights without a valid outcome in the store, by key."""
        keyed = {self._keys.key(flight): flight for flight in flights}
        known = self.store.known(keyed)
        return {key: flight for key, flight in keyed.items() if key not in known}


@contextmanager
def opened(
    study: Study,
    folder: Path,
    options: RunOptions,
    *,
    progress: Progress,
    flyer: Flyer | None,
    first: Sequence[Flight],
) -> Iterator[Campaign]:
    """Open the campaign in `folder`; a missing folder is created.

    Args:
        study: the study.
        folder: folder of the campaign.
        options: options of the run.
        progress: progress display.
        flyer: flies; when None the command of the study, else PyBullet.
        first: first requested flights.  If the store lacks any of them, the flyer is prepared before anything is
            written, so that a study that cannot be flown leaves no files.

    Raises:
        GateError: the platform has changed, and none of the stored flights could be flown again on it.
        InputError: the folder or the store cannot be written, or the study cannot be flown.
    """
    promising(folder)
    executor = options.executor or Local(options.jobs)
    stopped = Flag()
    flies = flyer or (Commanded() if study.command else Physics())
    with executor.workers(study, flies, stop=stopped, say=progress.line) as workers:
        if not _all_flown(study, first, folder / STORE_NAME):
            workers.ready()  # may take half a minute in compilers, which poll no flag: a signal ends it at once
        with interruptible(stopped), Store(writable(folder) / STORE_NAME, say=progress.line) as store:
            remember_grid(store, study)
            prove_platform(
                study, store, workers, say=progress.line, stopped=stopped, same_platform=options.same_platform
            )
            yield Campaign(study, folder, store, workers, progress, options, stopped)
            store.confirm()


def _all_flown(study: Study, flights: Iterable[Flight], path: Path) -> bool:
    """Whether the store at `path` has all of `flights`; the store need not exist."""
    if not path.is_file():
        return False
    try:
        with Store(path, create=False) as store:
            keys = set(map(Keys(study).key, flights))
            return store.known(keys) == keys
    except EmptyError:
        return False


def _pair(flight: Flight) -> Pair:
    return flight.situation.key, flight.seed
