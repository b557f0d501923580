"""Planned flights to outcomes.  What the harness does wrong is `invalid`; what the drone does is judged."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from threading import Timer
from typing import TYPE_CHECKING, Protocol

from scaloft_fi.campaign.plan.plan import Flight
from scaloft_fi.campaign.plan.task import Task
from scaloft_fi.campaign.workers.pool import ATTEMPTS
from scaloft_fi.collector import uncollected
from scaloft_fi.errors import InputError
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.study import Study

if TYPE_CHECKING:
    from scaloft_fi.mutants.facts import Facts
    from scaloft_fi.sim.load import SimConfig
    from scaloft_fi.sim.log import FlightLog
    from scaloft_fi.sim.scenario import Scenario
    from scaloft_fi.stack.seam import Wire

KERNELS_S = 5.0
"""So much of a flight calls every compiled kernel: the drone has climbed, and plans [s]."""
PATIENCE_S = 1.0
"""After this a person is told what the wait is for [s, wall]."""


class Flyer(Protocol):
    """What turns planned flights into outcomes."""

    def prepare(self, study: Study, say: Callable[[str], None]) -> None:
        """Do in the parent what every worker would have to do by itself.

        Raises:
            InputError: the study cannot be flown.
        """
        ...

    def __call__(self, study: Study, flight: Flight) -> Outcome:
        """Fly and judge one flight from take-off; whatever goes wrong with the harness is raised."""
        ...

    def share(self, study: Study, task: Task, home: Callable[[Outcome], None]) -> None:
        """Fly and judge the flights of a shared task; what goes wrong over the baseline is raised."""
        ...


class Physics:
    """Flies in PyBullet."""

    @uncollected()
    def prepare(self, study: Study, say: Callable[[str], None]) -> None:
        """Build the stack, compile its kernels and parse the formulas by flying and judging a few seconds.

        Whatever is forked afterwards has them.

        Raises:
            InputError: the settings of the stack do not fit.
        """
        with _unheard():
            import pybullet  # noqa: F401 - it greets on standard error when first imported
        from scaloft_fi.sim import flight
        from scaloft_fi.stack.rates import TICK_HZ
        from scaloft_fi.stack.seam import PlainWire

        notice = Timer(PATIENCE_S, say, ["compiling kernels (first run only)"])
        notice.start()
        try:
            first = study.grid.situations[0]
            with flight.physics_server() as client:
                trial = flight.Flight(client, study.sim, study.scenario(first), 0, PlainWire())
                trial.step()
                for _ in range(round(KERNELS_S * TICK_HZ)):
                    trial.tick()
                    trial.advance()
                judged(study, Flight(None, first, 0), trial.log())
        finally:
            notice.cancel()
            notice.join()

    def __call__(self, study: Study, flight: Flight) -> Outcome:
        """Fly and judge one flight from take-off."""
        return judged(study, flight, fly_log(study, flight))

    def share(self, study: Study, task: Task, home: Callable[[Outcome], None]) -> None:
        """Fly the baseline once, and each mutant from where it leaves it."""
        from scaloft_fi.campaign.flights.share import fly_shared

        fly_shared(study, task, home)


def fly_log(study: Study, flight: Flight) -> FlightLog:
    """Fly one flight; returns all that happened."""
    from scaloft_fi.sim.flight import fly

    return fly(study.sim, flight.situation, flight.seed, wire_of(study, flight))


def judged(study: Study, flight: Flight, log: FlightLog) -> Outcome:
    """What is kept of a flight."""
    from scaloft_fi.judge.outcome import outcome_of

    return outcome_of(
        log,
        flight.subject,
        flight.situation.key,
        flight.seed,
        requirements=study.requirements,
        realisation=study.realisation if flight.mutant is None else None,
    )


def wire_of(study: Study, flight: Flight) -> Wire:
    """A fresh wire with the flight's fault in it."""
    from scaloft_fi.mutants.wire import contexts, wire_for

    scenario = study.scenario(flight.situation)
    context = contexts(flight.subject.id, flight.situation.key, flight.seed, facts(study.sim, scenario))
    return wire_for(flight.mutant, study.stack, context)


