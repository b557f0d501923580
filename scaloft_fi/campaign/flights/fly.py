"""Flights: what one is, how it is flown and judged, whole or from the moment at which it leaves its baseline.

A flight that fails in the harness is tried again, then it is `invalid`.
"""

from __future__ import annotations

import math
import os
import signal
from collections.abc import Callable, Collection, Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from importlib import import_module
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from typing import TYPE_CHECKING, Any, Protocol

from scaloft_fi.aside import answers_apart, foreign
from scaloft_fi.campaign.processes import ATTEMPTS, LINUX, PATIENCE_S, cause_of_death, die_with
from scaloft_fi.errors import InputError
from scaloft_fi.judge.outcome import Outcome, Subject, outcome_of
from scaloft_fi.mutants.mutant import PLACEBO, Mutant
from scaloft_fi.mutants.operator import Facts, TapError
from scaloft_fi.mutants.wire import SeamCount, TappedWire, WatchingWire, contexts, wire_for
from scaloft_fi.registry import in_one_line, plugin_behind

if TYPE_CHECKING:
    from scaloft_fi.sim.load import Scenario
    from scaloft_fi.sim.log import FlightLog
    from scaloft_fi.sim.situation import Situation
    from scaloft_fi.stack.declaration import Wire
    from scaloft_fi.study import Study


@dataclass(frozen=True)
class Flight:
    """One planned flight.

    Attributes:
        mutant: the mutant; None = the baseline.
        situation, seed: situation and seed of the flight.
    """

    mutant: Mutant | None
    situation: Situation
    seed: int

    @property
    def subject(self) -> Subject:
        """The subject of the flight."""
        return Subject.of(self.mutant)

    @property
    def name(self) -> str:
        """`MUTANT/SITUATION/SEED`, the argument of `replay`."""
        return f"{self.subject.id}/{self.situation.key}/{self.seed}"

    @property
    def pair(self) -> tuple[str, int]:
        """Key of the situation, and the seed; the flights of a pair have the same baseline."""
        return self.situation.key, self.seed


@dataclass(frozen=True)
class Batch:
    """Flights of one situation and seed.

    Attributes:
        flights: the flights.
        shared: whether the flights share the baseline, each up to the moment at which it leaves the baseline.
    """

    flights: tuple[Flight, ...]
    shared: bool = False

    def __post_init__(self) -> None:
        if self.shared and any(flight.mutant == PLACEBO for flight in self.flights):
            raise ValueError("PLACEBO is always flown whole")

    @property
    def carrier(self) -> Flight:
        """The baseline of the flights."""
        return Flight(None, self.flights[0].situation, self.flights[0].seed)

    def without(self, names: Collection[str]) -> Batch | None:
        """The batch without the flights called `names`; None if no flight remains."""
        left = tuple(flight for flight in self.flights if flight.name not in names)
        return replace(self, flights=left) if left else None


COMMANDED = "scaloft_fi.campaign.flights.command"
"""The module that flies with the command of a study."""


@answers_apart()
def fly_log(study: Study, flight: Flight) -> FlightLog:
    """Fly one flight, by the command of the study where it has one; returns its log."""
    if study.command is not None:
        # by name: the keys of a study without a command leave out what reads its records
        log: FlightLog = import_module(COMMANDED).command_log(study, study.command, flight, wire_of(study, flight))
        return log
    from scaloft_fi.sim.flight import fly

    return fly(study.sim, flight.situation, flight.seed, wire_of(study, flight))


def judged(study: Study, flight: Flight, log: FlightLog) -> Outcome:
    """The outcome of a flight."""
    return outcome_of(
        log,
        flight.subject,
        flight.situation.key,
        flight.seed,
        requirements=study.requirements,
        realisation=study.realisation if flight.mutant is None else None,
    )


def wire_of(study: Study, flight: Flight) -> Wire:
    """A new wire with the fault of the flight."""
    scenario = study.scenario(flight.situation)
    known = facts(scenario, study.sim.stack.parameters)
    context = contexts(flight.subject.id, flight.situation.key, flight.seed, known)
    return wire_for(flight.mutant, study.stack, context)


