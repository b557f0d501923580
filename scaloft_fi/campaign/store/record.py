"""Convert outcomes to rows of the store's table and back: columns for queries, lines of JSON for the rest."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import fields
from itertools import groupby, repeat
from operator import attrgetter
from sys import intern
from typing import Any, Generic, TypeVar

from scaloft_fi.campaign.store.cells import (
    MOST_LINE,
    MOST_SEED,
    BadCellError,
    TooLargeError,
    decoded,
    flags,
    labels,
    most_flights,
    numbers,
    texts,
    wholes,
)
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

MOST_REASON = 10_000
"""Greatest length of an error's text in a store; a longer text is cut."""
_PER_FLIGHT = 512
"""Greatest mean number of characters of a flight's texts, and of its lines that no other flight has."""


def to_row(outcome: Outcome) -> Record:
    """The values of `COLUMNS`; the texts of errors are cut to `MOST_REASON` characters.

    Raises:
        ValueError: a number in it is not finite.
    """
    subject = outcome.subject
    return (
        *(subject.id, subject.guideword, subject.parameter, subject.magnitude),
        *(_cut(name, getattr(outcome, name)) for name in _FACTS),
        _lines([getattr(reading, name) for name in _READING] for reading in outcome.readings),
        _lines([getattr(violation, name) for name in _VIOLATION] for violation in outcome.violations),
        _lines(outcome.realised),
    )


def _cut(name: str, value: Any) -> Any:
    return value[:MOST_REASON] if name in _REASONS else value


_REASONS = ("invalid", "stack_error")
_READING = [field.name for field in fields(Reading)]
_VIOLATION = [field.name for field in fields(Violation)]


def _lines(entries: Iterable[Sequence[Any]]) -> str:
    return "\n".join(json.dumps(entry, allow_nan=False) for entry in entries)


class Reader:
    """Makes outcomes from rows, whose cells it checks; equal parts of outcomes are one object."""

    def __init__(self) -> None:
        self._subjects = _Subjects()
        self._readings = Lines("readings", _readings)
        self._violations = Lines("violations", _violations, attrgetter("requirement"))
        self._realised = Lines("realised", _came_true)
        self._characters = 0
        self._most_characters = most_flights() * _PER_FLIGHT

    def __call__(self, rows: Sequence[Record], tracks: Iterable[bytes] = repeat(b"")) -> list[Outcome]:
        """The outcomes of rows, with their tracks; a row begins with the values of `to_row`.

        Raises:
            BadCellError: a cell has a value that `to_row` does not make.
            TooLargeError: the texts are larger than the limit.
        """
        if not rows:
            return []
        columns = list(zip(*rows, strict=True))
        subjects, rest = columns[: len(SUBJECT)], columns[len(SUBJECT) : len(COLUMNS)]
        situation, seed, ending, invalid, carried, altered, infected_at_s, struck, duration_s = rest[:9]
        digest, perceived_digest, stack_error, readings, violations, realised = rest[9:]
        labels("situation", situation)
        labels("ending", ending)
        labels("struck", struck)
        wholes("seed", seed, MOST_SEED)
        wholes("carried", carried)
        wholes("altered", altered)
        numbers("infected_at_s", infected_at_s, none=True)
        numbers("duration_s", duration_s)
        for name, column in zip(_TEXTS, (invalid, digest, perceived_digest, stack_error), strict=True):
            self._characters += texts(name, column)
        if self._characters > self._most_characters:
            raise TooLargeError("outcomes", "text")
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


_TEXTS = ("invalid", "digest", "perceived_digest", "stack_error")


class _Subjects(dict[Record, Subject]):
    """Subjects by their columns; each subject is made once."""

    def __missing__(self, row: Record) -> Subject:
        for name, text in zip(SUBJECT, row, strict=True):
            labels(name, [text])
        subject = self[row] = Subject(*map(intern, row))
        return subject


T = TypeVar("T")


