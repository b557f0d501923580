"""Outcomes as rows of the store's tables and back; every cell is checked, because a store may come from anywhere."""

from __future__ import annotations

import json
import math
import os
import re
import sqlite3
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import fields
from itertools import groupby, repeat
from operator import attrgetter
from sys import intern
from typing import Any, Final, Generic, NamedTuple, NoReturn, TypeVar

from scaloft_fi.campaign.store.origin import Origin
from scaloft_fi.errors import InputError
from scaloft_fi.judge.outcome import TRACK_COLUMNS, Outcome, Subject, Violation, track_values
from scaloft_fi.judge.requirement import Kind, Reading
from scaloft_fi.sim.log import Ending

MOST_FLIGHTS = "SCALOFT_MOST_FLIGHTS"
"""Name of the environment variable that raises the limit of rows."""
DEFAULT_MOST_FLIGHTS = 250_000
"""Default greatest number of rows of a table; a report of 250,000 flights takes about 850 MiB."""
MOST_CELL_BYTES = 65_536
"""Greatest size of a cell of an outcome."""
MOST_BYTES = 16 * 1024**2
"""Greatest size of any other cell: a note with 250,000 draws, a packed track."""
MOST_LABEL = 256
"""Greatest length of a name."""
MOST_LINE = 4096
"""Greatest length of a line of JSON in a cell."""
MOST_SEED = 999_999_999
"""Greatest seed that `--seeds` takes."""
MOST_COUNT = 2**53
"""Greatest count that every JSON reader keeps exactly."""
CHUNK = 2000
"""Number of rows that are read at once; their columns are processed together and fit the processor's cache."""
Check = Callable[[str, Sequence[Any]], object]
"""Checks a column of this name; raises `BadCellError`."""
_LABEL = f"a text of at most {MOST_LABEL} printable characters"
_MOST_DIGITS = 15
"""Greatest length of a whole number in JSON, below `MOST_COUNT`."""
_SHOWN = 80
"""Characters of a value that a message shows."""


class BadCellError(ValueError):
    """A cell that no store has.

    Args:
        column: name of the column, or of a part of a cell.
        allowed: what is allowed.
        row: table and name of the row.
        value: the cell.
    """

    def __init__(self, column: str, allowed: str, row: str = "", value: object = None) -> None:
        super().__init__(f"{row}: {column}={shown(value)} must be {allowed}")
        self.column, self.allowed = column, allowed

    def at(self, row: str, value: object) -> BadCellError:
        """The same error with the name of the row and the value."""
        return BadCellError(self.column, self.allowed, row, value)


class TooLargeError(Exception):
    """A table is larger than the limit.

    Args:
        table: name of the table.
        what: what there is too much of.
    """

    def __init__(self, table: str, what: str = "rows") -> None:
        super().__init__(
            f"table {table} has more {what} than the limit for {most_flights()} flights; "
            f"the environment variable {MOST_FLIGHTS} raises the limit"
        )


def shown(value: object) -> str:
    """A value in a message: one line, escaped, shortened."""
    if isinstance(value, str | bytes):
        text = ascii(value[:_SHOWN])
        return text if len(value) <= _SHOWN else f"{text}... ({len(value)} long)"
    return repr(value)


def most_flights() -> int:
    """The greatest number of rows of a table.

    Raises:
        InputError: the environment variable is no positive whole number.
    """
    text = os.environ.get(MOST_FLIGHTS, "")
    if not text:
        return DEFAULT_MOST_FLIGHTS
    if not text.isdecimal() or not 0 < len(text) < 10 or int(text) < 1:
        raise InputError(f"environment: {MOST_FLIGHTS}={shown(text)} must be a whole number from 1 to 999999999")
    return int(text)


def texts(name: str, column: Sequence[Any]) -> int:
    """Check that every cell is a text; returns the number of characters.

    Raises:
        BadCellError: a cell is no text.
    """
    try:
        return len("".join(column))
    except TypeError:
        raise BadCellError(name, "a text") from None


def labels(name: str, column: Iterable[Any]) -> None:
    """Check that every cell is a name.

    Raises:
        BadCellError: a cell is no text, too long, or has a character that cannot be printed.
    """
    for text in set(column):
        if type(text) is not str or len(text) > MOST_LABEL or not text.isprintable():
            raise BadCellError(name, _LABEL)


