"""Outcomes as rows of the store's tables and back; every cell is checked, because a store may come from anywhere."""

from __future__ import annotations

import hashlib
import json
import math
import os
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import MISSING, fields
from itertools import chain, repeat, starmap
from operator import attrgetter
from sys import intern
from typing import Any, Generic, NamedTuple, NoReturn, TypeVar

from scaloft_fi.errors import InputError, shown
from scaloft_fi.judge.outcome import Outcome, Subject, Violation
from scaloft_fi.judge.requirement import Kind, Reading
from scaloft_fi.judge.status import Brief

MOST_FLIGHTS = "SCALOFT_MOST_FLIGHTS"
"""Name of the environment variable that raises the limit of rows."""
DEFAULT_MOST_FLIGHTS = 250_000
"""Default greatest number of rows of a table; a report of 250,000 flights takes about 850 MiB."""
MOST_LABEL = 256
"""Greatest length of a name."""
MOST_LINE = 4096
"""Greatest length of a line of JSON in a cell."""
MOST_SEED = 999_999_999
"""Greatest seed that `--seeds` takes."""
MOST_COUNT = 2**53
"""Greatest count that every JSON reader keeps exactly."""
_MOST_DIGITS = 15
"""Greatest length of a whole number in JSON, below `MOST_COUNT`."""


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
        self.column, self.allowed, self.value = column, allowed, value


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


class Cell(NamedTuple):
    """What a column may hold.

    Attributes:
        sql: type in SQL.
        allowed: what is allowed, in words.
        kinds: types of its values.
        test: whether a value of these types is allowed; None: each is.
    """

    sql: str
    allowed: str
    kinds: frozenset[type]
    test: Callable[[Any], bool] | None = None

    def holds(self, column: Collection[Any]) -> bool:
        """Whether the column may hold these values; equal values are tested once."""
        if not self.kinds.issuperset(map(type, column)):
            return False
        return self.test is None or all(map(self.test, {*column} - {None}))


def _whole(most: int) -> Cell:
    return Cell("INTEGER", f"a whole number from 0 to {most}", frozenset({int}), lambda value: 0 <= value <= most)


_KINDS = {kind.value: kind for kind in Kind}
TEXT = Cell("TEXT", "a text", frozenset({str}))
LABEL = Cell(
    "TEXT",
    f"a text of at most {MOST_LABEL} printable characters",
    frozenset({str}),
    lambda value: len(value) <= MOST_LABEL and value.isprintable(),
)
NUMBER = Cell("REAL", "a finite number", frozenset({float, int}), math.isfinite)
OPTIONAL = Cell("REAL", "a finite number or NULL", NUMBER.kinds | {type(None)}, math.isfinite)
WHOLE, SEED = _whole(MOST_COUNT), _whole(MOST_SEED)
FLAG = Cell("", "true or false", frozenset({bool}))
KIND = Cell("", " or ".join(_KINDS), frozenset({str}), _KINDS.__contains__)
FLIGHT: Mapping[str, Cell] = {"key": TEXT, "mutant": LABEL, "situation": LABEL, "seed": SEED}
"""The columns that a flight and its plan have in common."""


def check_rows(table: str, rows: Sequence[Sequence[Any]], cells: Mapping[str, Cell], named_by: int = 0) -> None:
    """Check rows column by column; an error names a bad row.

    Args:
        table: name of the table.
        rows: rows that begin with the columns of `cells`.
        cells: what each column may hold, by its name.
        named_by: place of the cell that names a row.

    Raises:
        BadCellError: a cell has a value that is not allowed.
    """
    for (name, cell), column in zip(cells.items(), zip(*rows, strict=True), strict=False):
        for number, value in enumerate(() if cell.holds(column) else column):
            if not cell.holds([value]):
                row = f"table {table}, {'key' if named_by else next(iter(cells))} {shown(rows[number][named_by])}"
                raise BadCellError(name, cell.allowed, row, value)


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


def _short_whole(text: str) -> int:
    if len(text) > _MOST_DIGITS:
        raise ValueError("a whole number is too long")
    return int(text)


_DECODER = json.JSONDecoder(parse_constant=_refused, parse_int=_short_whole)


Record = tuple[Any, ...]
"""Values of `COLUMNS`."""

SUBJECT = ("mutant", "guideword", "parameter", "magnitude")
"""The columns of the subject."""
_LINES = ("readings", "violations", "realised")
COLUMNS: Mapping[str, Cell] = {
    **dict.fromkeys((*SUBJECT, "situation"), LABEL),
    "seed": SEED,
    "ending": LABEL,
    "invalid": TEXT,
    "carried": WHOLE,
    "altered": WHOLE,
    "infected_at_s": OPTIONAL,
    "struck": LABEL,
    "duration_s": NUMBER,
    **dict.fromkeys(("digest", "perceived_digest", "stack_error", *_LINES), TEXT),
}
"""The columns and what they hold: an outcome without its track.

The last three columns hold one entry per line, a JSON list of its fields in order.  Most lines occur in many flights,
and `_Lines` parses a line once.
"""
KEY = len(COLUMNS)
"""Place of the key in a row of the store, which begins with `COLUMNS`."""
RULED = (*SUBJECT, *Brief._fields[1:])
"""The columns by which a mutant's flight is ruled beside its baseline."""

