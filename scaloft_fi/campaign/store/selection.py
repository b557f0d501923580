"""Read outcomes from a store: all, those with certain keys, or the current ones."""

from __future__ import annotations

import sqlite3
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import chain, repeat
from operator import itemgetter
from typing import Any, NamedTuple

from scaloft_fi.campaign.store.cells import MOST_BYTES, MOST_CELL_BYTES, BadCellError, check_rows, chunks, shown
from scaloft_fi.campaign.store.record import COLUMNS, Reader, Record
from scaloft_fi.campaign.store.tables import FLIGHT
from scaloft_fi.judge.outcome import Outcome


class Flown(NamedTuple):
    """A flight with an outcome.

    Attributes:
        key: key of the flight.
        mutant, situation, seed: subject, situation and seed of the flight.
        origin: number of its origin in `Store.origins`; None for a flight that was never planned.
    """

    key: str
    mutant: str
    situation: str
    seed: int
    origin: int | None


Stands = Callable[[Flown], bool]
"""Whether a flight is current.

Called once for each mutant, situation and origin, and for each flight without an origin.
"""
Keep = Callable[[Record], bool]
_COLUMNS = (*COLUMNS, "key", "origin")
_KEY, _ORIGIN = _COLUMNS.index("key"), _COLUMNS.index("origin")
_flown = itemgetter(*map(_COLUMNS.index, Flown._fields))
_place = itemgetter(*map(_COLUMNS.index, ("mutant", "situation", "origin")))


def under(keys: set[str]) -> Keep:
    """Select the rows with these keys."""
    return lambda row: row[_KEY] in keys


def standing(stands: Stands) -> Keep:
    """Select the rows of current flights."""
    answers: dict[tuple[Any, ...], bool] = {}

    def keep(row: Record) -> bool:
        place = _place(row)
        answer = answers.get(place)
        if answer is None:
            flight = Flown(*_flown(row))
            if tuple(map(type, flight[1:3])) != (str, str) or type(flight.key) is not str:
                check_rows("outcomes", [flight], FLIGHT)
            answer = stands(flight)
            if flight.origin is not None:
                answers[place] = answer
        return answer

    return keep


_ALL = f"SELECT {', '.join(Flown._fields)} FROM outcomes ORDER BY mutant, situation, seed, key"
_ONE_EACH = (
    "SELECT min(key), mutant, situation, min(seed), origin FROM outcomes"
    " GROUP BY mutant, situation, origin ORDER BY mutant, situation, origin"
)


def flown(connection: sqlite3.Connection, *, one_each: bool = False) -> list[Flown]:
    """The flights with an outcome, ordered by mutant, situation, seed, key; or one for each mutant, situation, origin.

    Raises:
        BadCellError: a cell has a value that no flight has.
        TooLargeError: there are more rows than `most_flights`.
    """
    found: list[Flown] = []
    for rows in chunks(connection, "outcomes", _ONE_EACH if one_each else _ALL):
        check_rows("outcomes", rows, FLIGHT)
        found += map(Flown._make, rows)
    return found


def checked(read: Reader, rows: Sequence[Record], tracks: Iterable[bytes] = repeat(b"")) -> list[Outcome]:
    """The outcomes of rows with `_COLUMNS`; an error names the first bad row.

    Raises:
        BadCellError: a cell has a value that no outcome has.
        TooLargeError: the texts are larger than the limit.
    """
    try:
        return read(rows, tracks)
    except BadCellError:
        for row in rows:
            try:
                Reader()([row])
            except BadCellError as error:
                value = row[_COLUMNS.index(error.column)]
                raise error.at(f"table outcomes, key {shown(row[_KEY])}", value) from None
        raise


def outcomes(connection: sqlite3.Connection, keep: Keep | None = None) -> Iterator[tuple[str, Outcome]]:
    """The outcomes of the selected rows, each with its key, ordered by mutant, situation, seed, key.

    Args:
        connection: connection to the store.
        keep: whether a row is selected; None = all rows.

    Raises:
        BadCellError: a cell has a value that no outcome has.
        TooLargeError: there are more rows or larger texts than the limit.
    """
    read = Reader()
    places = defaultdict[tuple[str, str], list[tuple[int, str, Outcome]]](list)
    # sorting here is faster than reading the rows in the order of an index
    connection.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, MOST_CELL_BYTES)
    try:
        for rows in chunks(connection, "outcomes", f"SELECT {', '.join(_COLUMNS)} FROM outcomes"):
            kept = list(filter(keep, rows)) if keep else rows
            for outcome, row in zip(checked(read, kept), kept, strict=True):
                places[outcome.subject.id, outcome.situation].append((outcome.seed, row[_KEY], outcome))
    except (sqlite3.DataError, sqlite3.OperationalError) as error:
        raise _located(connection) or error from error
    finally:
        connection.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, MOST_BYTES)
    # keys are distinct
    return ((key, one) for _, key, one in chain.from_iterable(sorted(places[place]) for place in sorted(places)))


def tracked(connection: sqlite3.Connection, read: Reader, key: str) -> Outcome | None:
    """The outcome with this key and its track; None without one.

    Raises:
        BadCellError: a cell has a value that no outcome has.
    """
    track = "(SELECT tracks.track FROM tracks WHERE tracks.id = outcomes.track)"
    query = f"SELECT {', '.join(_COLUMNS)}, {track} FROM outcomes WHERE key = ?"
    row = connection.execute(query, (key,)).fetchone()
    if row is None:
        return None
    if not isinstance(row[-1], bytes | None):
        raise BadCellError("track", "a packed track", f"table outcomes, key {shown(key)}", row[-1])
    return checked(read, [row], [row[-1] or b""])[0]


def _located(connection: sqlite3.Connection) -> BadCellError | None:
    """The first cell of an outcome that SQLite cannot give, because it is too large or no UTF-8."""
    for rows in chunks(connection, "outcomes", "SELECT id FROM outcomes"):
        for (number,) in rows:
            for column in _COLUMNS:
                try:
                    connection.execute(f"SELECT {column} FROM outcomes WHERE id = ?", (number,)).fetchone()
                except (sqlite3.DataError, sqlite3.OperationalError):
                    allowed = f"UTF-8 text of at most {MOST_CELL_BYTES} bytes"
                    return BadCellError(column, allowed, f"table outcomes, id {number}")
    return None