def numbers(name: str, column: Sequence[Any], *, none: bool = False) -> None:
    """Check that every cell is a finite number; or NULL, if `none`.

    Raises:
        BadCellError: a cell is another value.
    """
    values = [value for value in column if value is not None] if none else column
    try:
        # a sum is the fastest check of types; it may be infinite although every number is finite
        fits = math.isfinite(sum(values)) or all(map(math.isfinite, values))
    except (TypeError, OverflowError):
        fits = False
    if not fits:
        raise BadCellError(name, "a finite number" + " or NULL" * none)


def seeds(name: str, column: Sequence[Any]) -> None:
    """Check that every cell is a seed.

    Raises:
        BadCellError: a cell is another value.
    """
    wholes(name, column, MOST_SEED)


def wholes(name: str, column: Sequence[Any], most: int = MOST_COUNT) -> None:
    """Check that every cell is a whole number from 0 to `most`.

    Raises:
        BadCellError: a cell is another value.
    """
    try:
        total = sum(column)  # the fastest check of types
        fits = isinstance(total, int) and min(column) >= 0 and (total <= most or max(column) <= most)
    except TypeError:
        fits = False
    if not fits:
        raise BadCellError(name, f"a whole number from 0 to {most}")


def flags(name: str, column: Iterable[Any]) -> None:
    """Check that every value is true or false.

    Raises:
        BadCellError: a value is neither.
    """
    if not set(map(type, column)) <= {bool}:
        raise BadCellError(name, "true or false")


def check_rows(table: str, rows: Sequence[Sequence[Any]], checks: Mapping[str, Check]) -> None:
    """Check rows column by column; an error names the first bad row by its first cell.

    Args:
        table: name of the table.
        rows: rows that begin with the columns of `checks`.
        checks: the check of each column by its name.

    Raises:
        BadCellError: a cell has a value that is not allowed.
    """
    try:
        _check(rows, checks)
    except BadCellError:
        for row in rows:
            try:
                _check([row], checks)
            except BadCellError as error:
                columns = list(checks)
                name = f"table {table}, {columns[0]} {shown(row[0])}"
                raise error.at(name, row[columns.index(error.column)]) from None
        raise


def _check(rows: Sequence[Sequence[Any]], checks: Mapping[str, Check]) -> None:
    for (name, check), column in zip(checks.items(), zip(*rows, strict=True), strict=False):
        check(name, column)


def chunks(connection: sqlite3.Connection, table: str, query: str) -> Iterator[list[tuple[Any, ...]]]:
    """The rows of a query on a table, in which every row of the table occurs once at most.

    Raises:
        TooLargeError: there are more rows than `most_flights`.
    """
    read, most = 0, most_flights()
    # a query that is left open, as when a row of it cannot be read, keeps the file open when the connection is closed
    with closing(connection.execute(query)) as cursor:
        while rows := cursor.fetchmany(CHUNK):
            read += len(rows)
            if read > most:
                raise TooLargeError(table)
            yield rows


def decoded(text: str) -> Any:
    """Parse JSON without NaN and infinity.

    Raises:
        ValueError: the text is no JSON, has a number that is not finite or too long, or is nested too deeply.
    """
    try:
        return _DECODER.decode(text)
    except RecursionError:
        raise ValueError("nested too deeply") from None


def _refused(constant: str) -> NoReturn:
    raise ValueError(f"{constant} is not allowed")


def _whole(text: str) -> int:
    if len(text) > _MOST_DIGITS:
        raise ValueError("a whole number is too long")
    return int(text)


_DECODER = json.JSONDecoder(parse_constant=_refused, parse_int=_whole)


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


class Planned(NamedTuple):
    """A planned flight.

    Attributes:
        key: key of the flight.
        mutant, situation, seed: subject, situation and seed of the flight.
        canary: whether the flight only proves that faults reach the drone.
        origin: origin of the outcome; None if it is unknown.
    """

    key: str
    mutant: str
    situation: str
    seed: int
    canary: bool = False
    origin: Origin | None = None


FLIGHT = {"key": texts, "mutant": labels, "situation": labels, "seed": seeds}
"""The check of each column that a flight and its plan have in common."""


def origins(connection: sqlite3.Connection) -> dict[int, Origin]:
    """The origins of all recorded flights by number.

    Raises:
        BadCellError: an origin has other parts than `Origin`.
        TooLargeError: there are more rows than `most_flights`.
    """
    found: dict[int, Origin] = {}
    for rows in chunks(connection, "origins", "SELECT id, parts FROM origins"):
        try:
            found.update(_parsed(rows))
        except BadCellError:
            for row in rows:
                _parsed([row])
            raise
    return found