_READING: Mapping[str, Cell] = {
    "requirement": LABEL,
    "kind": KIND,
    "rho": NUMBER,
    "violated_at_s": OPTIONAL,
    "triggered": WHOLE,
    "open": FLAG,
}
_VIOLATION: Mapping[str, Cell] = {
    "requirement": LABEL,
    "kind": KIND,
    **dict.fromkeys(("t_s", "x", "y", "z"), NUMBER),
    "struck": LABEL,
}
"""The fields of the entries of `readings` and of `violations`, in order."""

MOST_REASON = 10_000
"""Greatest length of an error's text in a store; a longer text is cut."""
_PER_FLIGHT = 512
"""Greatest mean number of characters of a flight's texts, and of its lines that no other flight has."""
_TEXTS = ("invalid", "digest", "perceived_digest", "stack_error")
_FIELDS = tuple(field.name for field in fields(Outcome))
_LEFT_OUT = {field.name: repeat(field.default) for field in fields(Outcome) if field.default is not MISSING}


def to_row(outcome: Outcome) -> Record:
    """The values of `COLUMNS`; the texts of errors are cut to `MOST_REASON` characters.

    Raises:
        ValueError: a number in it is not finite.
    """
    subject = outcome.subject
    made: dict[str, Any] = {
        **dict(zip(SUBJECT, (subject.id, subject.guideword, subject.parameter, subject.magnitude), strict=True)),
        "invalid": outcome.invalid[:MOST_REASON],
        "stack_error": outcome.stack_error[:MOST_REASON],
        "readings": _lines([getattr(reading, name) for name in _READING] for reading in outcome.readings),
        "violations": _lines([getattr(one, name) for name in _VIOLATION] for one in outcome.violations),
        "realised": _lines(outcome.realised),
    }
    return tuple(made[name] if name in made else getattr(outcome, name) for name in COLUMNS)


def _lines(entries: Iterable[Sequence[Any]]) -> str:
    return "\n".join(json.dumps(entry, allow_nan=False) for entry in entries)


class Reader:
    """Makes outcomes from rows, whose cells it checks; equal parts of outcomes are one object.

    Args:
        columns: the columns with which a row begins, a key after them; what they leave out is empty in the outcomes.
    """

    def __init__(self, columns: Collection[str] = tuple(COLUMNS)) -> None:
        self._columns = {name: COLUMNS[name] for name in columns}
        self._subjects = _Subjects()
        self._readings = _Lines("readings", _READING, _reading)
        self._violations = _Lines("violations", _VIOLATION, _violation, attrgetter("requirement"))
        self._realised = _Lines("realised", {"axis": LABEL, "came true": FLAG}, lambda axis, met: (intern(axis), met))
        self._characters, self._most_characters = 0, most_flights() * _PER_FLIGHT

    def __call__(self, rows: Sequence[Record], tracks: Iterable[bytes] = repeat(b"")) -> list[Outcome]:
        """The outcomes of rows, with their tracks; raises the errors of `_parts`."""
        if not rows:
            return []
        made = {**_LEFT_OUT, **self._parts(rows), "track": tracks}
        return list(map(Outcome, *(made[name] for name in _FIELDS)))

    def brief(self, rows: Sequence[Record]) -> Iterable[Brief]:
        """The rows of `RULED` as rulings need them; raises the errors of `_parts`."""
        made = self._parts(rows) if rows else dict.fromkeys(Brief._fields, ())
        return map(Brief._make, zip(*(made[name] for name in Brief._fields), strict=True))

    def _parts(self, rows: Sequence[Record]) -> dict[str, Iterable[Any]]:
        """What the fields of outcomes have, field by field.

        Raises:
            BadCellError: a cell has a value that `to_row` does not make.
            TooLargeError: the texts are larger than the limit.
        """
        check_rows("outcomes", rows, self._columns, len(self._columns))
        columns = dict(zip(self._columns, zip(*rows, strict=True), strict=False))
        self._characters += sum(sum(map(len, columns[name])) for name in _TEXTS if name in columns)
        if self._characters > self._most_characters:
            raise TooLargeError("outcomes", "text")
        made: dict[str, Iterable[Any]] = {
            **columns,
            "subject": map(self._subjects.__getitem__, zip(*(columns[name] for name in SUBJECT), strict=True)),
            **{name: map(intern, columns[name]) for name in ("situation", "ending", "struck") if name in columns},
        }
        for lines in (self._readings, self._violations, self._realised):
            if lines.name not in columns:
                continue
            try:
                made[lines.name] = lines.of(columns[lines.name])
            except BadCellError as error:
                key = rows[columns[lines.name].index(error.value)][len(self._columns)]
                raise BadCellError(
                    lines.name, error.allowed, f"table outcomes, key {shown(key)}", error.value
                ) from None
        return made


