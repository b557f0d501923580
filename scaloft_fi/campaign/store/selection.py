"""What is read of a store's outcomes: those that stand, with all that is kept of them or as rulings."""

from __future__ import annotations

import sqlite3
from collections import defaultdict
from collections.abc import Callable, Iterator
from itertools import chain
from operator import itemgetter
from typing import NamedTuple

from scaloft_fi.campaign.store.record import COLUMNS, SUBJECT, Reader, Record, violation_lines
from scaloft_fi.collector import uncollected
from scaloft_fi.judge.outcome import BASELINE, Outcome, Subject
from scaloft_fi.judge.rulings import Court, Rulings

CHUNK = 2000
"""Rows that are read at once: columns of them are faster than rows, while they fit the processor's cache."""


class Flown(NamedTuple):
    """What an outcome is of.

    Attributes:
        key: its content hash.
        mutant, situation, seed: what was flown, where.
        origin: number of what entered the key, by which `origins` has it; None where it was never planned.
    """

    key: str
    mutant: str
    situation: str
    seed: int
    origin: int | None


Stand = Callable[[Flown], bool]
"""Whether a flight is wanted.

It is asked once for each origin, which belongs to one mutant in one situation, and of each flight without one.
"""
Keep = Callable[[Record], bool]
_COLUMNS = (*COLUMNS, "key", "origin")
_KEY = _COLUMNS.index("key")
_TRIED = ("mutant", "situation", "seed", "invalid", "carried", "altered", "digest", "violations", "origin")
"""What a flight is ruled by; the key follows where there is no origin that would stand for it."""
_VIOLATIONS = _TRIED.index("violations")


def under(keys: set[str]) -> Keep:
    """Keeps rows of `outcomes` under these keys."""
    return lambda row: row[_KEY] in keys


def standing(stand: Stand, flown: Callable[[Record], Flown], origin: int) -> Keep:
    """Keeps rows whose flights `stand`.

    Args:
        stand: says so of a flight.
        flown: the flight of a row.
        origin: where a row has the flight's.
    """
    said: dict[int, bool] = {}

    def keep(row: Record) -> bool:
        number = row[origin]
        known = said.get(number)
        if known is None:
            known = stand(flown(row))
            if number is not None:
                said[number] = known
        return known

    return keep


def _flown(row: Record) -> Flown:
    return Flown(*_pick(row))


_pick = itemgetter(*map(_COLUMNS.index, Flown._fields))


def _tried(row: Record) -> Flown:
    mutant, situation, seed, *_, origin, key = row
    return Flown(key, mutant, situation, seed, origin)


def those_that(stand: Stand) -> Keep:
    """Keeps rows of `outcomes` whose flights `stand`."""
    return standing(stand, _flown, _COLUMNS.index("origin"))


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
    """What the flights that `stand` came to, without an outcome for each of them."""
    baselines = outcomes(connection, those_that(stand), f"WHERE mutant = '{BASELINE}'")
    court = Court(outcome for _, outcome in baselines)
    keep, lines = standing(stand, _tried, _TRIED.index("origin")), violation_lines()
    with uncollected():
        columns = f"{', '.join(_TRIED)}, CASE WHEN origin IS NULL THEN key END"
        cursor = connection.execute(f"SELECT {columns} FROM outcomes WHERE mutant != '{BASELINE}'")
        while rows := cursor.fetchmany(CHUNK):
            kept = list(filter(keep, rows))
            for row, violations in zip(kept, lines.of([row[_VIOLATIONS] for row in kept]), strict=True):
                mutant, situation, seed, invalid, carried, altered, digest, *_ = row
                court.hear(mutant, situation, seed, (invalid, carried, altered, digest, violations))
    return court.rulings(_subjects(connection))


def _subjects(connection: sqlite3.Connection) -> dict[str, Subject]:
    """The mutants by their ids."""
    first = "SELECT min(id) FROM outcomes GROUP BY mutant"
    rows = connection.execute(f"SELECT {', '.join(SUBJECT)} FROM outcomes WHERE id IN ({first})")
    return {row[0]: Subject(*row) for row in rows}