def facts(sim: SimConfig, scenario: Scenario) -> Facts:
    """What a fault may know of situation, vehicle and sensors."""
    from scaloft_fi.mutants.facts import Facts

    mission, imu, wall = scenario.world.mission, sim.sensors.imu, scenario.wall_right
    home_x_m, home_y_m = mission.home
    return Facts(
        duration_s=scenario.nominal_s,
        sighting_s=scenario.sighting_s,
        home_x_m=home_x_m,
        home_y_m=home_y_m,
        cruise_mps=mission.cruise_mps,
        slow_mps=mission.slow_mps,
        wall_m=wall.place if wall else None,
        inward=wall.inward if wall else Facts.inward,
        half_width_m=0.5 * sim.vehicle.hull_m[1],
        view_rad=sim.sensors.depth.camera.fov_rad,
        gyro_sigma_radps=imu.rate_sigma_radps,
        accel_sigma_mps2=imu.force_sigma_mps2,
        settings=sim.stack.parameters,
    )


class Worker:
    """The work of one process: a callable that never raises over a flight, only over the study.

    Args:
        study: opened in the parent; a forked worker shares it.
        flyer: what flies.
    """

    def __init__(self, study: Study, flyer: Flyer) -> None:
        self.study, self.flyer = study, flyer

    def __call__(self, task: Task, home: Callable[[Outcome], None]) -> None:
        """Give `home` the outcome of every flight of `task`, tried twice more when the harness failed.

        Raises:
            InputError: the study cannot be flown.
        """
        if task.shared:
            self._share(task, home)
            return
        for flight in task.flights:
            home(self._alone(flight))

    def _alone(self, flight: Flight) -> Outcome:
        reason = ""
        for _ in range(ATTEMPTS):
            try:
                return self.flyer(self.study, flight)
            except InputError:
                raise
            except Exception as error:  # noqa: BLE001 - any failure of the harness is a fact to be told, never a verdict
                reason = reason_of(error)
        return invalid(flight, reason)

    def _share(self, task: Task, home: Callable[[Outcome], None]) -> None:
        told: set[str] = set()

        def note(outcome: Outcome) -> None:
            told.add(outcome.name)
            home(outcome)

        reason = ""
        for _ in range(ATTEMPTS):
            left = task.without(told)
            if left is None:
                return
            try:
                self.flyer.share(self.study, left, note)
            except InputError:
                raise
            except Exception as error:  # noqa: BLE001 - as above
                reason = reason_of(error)
        left = task.without(told)
        for flight in left.flights if left else ():
            home(invalid(flight, f"its baseline: {reason}"))


def reason_of(error: BaseException) -> str:
    """An error in one line."""
    return f"{type(error).__name__}: {' '.join(str(error).split())}"


def invalid(flight: Flight, reason: str) -> Outcome:
    """The outcome of a flight that the harness could not fly."""
    return replace(Outcome(flight.subject, flight.situation.key, flight.seed), invalid=reason)


def lost(task: Task, reason: str) -> list[Outcome]:
    """The outcomes of the flights that took their worker with them."""
    return [invalid(flight, f"its worker process {reason}") for flight in task.flights]


def left_of(task: Task, outcomes: Iterable[Outcome]) -> Task | None:
    """What a worker that was lost still owes of its task."""
    return task.without({outcome.name for outcome in outcomes})


@contextmanager
def _unheard() -> Iterator[None]:
    """Send what C code writes to standard error nowhere."""
    saved, nowhere = os.dup(2), os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 2)
    try:
        yield
    finally:
        os.dup2(saved, 2)
        os.close(saved)
        os.close(nowhere)
