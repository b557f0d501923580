"""Checks of the cells of a store, a column at a time: a store may come from anywhere, and SQLite checks no types."""

from __future__ import annotations

import json
import math
import os
import sqlite3
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import closing
from typing import Any, NoReturn

from scaloft_fi.errors import InputError

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
