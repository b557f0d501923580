"""A flight flown once more, with its log: what it says, its map beside its baseline, its recording."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

from scaloft_fi.campaign.flight import Flight
from scaloft_fi.campaign.flights.command import Commanded
from scaloft_fi.campaign.flights.physics import Physics
from scaloft_fi.campaign.store.held import flight_named
from scaloft_fi.errors import InputError
from scaloft_fi.judge.outcome import BASELINE, Outcome
from scaloft_fi.judge.requirement import Reading, measured_rho
from scaloft_fi.judge.status import JudgedFlight, flight_of
from scaloft_fi.views.pictures.map import draw
from scaloft_fi.views.pictures.scene import scene_of, track_of
from scaloft_fi.views.tables.table import Table

if TYPE_CHECKING:
    from scaloft_fi.sim.log import FlightLog
    from scaloft_fi.study import Study

RECORDINGS = (".mcap", ".csv")
"""Ends of the names of recordings."""


@dataclass(frozen=True, eq=False)
class LoggedFlight:
    """A flight with its log.

    Attributes:
        study: the study.
        flight: subject, situation and seed.
        log: the record of the flight.
        outcome: what the requirements say of it.
    """

    study: Study
    flight: Flight
    log: FlightLog
    outcome: Outcome

    @cached_property
    def clean(self) -> LoggedFlight | None:
        """The baseline of the same situation and seed, flown when it is first asked for; None for a baseline."""
        if self.flight.mutant is None:
            return None
        return fly_with_log(self.study, Flight(None, self.flight.situation, self.flight.seed))

    @cached_property
    def judged(self) -> JudgedFlight:
        """The flight of a mutant, compared with its baseline."""
        return flight_of(self.outcome, self.clean.outcome if self.clean else None)

    def facts(self) -> Table:
        """What happened, as a table of two columns."""
        outcome, log = self.outcome, self.log
        rows: list[tuple[str, str]] = [
            ("situation", ", ".join(self.study.grid.titles(self.flight.situation))),
            ("ending", f"{log.ending.sentence} after {log.duration_s:.2f} s"),
        ]
        if self.flight.mutant is not None:
            first = f", first at {outcome.infected_at_s:.2f} s" if outcome.infected_at_s is not None else ""
            rows.append(("samples altered", f"{outcome.altered} of {outcome.carried}{first}"))
        rows += [(reading.requirement, reading_text(reading)) for reading in outcome.readings]
        if outcome.stack_error:
            rows.append(("stack", outcome.stack_error))
        rows.append(("digest", outcome.digest))
        return Table(outcome.name, ("what", ""), tuple(rows))

    def map(self) -> str:
        """The map of the flight, beside its baseline where it has one, as the text of an SVG file."""
        flight = self.flight
        tracks = [track_of(self.log, self.outcome, flight.subject.id)]
        if self.clean is not None:
            tracks.insert(0, track_of(self.clean.log, self.clean.outcome, BASELINE))
        words = ", ".join(self.study.grid.titles(flight.situation))
        title = f"{flight.subject.id} in {flight.situation.key}, seed {flight.seed}"
        return draw(scene_of(self.study.scenario(flight.situation).world), tracks, title=title, subtitle=words)

    def recording(self, end: str) -> bytes:
        """The log as a file.

        Args:
            end: end of its name: `.csv`, a table, or `.mcap`, for Foxglove.

        Raises:
            InputError: the package that writes the file is not installed.
        """
        from scaloft_fi.views.flights.log_table import log_table
        from scaloft_fi.views.flights.mcap import mcap

        return log_table(self.log) if end == ".csv" else mcap(self.log, self.outcome.name)


def ready_to_fly(study: Study, mutant: str, situation: str, seed: int, say: Callable[[str], None]) -> Flight:
    """The flight of `mutant` (`baseline`, `PLACEBO` or an id), after study and simulator were prepared for it.

    Args:
        study: the study.
        mutant: the subject.
        situation: key or alias of the situation.
        seed: seed of the noise.
        say: prints a line for the user.

    Raises:
        InputError: there is no such mutant or situation, or the study cannot be flown.
    """
    flight = flight_named(study, mutant, situation, seed)
    study.check((flight.situation,))
    (Commanded() if study.command else Physics()).prepare(study, say)
    return flight


def fly_with_log(study: Study, flight: Flight) -> LoggedFlight:
    """Fly a flight, in this process."""
    from scaloft_fi.campaign.flights.fly import fly_log

    return with_log(study, flight, fly_log(study, flight))


def with_log(study: Study, flight: Flight, log: FlightLog) -> LoggedFlight:
    """The flight with this log."""
    from scaloft_fi.campaign.flights.fly import judged

    return LoggedFlight(study, flight, log, judged(study, flight, log))


def reading_text(reading: Reading) -> str:
    """A reading in words: `violated at 8.10 s, robustness -0.238`."""
    at = f" at {reading.violated_at_s:.2f} s" if reading.violated_at_s is not None else ""
    rho = measured_rho(reading)
    told = "" if rho is None else f", robustness {rho:.3f}"
    return f"{reading.compliance.value}{at}{told}"


def named(name: str) -> tuple[str, str, int]:
    """Mutant, situation and seed of a name such as `LATE-human@3s/T0O0W0D0H1/0`.

    Raises:
        InputError: the name has another form.
    """
    parts = name.split("/")
    if len(parts) != 3 or not parts[2].isdecimal():
        raise InputError(f"{name!r} must be MUTANT/SITUATION/SEED, with `baseline` for the unmutated drone")
    return parts[0], parts[1], int(parts[2])
