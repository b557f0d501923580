"""What tests of runs ask for in the study without physics of `tests/campaign/conftest.py`, and what may come out."""

from __future__ import annotations

import io
import os
import signal
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from scaloft_fi.campaign.flights.fly import Flight
from scaloft_fi.campaign.plan import Plan, plan
from scaloft_fi.campaign.progress import Progress
from scaloft_fi.campaign.runs.gates import RunOptions
from scaloft_fi.campaign.runs.run import Report, run
from scaloft_fi.campaign.store.archive import STORE_NAME
from scaloft_fi.campaign.store.held import Held, Now, current_in, held_in
from scaloft_fi.campaign.store.store import Store
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.mutants.catalogue import realise
from scaloft_fi.verbs.export.dossier import export_rows, to_json

LATE, MORE, CONTROL = "LATE-human@3s", "MORE-goal@1m", "REVERSE-velcmd"
Change = Callable[[Flight, Outcome], Outcome]


def quiet() -> Progress:
    """A display that nobody sees."""
    return Progress(stream=io.StringIO())


class PowerError(Exception):
    """The power failed."""


def dying(at: int, error: type[Exception] | Exception = PowerError) -> Progress:
    """A display of a run that dies when so many flights are done."""

    class Dying(Progress):
        def advance(self) -> None:
            super().advance()
            if self.done == at:
                raise error

    return Dying(stream=io.StringIO())


def asked(study: Any, seeds: Sequence[int] = (0,), names: Sequence[str] = (LATE,), canary: str = CONTROL) -> Plan:
    """Mutants in all situations of the study, with a canary unless its name is empty."""
    mutants = [realise(study.matrix, name) for name in names]
    return plan(study.grid, seeds, mutants, realise(study.matrix, canary) if canary else None)


class Runs:
    """Runs of a study by a flyer.  study, log: fixtures; a call flies in the folder `c`, or another."""

    def __init__(self, study: Any, log: Any) -> None:
        self.study, self.log = study, log

    def __call__(self, planned: Plan | None = None, folder: str = "c", *, of: Any = None, **options: Any) -> Report:
        now, stream = of or self.study, options.pop("stream", None) or io.StringIO()
        where, how = self.folder(folder), RunOptions(**options)
        return run(now, planned or asked(now), where, how, progress=Progress(stream=stream), flyer=self.log)

    def folder(self, name: str = "c") -> Path:
        """The folder of a campaign."""
        return self.study.folder / name

    def store(self, name: str = "c", *, create: bool = False) -> Store:
        """The store of a campaign."""
        return Store(self.folder(name) / STORE_NAME, create=create)

    def held(self, name: str = "c") -> Held:
        """What a campaign holds."""
        with self.store(name) as store:
            return held_in(Now(self.study, store), self.folder(name))

    def current(self, name: str = "c") -> tuple[Outcome, ...]:
        """The outcomes of a campaign that count."""
        with self.store(name) as store:
            return current_in(self.study, store)

    def export(self, outcomes: Sequence[Outcome]) -> str:
        """What `export` writes of outcomes."""
        return to_json(export_rows(outcomes, self.study.roster, self.study.space))


def same(_flight: Flight, outcome: Outcome) -> Outcome:
    """What comes out of the flyer."""
    return outcome


def changed(names: str, **changes: Any) -> Change:
    """Another outcome of the flights whose names begin so."""
    return lambda flight, outcome: replace(outcome, **changes) if flight.name.startswith(names) else outcome


def red(outcome: Outcome) -> Outcome:
    """The outcome with a violation of every requirement."""
    return replace(outcome, readings=tuple(replace(reading, violated_at_s=2.0) for reading in outcome.readings))


def interrupting(when: Callable[[Flight], bool], **changes: Any) -> Change:
    """Interrupts the run at some flights."""

    def change(flight: Flight, outcome: Outcome) -> Outcome:
        if when(flight):
            os.kill(os.getppid(), signal.SIGINT)
        return replace(outcome, **changes)

    return change
