"""Records that are tables: CSV with a line of names, and a column for the time and for each signal."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterator, Mapping, Sequence
from itertools import islice
from pathlib import Path

import numpy as np

from scaloft_fi.document import read_text
from scaloft_fi.errors import InputError, did_you_mean
from scaloft_fi.outside.records.kind import RecordKind
from scaloft_fi.outside.records.source import MOST_MESSAGES, Series, Source, Timing, lacks, number, too_many

TABLE_BYTES = 256 << 20
"""Largest table."""


def read_table(path: Path, sources: Sequence[Source], timing: Timing) -> Mapping[Source, Series]:
    """Read the columns of a table; an empty cell says nothing new.

    Raises:
        InputError: as `Read`; or the time goes back.
    """
    head, rows = _opened(path)
    if not timing.column:
        raise InputError(
            f"{path}: a table needs the column of its time: time: {{column: NAME}} in the record's mapping"
        )
    if timing.column not in head:
        hint = did_you_mean(timing.column, head)
        raise InputError(f"{path}: the time needs the column {timing.column!r}, which the record does not have{hint}")
    for source in sources:
        if not source.column:
            raise InputError(f"{path}: signal {source.signal!r} must have a column, because the record is a table")
        if source.column not in head:
            raise lacks(path, source, "column", source.column, head)
    clock, places = head.index(timing.column), {source: head.index(source.column) for source in sources}
    found: dict[Source, tuple[list[float], list[float]]] = {source: ([], []) for source in sources}
    told, last_s = Source("time", column=timing.column), -math.inf
    for line, row in rows:
        if len(row) != len(head):
            raise InputError(f"{path}:{line}: {len(row)} cells must be {len(head)}, as in the first line")
        t_s = _parsed(path, told, line, row[clock]) * timing.unit_s
        if t_s < last_s:
            raise InputError(
                f"{path}:{line}: {timing.column}={row[clock]} must not be before the time of the line above"
            )
        last_s = t_s
        for source, place in places.items():
            cell = row[place]
            if cell:
                times, values = found[source]
                times.append(t_s)
                values.append(_parsed(path, source, line, cell))
    return {source: Series(np.array(times), np.array(values)) for source, (times, values) in found.items()}


def names_in_table(path: Path) -> Sequence[str]:
    """The columns of a table.

    Raises:
        InputError: the table cannot be read.
    """
    return _opened(path)[0]


def _opened(path: Path) -> tuple[list[str], Iterator[tuple[int, list[str]]]]:
    """The names of the columns, and each row with the number of its line."""
    reader = csv.reader(io.StringIO(read_text(path, TABLE_BYTES).removeprefix("\ufeff"), newline=""))
    try:
        head = [name.strip() for name in next(reader, [])]
    except csv.Error as error:
        raise InputError(f"{path}:1: not a table: {error}") from error
    if not any(head):
        raise InputError(f"{path}:1: the first line must have the names of the columns")
    twice = [name for place, name in enumerate(head) if name in head[:place]]
    if twice:
        raise InputError(f"{path}:1: column {twice[0]!r} occurs twice")

    def rows() -> Iterator[tuple[int, list[str]]]:
        try:
            for row in islice(reader, MOST_MESSAGES):
                if row:
                    yield reader.line_num, row
            if next(reader, None) is not None:
                raise too_many(path)
        except csv.Error as error:
            raise InputError(f"{path}:{reader.line_num}: not a table: {error}") from error

    return head, rows()


def _parsed(path: Path, source: Source, line: int, cell: str) -> float:
    try:
        value = float(cell)
    except ValueError:
        words = {"true": 1.0, "false": 0.0}
        if cell.strip().lower() not in words:
            said = f"{source.column}={cell[:40]!r} must be a number"
            raise InputError(f"{path}:{line}: signal {source.signal!r}: {said}") from None
        value = words[cell.strip().lower()]
    return value if math.isfinite(value) else number(path, source, f"line {line}", value)


TABLE = RecordKind(read_table, names_in_table)