class Lines(Generic[T]):
    """Entries by their lines; each line is parsed once.

    Args:
        name: name of the column.
        read: makes entries from the columns of their fields, which it checks.
        once: the property of an entry that no other entry of the same cell has; None if any may repeat.
    """

    def __init__(self, name: str, read: Callable[..., Iterable[T]], once: Callable[[T], str] | None = None) -> None:
        self._name, self._read, self._once = name, read, once
        self._lines: dict[str, T] = {}
        self._characters = 0
        self._most_characters = most_flights() * _PER_FLIGHT

    def of(self, column: Sequence[str]) -> Iterable[tuple[T, ...]]:
        """The entries of each text of a column; equal texts are split once.

        Raises:
            BadCellError: a cell is no text, or a line is no entry.
            TooLargeError: the lines are larger than the limit.
        """
        try:
            return self._entries(column)
        except (TypeError, ValueError, KeyError, AttributeError) as error:
            what = f": {error.column} {error.allowed}" if isinstance(error, BadCellError) else ""
            raise BadCellError(self._name, f"one JSON list a line, as `run` writes them{what}") from error

    def _entries(self, column: Sequence[str]) -> Iterable[tuple[T, ...]]:
        read: dict[str, tuple[T, ...]] = {"": ()}
        for breaks, group in groupby(sorted(set(column).difference(read), key=_breaks), key=_breaks):
            texts = list(group)
            lines = "\n".join(texts).split("\n")
            self._learn(list(set(lines).difference(self._lines)))
            entries = map(self._lines.__getitem__, lines)
            cells = list(zip(*repeat(entries, breaks + 1), strict=True))
            if breaks and self._once and any(len(set(map(self._once, cell))) <= breaks for cell in cells):
                raise ValueError("an entry occurs twice")
            read.update(zip(texts, cells, strict=True))
        return map(read.__getitem__, column)

    def _learn(self, lines: Sequence[str]) -> None:
        for start in range(0, len(lines), _AT_ONCE):
            some = lines[start : start + _AT_ONCE]
            # one text for the decoder, whose call costs more than a line
            text = ",".join(some)
            self._characters += len(text)
            if self._characters > self._most_characters:
                raise TooLargeError("outcomes", self._name)
            if max(map(len, some)) > MOST_LINE:
                raise ValueError("a line is too long")
            entries = decoded(f"[{text}]")
            if set(map(type, entries)) != {list}:
                raise ValueError("a line is no list")
            columns = zip(*entries, strict=True)
            self._lines.update(zip(some, self._read(*columns), strict=True))


_AT_ONCE = 1000
"""Number of lines that are parsed at once; JSON may take 64 bytes of memory for each character."""


def _breaks(text: str) -> int:
    return text.count("\n")


def _readings(
    names: Sequence[str],
    kinds: Sequence[str],
    rho: Sequence[float],
    violated_at_s: Sequence[float | None],
    triggered: Sequence[int],
    open_: Sequence[bool],
) -> list[Reading]:
    labels("requirement", names)
    numbers("rho", rho)
    numbers("violated_at_s", violated_at_s, none=True)
    wholes("triggered", triggered)
    flags("open", open_)
    kind = map(_KINDS.__getitem__, kinds)
    return list(map(Reading, map(intern, names), kind, rho, violated_at_s, triggered, open_))


def _violations(names: Sequence[str], kinds: Sequence[str], *rest: Sequence[Any]) -> list[Violation]:
    *place, struck = rest
    labels("requirement", names)
    for name, values in zip(("t_s", "x", "y", "z"), place, strict=True):
        numbers(name, values)
    labels("struck", struck)
    return list(map(Violation, map(intern, names), map(_KINDS.__getitem__, kinds), *place, map(intern, struck)))


def _came_true(axes: Sequence[str], came_true: Sequence[bool]) -> Iterable[tuple[str, bool]]:
    labels("axis", axes)
    flags("came true", came_true)
    return zip(map(intern, axes), came_true, strict=True)


_KINDS = {kind.value: kind for kind in Kind}
