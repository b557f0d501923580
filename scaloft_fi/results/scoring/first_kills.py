"""Killed or not: what a run says that flew only as far as that question needs."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from scaloft_fi.results.flights import Flight
from scaloft_fi.results.outcome import Subject
from scaloft_fi.results.status import Status, mutant_status
from scaloft_fi.results.telling.table import Table


@dataclass(frozen=True)
class Answer:
    """What is known of one mutant.

    Attributes:
        subject: the mutant.
        status: the highest rung over the flights that are home.
        kill: the flight that kills it; None when none does.
        requirement: by which.
        t_s: when [s from take-off].
        flown: how many of its flights are home.
        invalid: how many of them the harness failed at.
        possible: how many there are that could tell.
    """

    subject: Subject
    status: Status
    kill: Flight | None
    requirement: str
    t_s: float | None
    flown: int
    invalid: int
    possible: int

    @property
    def killed(self) -> bool | None:
        """Whether it is killed; None when that is not known, because flights are missing or invalid."""
        if self.kill is not None:
            return True
        return None if self.flown - self.invalid < self.possible else False


def answer(subject: Subject, flights: Iterable[Flight], possible: int, *, control: bool) -> Answer:
    """What the flights say, in the order of the rounds.

    Args:
        subject: the mutant.
        flights: those that are home.
        possible: how many could tell.
        control: whether any violation of what the baseline holds counts, operability and red baselines too.
    """
    listed = list(flights)
    first = next((flight for flight in listed if _kills(flight, control=control)), None)
    by = (first.kills or first.operability_kills)[0] if first else ""
    reading = first.outcome.reading(by) if first else None
    return Answer(
        subject=subject,
        status=mutant_status(flight.ruling for flight in listed) if first is None else Status.KILLED,
        kill=first,
        requirement=by,
        t_s=reading.violated_at_s if reading else None,
        flown=len(listed),
        invalid=sum(flight.status is Status.INVALID for flight in listed),
        possible=possible,
    )


def _kills(flight: Flight, *, control: bool) -> bool:
    if control:
        return bool(flight.kills or flight.operability_kills)
    return flight.status is Status.KILLED and flight.eligible


@dataclass(frozen=True)
class FirstKills:
    """The answers of a run.

    Attributes:
        answers: one a mutant.
        draws: situations and seeds in the order in which they were flown.
        idle: those whose baseline holds no safety requirement to its end: only controls fly there.
    """

    answers: tuple[Answer, ...]
    draws: tuple[tuple[str, int], ...]
    idle: tuple[tuple[str, int], ...]

    @property
    def flown(self) -> int:
        """How many flights of mutants are home."""
        return sum(answer.flown for answer in self.answers)

    @property
    def possible(self) -> int:
        """How many could tell."""
        return sum(answer.possible for answer in self.answers)

    def table(self) -> Table:
        """Mutant by mutant."""
        seeds = len({seed for _, seed in self.draws}) > 1
        rows = tuple(_row(answer, seeds=seeds) for answer in self.answers)
        killed = [answer for answer in self.answers if answer.kill is not None]
        spared = sum(answer.possible - answer.flown for answer in killed)
        missing = sum(answer.possible - answer.flown for answer in self.answers) - spared
        idle = f"{len(self.idle)} of {len(self.draws)} situations and seeds"
        notes = (
            f"{len(killed)} of {len(rows)} mutants are killed; {self.flown} of {self.possible} flights say so.",
            f"Not flown: {spared} flights of mutants that were killed before, {missing} others.",
            f"In {idle} the baseline holds no safety requirement to its end: only controls fly there.",
            "Flights are cut at their first kill: they enter no kill matrix, no rate and no coverage.",
        )
        headers = ("mutant", "killed", "by", "situation", "time [s]", "flown", "possible")
        return Table("First kills", headers, rows, notes)

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values."""
        return {
            "mutants": [
                {
                    "id": answer.subject.id,
                    "guideword": answer.subject.guideword,
                    "parameter": answer.subject.parameter,
                    "magnitude": answer.subject.magnitude,
                    "killed": answer.killed,
                    "status": answer.status.value,
                    "by": answer.requirement or None,
                    "situation": answer.kill.outcome.situation if answer.kill else None,
                    "seed": answer.kill.outcome.seed if answer.kill else None,
                    "t_s": answer.t_s,
                    "flown": answer.flown,
                    "possible": answer.possible,
                }
                for answer in self.answers
            ],
            "flights": {"flown": self.flown, "possible": self.possible},
            "rounds": [{"situation": situation, "seed": seed} for situation, seed in self.draws],
            "idle": [{"situation": situation, "seed": seed} for situation, seed in self.idle],
        }


def _row(answer: Answer, *, seeds: bool) -> tuple[str | int, ...]:
    if answer.kill is None:
        said = f"no ({answer.status.value})" if answer.killed is False else "not known"
        return (answer.subject.id, said, "", "", "", answer.flown, answer.possible)
    outcome = answer.kill.outcome
    place = f"{outcome.situation}/{outcome.seed}" if seeds else outcome.situation
    time = "" if answer.t_s is None else f"{answer.t_s:.2f}"
    return (answer.subject.id, "yes", answer.requirement, place, time, answer.flown, answer.possible)
