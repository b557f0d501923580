"""Fly one flight, and judge its log; a flight that fails in the harness is tried again, then it is `invalid`."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from importlib import import_module
from typing import TYPE_CHECKING, Any, Protocol

from scaloft_fi.campaign.flight import Batch, Flight
from scaloft_fi.campaign.processes import ATTEMPTS
from scaloft_fi.errors import InputError
from scaloft_fi.judge.outcome import Outcome, outcome_of
from scaloft_fi.registry import in_one_line, plugin_behind

if TYPE_CHECKING:
    from scaloft_fi.mutants.operator import Facts
    from scaloft_fi.sim.load import Scenario
    from scaloft_fi.sim.log import FlightLog
    from scaloft_fi.stack.declaration import Wire
    from scaloft_fi.study import Study


COMMANDED = "scaloft_fi.campaign.flights.command"
"""The module that flies with the command of a study."""


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
    from scaloft_fi.mutants.wire import contexts, wire_for

    scenario = study.scenario(flight.situation)
    known = facts(scenario, study.sim.stack.parameters)
    context = contexts(flight.subject.id, flight.situation.key, flight.seed, known)
    return wire_for(flight.mutant, study.stack, context)


def facts(scenario: Scenario, settings: Mapping[str, Any]) -> Facts:
    """The facts about situation, vehicle, sensors and the stack's `settings` that operators may use."""
    from scaloft_fi.mutants.operator import Facts

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
            except Exception as error:  # noqa: BLE001 - any failure of the harness is reported as invalid, never as a verdict
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
            except Exception as error:  # noqa: BLE001 - as above
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
