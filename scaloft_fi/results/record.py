"""An outcome as a row of the store's table and back: what queries ask for as columns, the rest as lines of JSON."""

from __future__ import annotations

import base64
import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import fields
from sys import intern
from typing import Any, TypeVar

from scaloft_fi.results.outcome import Outcome, Subject, Violation
from scaloft_fi.results.requirement import Kind, Reading

Row = tuple[Any, ...]
"""Values of `COLUMNS`."""

_SUBJECT = {"mutant": "TEXT", "guideword": "TEXT", "parameter": "TEXT", "magnitude": "TEXT"}
_FACTS = {
    "situation": "TEXT",
    "seed": "INTEGER",
    "ending": "TEXT",
    "invalid": "TEXT",
    "truncated": "TEXT",
    "carried": "INTEGER",
    "altered": "INTEGER",
    "infected_at_s": "REAL",
    "struck": "TEXT",
    "duration_s": "REAL",
    "digest": "TEXT",
    "perceived_digest": "TEXT",
    "stack_error": "TEXT",
}
_LINES = {"readings": "TEXT", "violations": "TEXT", "realised": "TEXT"}
COLUMNS: Mapping[str, str] = {**_SUBJECT, **_FACTS, **_LINES}
"""The columns and their types, all of an outcome but its track.

The last three hold one entry a line, each a JSON list of its fields in their order: most lines are the same in many
flights, and a line is read once.
"""


def to_row(outcome: Outcome) -> Row:
    """The values of `COLUMNS`.

    Raises:
        ValueError: a number in it is not finite.
    """
    subject = outcome.subject
    return (
        *(subject.id, subject.guideword, subject.parameter, subject.magnitude),
        *(getattr(outcome, name) for name in _FACTS),
        _lines([getattr(reading, name) for name in _READING] for reading in outcome.readings),
        _lines([getattr(violation, name) for name in _VIOLATION] for violation in outcome.violations),
        _lines(outcome.realised),
    )


_READING = [field.name for field in fields(Reading)]
_VIOLATION = [field.name for field in fields(Violation)]


def _lines(entries: Iterable[Sequence[Any]]) -> str:
    return "\n".join(json.dumps(entry, allow_nan=False) for entry in entries)


class Reader:
    """Makes outcomes of rows; what is equal in them is one object."""

    def __init__(self) -> None:
        self._subjects: dict[Row, Subject] = {}
        self._readings = _Lines(_reading)
        self._violations = _Lines(_violation)
        self._realised = _Lines(_came_true)

    def __call__(self, row: Row, track: bytes = b"") -> Outcome:
        """The outcome whose `to_row` this is."""
        subject = self._subjects.get(row[:4])
        if subject is None:
            subject = self._subjects[row[:4]] = Subject(*map(intern, row[:4]))
        situation, seed, ending, invalid, truncated, carried, altered, infected_at_s, struck, duration_s = row[4:14]
        digest, perceived_digest, stack_error, readings, violations, realised = row[14:]
        return Outcome(
            subject,
            intern(situation),
            seed,
            intern(ending),
            invalid,
            self._readings.of(readings),
            self._violations.of(violations),
            carried,
            altered,
            infected_at_s,
            intern(struck),
            duration_s,
            digest,
            perceived_digest,
            stack_error,
            truncated,
            self._realised.of(realised),
            track,
        )


T = TypeVar("T")


class _Lines(dict[str, T]):
    """Entries by their lines, each read when it is first asked for."""

    def __init__(self, read: Callable[[str], T]) -> None:
        self._read = read

    def __missing__(self, line: str) -> T:
        entry = self[line] = self._read(line)
        return entry

    def of(self, text: str) -> tuple[T, ...]:
        """The entries of a column."""
        return tuple(map(self.__getitem__, text.split("\n"))) if text else ()


def _reading(line: str) -> Reading:
    name, kind, *rest = _DECODER.raw_decode(line)[0]
    return Reading(intern(name), _KINDS[kind], *rest)


def _violation(line: str) -> Violation:
    name, kind, t_s, x, y, z, struck = _DECODER.raw_decode(line)[0]
    return Violation(intern(name), _KINDS[kind], t_s, x, y, z, intern(struck))


def _came_true(line: str) -> tuple[str, bool]:
    axis, came_true = _DECODER.raw_decode(line)[0]
    return intern(axis), came_true


_DECODER = json.JSONDecoder()
_KINDS = {kind.value: kind for kind in Kind}


def from_json(values: Mapping[str, Any]) -> Outcome:
    """The outcome in an object by names, as stores before schema 4 have it; unknown names are ignored."""
    known = {field.name: values[field.name] for field in fields(Outcome) if field.name in values}
    known["subject"] = Subject(**values["subject"])
    known["readings"] = tuple(Reading(**{**entry, "kind": Kind(entry["kind"])}) for entry in values["readings"])
    known["violations"] = tuple(Violation(**{**entry, "kind": Kind(entry["kind"])}) for entry in values["violations"])
    known["realised"] = tuple((str(axis), bool(came_true)) for axis, came_true in values["realised"])
    known["track"] = base64.b64decode(values.get("track", ""))
    return Outcome(**known)
