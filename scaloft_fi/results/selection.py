"""What is read of a store's outcomes: those that stand, with all that is kept of them or as rulings."""

from __future__ import annotations

import sqlite3
from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence
from itertools import chain
from operator import itemgetter
from typing import NamedTuple

from scaloft_fi.collector import uncollected
from scaloft_fi.results.outcome import BASELINE, Outcome, Subject
from scaloft_fi.results.record import COLUMNS, SUBJECT, Reader, Row, violation_lines
from scaloft_fi.results.rulings import Court, Rulings

CHUNK = 2000
"""Rows that are read at once: columns of them are faster than rows, while they fit the processor's cache."""


class Flown(NamedTuple):
    """What an outcome is of.

    Attributes:
        key: its content hash.
        mutant, situation, seed: what was flown, where.
        truncated: why it was cut; empty for a whole flight.
        origin: number of what entered the key, by which `origins` has it; None where it was never planned.
    """

    key: str
    mutant: str
    situation: str
    seed: int
    truncated: str
    origin: int | None


Stand = Callable[[Flown], bool]
"""Whether a flight is wanted.

It is asked once for each origin, which belongs to one mutant in one situation, and of each flight without one.
"""
Keep = Callable[[Row], bool]
_COLUMNS = (*COLUMNS, "key", "origin")
_KEY = _COLUMNS.index("key")
_TRIED = (*Flown._fields, "invalid", "carried", "altered", "digest", "violations")


def under(keys: set[str]) -> Keep:
    """Keeps rows of `outcomes` under these keys."""
    return lambda row: row[_KEY] in keys


def standing(stand: Stand, columns: Sequence[str] = _COLUMNS) -> Keep:
    """Keeps rows of `columns` whose flights `stand`."""
    flown = itemgetter(*map(columns.index, Flown._fields))
    sort = itemgetter(*map(columns.index, ("origin", "truncated")))
    said: dict[Row, bool] = {}

    def keep(row: Row) -> bool:
        of = sort(row)
        known = said.get(of)
        if known is None or of[0] is None:
            known = said[of] = stand(Flown(*flown(row)))
        return known

    return keep


def outcomes(
    connection: sqlite3.Connection, keep: Keep | None = None, where: str = ""
) -> Iterator[tuple[str, Outcome]]:
    """The outcomes that are kept, each with its key, without their tracks, ordered by mutant, situation, seed, key.

    Args:
        connection: to the store.
        keep: says so of a row.
        where: says so to SQLite.
    """
    read = Reader()
    found = defaultdict[tuple[str, str], list[tuple[int, str, Outcome]]](list)
    with uncollected():
        # to sort here is faster than to have the rows looked up in the order of an index
        cursor = connection.execute(f"SELECT {', '.join(_COLUMNS)} FROM outcomes {where}")
        while rows := cursor.fetchmany(CHUNK):
            kept = list(filter(keep, rows)) if keep else rows
            for outcome, row in zip(read(kept), kept, strict=True):
                found[outcome.subject.id, outcome.situation].append((outcome.seed, row[_KEY], outcome))
    # keys are distinct
    return ((key, one) for _, key, one in chain.from_iterable(sorted(found[place]) for place in sorted(found)))


def rulings(connection: sqlite3.Connection, stand: Stand) -> Rulings:
    """What the whole flights that `stand` came to, without an outcome for each of them."""
    baselines = outcomes(connection, standing(stand), f"WHERE mutant = '{BASELINE}' AND truncated = ''")
    court = Court(outcome for _, outcome in baselines)
    keep, lines = standing(stand, _TRIED), violation_lines()
    with uncollected():
        where = f"WHERE mutant != '{BASELINE}' AND truncated = ''"
        cursor = connection.execute(f"SELECT {', '.join(_TRIED)} FROM outcomes {where}")
        while rows := cursor.fetchmany(CHUNK):
            kept = list(filter(keep, rows))
            for row, violations in zip(kept, lines.of([row[-1] for row in kept]), strict=True):
                _, mutant, situation, seed, _, _, invalid, carried, altered, digest, _ = row
                court.hear(mutant, situation, seed, (invalid, carried, altered, digest, violations))
    return court.rulings(_subjects(connection))


def _subjects(connection: sqlite3.Connection) -> dict[str, Subject]:
    """The mutants by their ids."""
    first = "SELECT min(id) FROM outcomes GROUP BY mutant"
    rows = connection.execute(f"SELECT {', '.join(SUBJECT)} FROM outcomes WHERE id IN ({first})")
    return {row[0]: Subject(*row) for row in rows}