def _parsed(rows: list[tuple[Any, ...]]) -> dict[int, Origin]:
    """The origins of rows; an error names the first row."""
    try:
        if max(len(parts) for _, parts in rows) > MOST_LINE:
            raise ValueError("too long")
        # one text for the decoder, whose call costs more than an origin
        listed = decoded(f"[{','.join(parts for _, parts in rows)}]")
        found = {number: Origin(**parts) for (number, _), parts in zip(rows, listed, strict=True)}
        "".join(part for origin in found.values() for part in origin)
    except (TypeError, ValueError) as error:
        number, parts = rows[0]
        allowed = f"a JSON object with the texts {', '.join(Origin._fields)}"
        raise BadCellError("parts", allowed, f"table origins, id {number}", parts) from error
    return found


def planned(connection: sqlite3.Connection) -> list[Planned]:
    """All recorded plans, ordered by key.

    Raises:
        BadCellError: a cell has a value that no plan has.
        TooLargeError: there are more rows than `most_flights`.
    """
    known, found = origins(connection), list[Planned]()
    query = "SELECT key, mutant, situation, seed, canary, origin FROM plan ORDER BY key"
    for rows in chunks(connection, "plan", query):
        check_rows("plan", rows, FLIGHT)
        found += [
            Planned(key, intern(mutant), intern(situation), seed, bool(canary), known.get(origin))
            for key, mutant, situation, seed, canary, origin in rows
        ]
    return found


def facts(connection: sqlite3.Connection) -> list[tuple[str, str]]:
    """Names and values of the table `meta`, ordered by name.

    Raises:
        BadCellError: a cell is no text.
        TooLargeError: there are more rows than `most_flights`.
    """
    found: list[tuple[str, str]] = []
    for rows in chunks(connection, "meta", "SELECT name, value FROM meta ORDER BY name"):
        check_rows("meta", rows, {"name": labels, "value": texts})
        found += rows
    return found


MOST_TRACK_BYTES: Final = 1 << 20
"""Greatest size of an unpacked track; the largest of the reference campaign has 29,316 bytes, of 209 s [bytes]."""
MOST_ENTRIES: Final = 1000
"""Greatest number of readings, violations or axes of an outcome."""
_TYPES: Mapping[str, tuple[type, ...]] = {"TEXT": (str,), "INTEGER": (int,), "REAL": (int, float)}
"""Python's types of a column's values; a truth value is no number here."""
_DIGEST = re.compile(r"[0-9a-f]{64}")
_ENDINGS = {ending.value for ending in Ending}
_RULES: Mapping[str, Callable[[Any], bool]] = {
    "ending": _ENDINGS.__contains__,
    "digest": lambda text: _DIGEST.fullmatch(text) is not None,
    "perceived_digest": lambda text: _DIGEST.fullmatch(text) is not None,
    "duration_s": lambda number: number >= 0,
}


def checked(row: object, track: bytes) -> Outcome:
    """The outcome of the values of `COLUMNS` and a packed track; a store that keeps it can be read.

    Raises:
        ValueError: a value is of another type, no finite number, or out of its range; the message names its column.
    """
    if not isinstance(row, list) or len(row) != len(COLUMNS):
        raise ValueError(f"an outcome is a list of {len(COLUMNS)} values")
    values = dict(zip(COLUMNS, row, strict=True))
    for name, value in values.items():
        if type(value) not in _TYPES[COLUMNS[name]] and not (name == "infected_at_s" and value is None):
            raise ValueError(f"{name} is no {COLUMNS[name]}")
        if isinstance(value, str) and (len(value) > MOST_CELL_BYTES or value.count("\n") >= MOST_ENTRIES):
            raise ValueError(f"{name} is too long")
    try:
        (outcome,) = Reader()([tuple(row)], [track])
    except TooLargeError as error:
        raise ValueError(str(error)) from error
    for name, is_right in _RULES.items():
        if not is_right(values[name]) and not (outcome.invalid and values[name] == ""):
            raise ValueError(f"{name} is out of its range")
    try:
        track_values(track, MOST_TRACK_BYTES // (4 * len(TRACK_COLUMNS)))
    except ValueError as error:
        raise ValueError(f"the track is {error}") from error
    return outcome