class _Subjects(dict[Record, Subject]):
    """Subjects by their columns; each subject is made once."""

    def __missing__(self, row: Record) -> Subject:
        subject = self[row] = Subject(*map(intern, row))
        return subject


T = TypeVar("T")


class _Lines(Generic[T]):
    """Entries by their lines; each line is parsed once.

    Args:
        name: name of the column.
        cells: what each field of an entry may hold, by its name.
        make: makes an entry from its fields.
        once: the property of an entry that no other entry of the same cell has; None if any may repeat.
    """

    def __init__(
        self, name: str, cells: Mapping[str, Cell], make: Callable[..., T], once: Callable[[T], str] | None = None
    ) -> None:
        self.name, self._cells, self._make, self._once = name, cells, make, once
        self._lines: dict[str, T] = {}
        self._characters, self._most_characters = 0, most_flights() * _PER_FLIGHT

    def of(self, column: Sequence[str]) -> Iterable[tuple[T, ...]]:
        """The entries of each text of a column; equal texts are split once.

        Raises:
            BadCellError: a line is no entry.
            TooLargeError: the lines are larger than the limit.
        """
        texts, read = set(column), dict[str, tuple[T, ...]]()
        try:
            split = {text: text.split("\n") for text in texts if text}
            self._learn(list(set(chain.from_iterable(split.values())).difference(self._lines)))
            for text in texts:
                entries = read[text] = tuple(map(self._lines.__getitem__, split.get(text, ())))
                if self._once and len(entries) > 1 and len(set(map(self._once, entries))) < len(entries):
                    raise ValueError("an entry occurs twice")
        except (TypeError, ValueError) as error:
            for text in texts if len(texts) > 1 else ():  # which of them
                self.of([text])
            what = f": {error.column} {error.allowed}" if isinstance(error, BadCellError) else ""
            allowed = f"one JSON list a line, as `run` writes them{what}"
            raise BadCellError(self.name, allowed, value=column[0]) from error
        return map(read.__getitem__, column)

    def _learn(self, lines: Sequence[str]) -> None:
        for start in range(0, len(lines), _AT_ONCE):
            some = lines[start : start + _AT_ONCE]
            self._characters += sum(map(len, some))
            if self._characters > self._most_characters:
                raise TooLargeError("outcomes", self.name)
            if max(map(len, some)) > MOST_LINE:
                raise ValueError("a line is too long")
            # one text for the decoder, whose call costs more than a line
            entries = decoded(f"[{','.join(some)}]")
            if set(map(type, entries)) != {list}:
                raise ValueError("a line is no list")
            check_rows("outcomes", entries, self._cells)
            self._lines.update(zip(some, starmap(self._make, entries), strict=True))


_AT_ONCE = 1000
"""Number of lines that are parsed at once; JSON may take 64 bytes of memory for each character."""


def _reading(name: str, kind: str, *rest: Any) -> Reading:
    return Reading(intern(name), _KINDS[kind], *rest)


def _violation(name: str, kind: str, t_s: float, x: float, y: float, z: float, struck: str) -> Violation:
    return Violation(intern(name), _KINDS[kind], t_s, x, y, z, intern(struck))


class Origin(NamedTuple):
    """Hashes of the parts; empty for a part that does not affect the flight.

    Attributes:
        sim: the documents of `sim/` that decide every flight.
        requirements: the requirements.
        code: the modules that fly and judge every flight.
        mutant: the mutant; empty for the baseline.
        situation: the values that the situation sets in the world.
        realised: for a baseline, the predicates of the situation's values.
        operator: for a mutant, the modules that only its operator needs.
        platform: not a hash: differences of an earlier platform that made a stale flight; empty for other flights.
    """

    sim: str
    requirements: str
    code: str
    mutant: str
    situation: str
    realised: str = ""
    operator: str = ""
    platform: str = ""

    def key(self, seed: int) -> str:
        """The key of the flight with this seed."""
        parts = [f"{name}={value}" for name, value in zip(self._fields, self, strict=True) if value]
        return hashlib.sha256("\n".join([*parts, f"seed={seed}"]).encode()).hexdigest()

    def changed(self, now: Origin) -> tuple[str, ...]:
        """Names of the parts that differ in `now`."""
        return tuple(name for name in self._fields if getattr(self, name) != getattr(now, name))


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
