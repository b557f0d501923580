"""Convert outcomes to rows of the store's table and back: columns for queries, lines of JSON for the rest."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import fields
from itertools import groupby, repeat
from sys import intern
from typing import Any, Generic, TypeVar

from scaloft_fi.judge.outcome import Outcome, Subject, Violation
from scaloft_fi.judge.requirement import Kind, Reading

Record = tuple[Any, ...]
"""Values of `COLUMNS`."""

SUBJECT: Mapping[str, str] = {"mutant": "TEXT", "guideword": "TEXT", "parameter": "TEXT", "magnitude": "TEXT"}
"""The columns of the subject."""
_FACTS = {
    "situation": "TEXT",
    "seed": "INTEGER",
    "ending": "TEXT",
    "invalid": "TEXT",
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
COLUMNS: Mapping[str, str] = {**SUBJECT, **_FACTS, **_LINES}
"""The columns and their types: an outcome without its track.

The last three columns hold one entry per line, a JSON list of its fields in order.  Most lines occur in many flights,
and `Lines` parses a line once.
"""


def to_row(outcome: Outcome) -> Record:
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
    """Makes outcomes from rows; equal parts of outcomes are one object."""

    def __init__(self) -> None:
        self._subjects = _Subjects()
        self._readings = Lines(_readings)
        self._violations = Lines(_violations)
        self._realised = Lines(_came_true)

    def __call__(self, rows: Sequence[Record], tracks: Iterable[bytes] = repeat(b"")) -> list[Outcome]:
        """The outcomes of rows, with their tracks; a row begins with the values of `to_row`."""
        if not rows:
            return []
        columns = list(zip(*rows, strict=True))
        subjects, rest = columns[: len(SUBJECT)], columns[len(SUBJECT) : len(COLUMNS)]
        situation, seed, ending, invalid, carried, altered, infected_at_s, struck, duration_s = rest[:9]
        digest, perceived_digest, stack_error, readings, violations, realised = rest[9:]
        return list(
            map(
                Outcome,
                map(self._subjects.__getitem__, zip(*subjects, strict=True)),
                map(intern, situation),
                seed,
                map(intern, ending),
                invalid,
                self._readings.of(readings),
                self._violations.of(violations),
                carried,
                altered,
                infected_at_s,
                map(intern, struck),
                duration_s,
                digest,
                perceived_digest,
                stack_error,
                self._realised.of(realised),
                tracks,
            ),
        )


class _Subjects(dict[Record, Subject]):
    """Subjects by their columns; each subject is made once."""

    def __missing__(self, row: Record) -> Subject:
        subject = self[row] = Subject(*map(intern, row))
        return subject


T = TypeVar("T")


class Lines(Generic[T]):
    """Entries by their lines; each line is parsed once.

    Args:
        read: makes entries from the columns of their fields.
    """

    def __init__(self, read: Callable[..., Iterable[T]]) -> None:
        self._read = read
        self._lines: dict[str, T] = {}

    def of(self, column: Sequence[str]) -> Iterable[tuple[T, ...]]:
        """The entries of each text of a column; equal texts are split once."""
        read: dict[str, tuple[T, ...]] = {"": ()}
        for breaks, group in groupby(sorted(set(column).difference(read), key=_breaks), key=_breaks):
            texts = list(group)
            lines = "\n".join(texts).split("\n")
            self._learn(list(set(lines).difference(self._lines)))
            entries = map(self._lines.__getitem__, lines)
            read.update(zip(texts, zip(*repeat(entries, breaks + 1), strict=True), strict=True))
        return map(read.__getitem__, column)

    def _learn(self, lines: Sequence[str]) -> None:
        if lines:
            # one text for the decoder, whose call costs more than a line
            columns = zip(*json.loads(f"[{','.join(lines)}]"), strict=True)
            self._lines.update(zip(lines, self._read(*columns), strict=True))


def _breaks(text: str) -> int:
    return text.count("\n")


def _readings(names: Iterable[str], kinds: Iterable[str], *rest: Iterable[Any]) -> list[Reading]:
    return list(map(Reading, map(intern, names), map(_KINDS.__getitem__, kinds), *rest))


def _violations(names: Iterable[str], kinds: Iterable[str], *rest: Iterable[Any]) -> list[Violation]:
    *place, struck = rest
    return list(map(Violation, map(intern, names), map(_KINDS.__getitem__, kinds), *place, map(intern, struck)))


def _came_true(axes: Iterable[str], came_true: Iterable[bool]) -> Iterable[tuple[str, bool]]:
    return zip(map(intern, axes), came_true, strict=True)


_KINDS = {kind.value: kind for kind in Kind}