def facts(scenario: Scenario, settings: Mapping[str, Any]) -> Facts:
    """The facts about situation, vehicle, sensors and the stack's `settings` that operators may use."""
    mission, imu, wall = scenario.world.mission, scenario.sensors.imu, scenario.wall_right
    home_x_m, home_y_m = mission.home
    (x0, y0, _), (x1, y1, _) = scenario.first_leg
    return Facts(
        duration_s=scenario.nominal_s,
        sighting_s=scenario.sighting_s,
        home_x_m=home_x_m,
        home_y_m=home_y_m,
        cruise_mps=mission.cruise_mps,
        slow_mps=mission.slow_mps,
        wall_m=wall.place if wall else None,
        bearing_rad=wall.bearing_rad if wall else math.atan2(y1 - y0, x1 - x0),
        inward=wall.inward if wall else (0.0, 0.0),
        half_width_m=0.5 * scenario.vehicle.hull_m[1],
        view_rad=scenario.sensors.depth.camera.fov_rad,
        gyro_sigma_radps=imu.rate_sigma_radps,
        accel_sigma_mps2=imu.force_sigma_mps2,
        settings=settings,
    )


def reason_of(error: BaseException) -> str:
    """An error in one line, after the plugin that raised it."""
    plugin = plugin_behind(error)
    return f"{plugin}: {in_one_line(error)}" if plugin else in_one_line(error)


def invalid(flight: Flight, reason: str) -> Outcome:
    """The outcome of a flight that failed in the harness."""
    return replace(Outcome(flight.subject, flight.situation.key, flight.seed), invalid=reason)


class Flyer(Protocol):
    """Turns planned flights into outcomes."""

    def prepare(self, study: Study, say: Callable[[str], None]) -> None:
        """Prepare in the parent process what every worker needs.

        Raises:
            InputError: the study cannot be flown.
        """
        ...

    def __call__(self, study: Study, flight: Flight) -> Outcome:
        """Fly and judge one flight from take-off; a failure of the harness is raised."""
        ...

    def share(self, study: Study, batch: Batch, report: Callable[[Outcome], None]) -> None:
        """Fly and judge the flights of a shared batch; a failure of the harness in the baseline is raised."""
        ...


class Worker:
    """The work of one process: a callable that raises for a wrong study, never for a single flight.

    Args:
        study: the study, opened in the parent process; a forked worker shares it.
        flyer: flies.
    """

    def __init__(self, study: Study, flyer: Flyer) -> None:
        self.study, self.flyer = study, flyer

    def __call__(self, batch: Batch, report: Callable[[Outcome], None]) -> None:
        """Report the outcome of every flight of `batch`; a flight that fails in the harness is tried twice more.

        Raises:
            InputError: the study cannot be flown.
        """
        if batch.shared:
            self._share(batch, report)
            return
        for flight in batch.flights:
            report(self._alone(flight))

    def _alone(self, flight: Flight) -> Outcome:
        reason = ""
        for _ in range(ATTEMPTS):
            try:
                return self.flyer(self.study, flight)
            except InputError:
                raise
            except foreign() as error:  # any failure of the harness is reported as invalid, never as a verdict
                reason = reason_of(error)
        return invalid(flight, reason)

    def _share(self, batch: Batch, report: Callable[[Outcome], None]) -> None:
        known: set[str] = set()

        def note(outcome: Outcome) -> None:
            known.add(outcome.name)
            report(outcome)

        reason = ""
        for _ in range(ATTEMPTS):
            left = batch.without(known)
            if left is None:
                return
            try:
                self.flyer.share(self.study, left, note)
            except InputError:
                raise
            except foreign() as error:  # as above
                reason = reason_of(error)
        left = batch.without(known)
        for flight in left.flights if left else ():
            report(invalid(flight, f"its baseline: {reason}"))


def lost(batch: Batch, reason: str) -> list[Outcome]:
    """The outcomes of flights whose worker process died every time."""
    return [invalid(flight, f"its worker process {reason}") for flight in batch.flights]


def left_of(batch: Batch, outcomes: Iterable[Outcome]) -> Batch | None:
    """The flights of a batch without an outcome; None without any."""
    return batch.without({outcome.name for outcome in outcomes})


CAN_FORK = LINUX
"""On other systems a fork with numeric libraries loaded is not safe, and every flight is flown whole."""


