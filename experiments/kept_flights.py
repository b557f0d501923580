"""The flights of an experiment in a file: one line of JSON for each outcome, with the arm that it belongs to."""

from __future__ import annotations

import gzip
import json
import os
import sys
import time
from collections.abc import Iterable, Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

from experiments.varied import shared
from scaloft_fi.campaign.flight import Flight
from scaloft_fi.judge.outcome import BASELINE, Outcome, Subject, Violation
from scaloft_fi.judge.requirement import Kind, Reading
from scaloft_fi.mutants.mutant import Mutant
from scaloft_fi.study import Study

Flights = dict[str, dict[str, Outcome]]
"""Outcomes by arm and by name of the flight."""
SAVE_S = 10.0
"""Greatest time between two writes of the file [s, wall]."""


def read(path: Path) -> Flights:
    """The flights of a file; none if there is no file."""
    flights: Flights = {}
    if path.exists():
        with gzip.open(path, "rt", encoding="utf-8") as lines:
            for line in lines:
                row = json.loads(line)
                outcome = _outcome(row)
                flights.setdefault(row["arm"], {})[outcome.name] = outcome
    return flights


def write(path: Path, flights: Mapping[str, Mapping[str, Outcome]]) -> None:
    """Write the file anew and replace the old one at once, so that a kill leaves the old or the new one.

    Equal flights give equal bytes, whatever their order.
    """
    lines = sorted(_line(arm, outcome) for arm, outcomes in flights.items() for outcome in outcomes.values())
    begun = path.with_name(f"{path.name}.part")
    begun.write_bytes(gzip.compress("".join(lines).encode(), mtime=0))
    os.replace(begun, path)  # noqa: PTH105 - it must replace the old file at once


def _line(arm: str, outcome: Outcome) -> str:
    row = asdict(outcome)
    place = {"arm": arm, "situation": row.pop("situation"), "seed": row.pop("seed")}
    del row["track"], row["perceived_digest"]
    return json.dumps({**place, **row}, allow_nan=False) + "\n"


def _outcome(row: Mapping[str, Any]) -> Outcome:
    made = {
        "subject": Subject(**row["subject"]),
        "readings": tuple(Reading(**{**reading, "kind": Kind(reading["kind"])}) for reading in row["readings"]),
        "violations": tuple(Violation(**{**entry, "kind": Kind(entry["kind"])}) for entry in row["violations"]),
        "realised": tuple((axis, came_true) for axis, came_true in row["realised"]),
    }
    return Outcome(**{**{name: value for name, value in row.items() if name != "arm"}, **made})


def complete(path: Path, kept: Flights, arm: str, study: Study, planned: Iterable[Flight], jobs: int) -> None:
    """Fly the planned flights of an arm that are not kept or whose harness failed, and keep them in the file.

    Args:
        path: the file.
        kept: its flights; the new flights are added.
        arm: name of the arm.
        study: the study of the arm.
        planned: all flights of the arm.
        jobs: number of processes.
    """
    own = kept.setdefault(arm, {})
    wanted = [flight for flight in planned if flight.name not in own or own[flight.name].invalid]
    if not wanted:
        return
    print(f"{arm}: {len(wanted)} flights", file=sys.stderr, flush=True)
    saved_s = time.monotonic()
    try:
        for outcome in shared(study, wanted, jobs):
            own[outcome.name] = outcome
            if time.monotonic() - saved_s >= SAVE_S:
                write(path, kept)
                saved_s = time.monotonic()
    finally:
        write(path, kept)


def flights_of(study: Study, mutants: Mapping[str, Mutant], names: Iterable[str]) -> list[Flight]:
    """The flights of these names, `MUTANT/SITUATION/SEED`; `mutants` has the mutants among them by id."""
    parts = (name.split("/") for name in names)
    return [
        Flight(None if mutant == BASELINE else mutants[mutant], study.grid.situation(key), int(seed))
        for mutant, key, seed in parts
    ]
