"""A file of flights: one line of JSON for each outcome, with the arm of the experiment that it belongs to."""

from __future__ import annotations

import gzip
import json
import os
from collections.abc import Iterable, Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

from scaloft_fi.judge.outcome import Outcome, Subject, Violation
from scaloft_fi.judge.requirement import Kind, Reading

Flights = dict[str, dict[str, Outcome]]
"""Outcomes by arm and by name of the flight."""


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


def missing(names: Iterable[str], kept: Mapping[str, Outcome]) -> list[str]:
    """The names of flights that are not kept, or whose harness failed."""
    return [name for name in names if name not in kept or kept[name].invalid]