class Fork:
    """Forks flights off the flight of this process.

    The trunk is the process that flies the baseline.  It waits for each child, so one process computes at a time.

    Args:
        report: receives the outcome of each forked flight.
        invalid: makes the outcome of a flight that failed in the harness, from the flight and the reason.
        patience_s: a child without an outcome after this time is hung [s, wall].

    Attributes:
        taken: in a child, the flight that it flies; None in the trunk.
    """

    def __init__(
        self,
        report: Callable[[Outcome], None],
        invalid: Callable[[Flight, str], Outcome],
        patience_s: float = PATIENCE_S,
    ) -> None:
        self.taken: Flight | None = None
        self._report, self._invalid, self._patience_s = report, invalid, patience_s
        self._writer: Connection | None = None

    def __call__(self, flight: Flight) -> bool:
        """Fork `flight`.  Returns True in the child, which flies on, and False in the trunk after the outcome's report.

        A flight that fails in the harness is tried again from the same state.
        """
        attempts = ATTEMPTS
        while True:
            attempts -= 1
            try:
                outcome = self._split(flight)
            except OSError as error:
                outcome = self._invalid(flight, f"its process could not be started: {error.strerror}")
            if outcome is None:
                return True
            if not (outcome.invalid and attempts):
                self._report(outcome)
                return False

    def end(self, outcome: Outcome) -> None:
        """In a child, send its outcome to the trunk and end the process; in the trunk, do nothing."""
        if self._writer is not None:
            try:
                with suppress(OSError):  # the trunk has ended, or has stopped waiting
                    self._writer.send(outcome)
            finally:
                os._exit(0)

    def _split(self, flight: Flight) -> Outcome | None:
        """Fork once; returns None in the child, and the child's outcome in the trunk."""
        reader, writer = Pipe(duplex=False)
        trunk = os.getpid()
        child = os.fork()
        if not child:
            die_with(trunk)
            reader.close()
            self.taken, self._writer = flight, writer
            return None
        writer.close()
        try:
            outcome, reason = self._listen(reader)
        finally:
            os.kill(child, signal.SIGKILL)  # the child has sent its outcome, is hung, or is a zombie
            _, status = os.waitpid(child, 0)
            reader.close()
        return outcome or self._invalid(flight, reason or f"its process died: {cause_of_death(status)}")

    def _listen(self, reader: Connection) -> tuple[Outcome | None, str]:
        if not reader.poll(self._patience_s):
            return None, f"it hung: no end in {self._patience_s:g} s of wall time"
        try:
            return reader.recv(), ""
        except (EOFError, OSError):
            return None, ""


SOON_S = 1.0
"""A mutant that leaves the baseline earlier is flown whole, which is faster than a fork [s from take-off]."""


def fly_shared(
    study: Study, batch: Batch, report: Callable[[Outcome], None], fly_apart: Callable[[Flight], Iterable[Outcome]]
) -> None:
    """Fly a shared batch; every outcome equals that of the flight flown alone from take-off.

    Args:
        study: the study.
        batch: the flights.
        report: receives the outcome of each flight as soon as it is known.
        fly_apart: flies one flight from take-off in another process.

    Raises:
        Exception: the baseline failed in the harness; outcomes that were reported before are valid.
    """
    from scaloft_fi.sim.flight import fly

    mutants = {flight.name: flight for flight in batch.flights if flight.mutant is not None}
    fork, carrier, watched = Fork(report, invalid), batch.carrier, dict[str, TappedWire]()

    def failed(name: str, error: TapError) -> None:
        report(invalid(mutants[name], reason_of(error)))

    def branch(name: str, t_s: float) -> bool:
        if t_s >= SOON_S:
            return fork(mutants[name])
        for outcome in fly_apart(mutants[name]):
            report(outcome)
        return False

    for name, flight in mutants.items():
        try:
            if isinstance(tapped := wire_of(study, flight), TappedWire):
                watched[name] = tapped
        except TapError as error:
            failed(name, error)
    wire = WatchingWire(watched, branch, failed)
    try:
        log = fly(study.sim, carrier.situation, carrier.seed, wire)
        outcome = judged(study, fork.taken or carrier, log)
    except BaseException as error:
        if fork.taken is not None:
            fork.end(invalid(fork.taken, reason_of(error)))
        raise
    fork.end(outcome)
    for flight in batch.flights:
        if flight.mutant is None:
            report(outcome)
        elif flight.name in wire.silent:
            report(as_baseline(outcome, flight.subject, wire.silent[flight.name]))


def as_baseline(baseline: Outcome, subject: Subject, counts: Mapping[str, SeamCount]) -> Outcome:
    """The outcome of a mutant without an altered sample: the outcome of its baseline, with the mutant's counts."""
    carried = sum(count.carried for count in counts.values())
    return replace(baseline, subject=subject, carried=carried, altered=0, infected_at_s=None, realised=())
