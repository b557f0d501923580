"""The outcomes that are read of a store: all, those under some keys, or those of flights that stand."""

from __future__ import annotations

import sqlite3
from collections import defaultdict
from collections.abc import Callable, Iterator
from itertools import chain
from operator import itemgetter
from typing import NamedTuple

from scaloft_fi.campaign.store.record import COLUMNS, Reader, Record
from scaloft_fi.judge.outcome import Outcome

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


Stands = Callable[[Flown], bool]
"""Whether a flight is wanted.

It is asked once for each origin, which belongs to one mutant in one situation, and of each flight without one.
"""
Keep = Callable[[Record], bool]
_COLUMNS = (*COLUMNS, "key", "origin")
_KEY, _ORIGIN = _COLUMNS.index("key"), _COLUMNS.index("origin")
_flown = itemgetter(*map(_COLUMNS.index, Flown._fields))


def under(keys: set[str]) -> Keep:
    """Keeps the rows under these keys."""
    return lambda row: row[_KEY] in keys


def standing(stands: Stands) -> Keep:
    """Keeps the rows of flights that stand."""
    answers: dict[int, bool] = {}

    def keep(row: Record) -> bool:
        number = row[_ORIGIN]
        answer = answers.get(number)
        if answer is None:
            answer = stands(Flown(*_flown(row)))
            if number is not None:
                answers[number] = answer
        return answer

    return keep


def outcomes(connection: sqlite3.Connection, keep: Keep | None = None) -> Iterator[tuple[str, Outcome]]:
    """The outcomes of the rows that are kept, each with its key, ordered by mutant, situation, seed, key.

    Args:
        connection: to the store.
        keep: whether a row is kept; all are when None.
    """
    read = Reader()
    places = defaultdict[tuple[str, str], list[tuple[int, str, Outcome]]](list)
    # to sort here is faster than to have the rows looked up in the order of an index
    cursor = connection.execute(f"SELECT {', '.join(_COLUMNS)} FROM outcomes")
    while rows := cursor.fetchmany(CHUNK):
        kept = list(filter(keep, rows)) if keep else rows
        for outcome, row in zip(read(kept), kept, strict=True):
            places[outcome.subject.id, outcome.situation].append((outcome.seed, row[_KEY], outcome))
    # keys are distinct
    return ((key, one) for _, key, one in chain.from_iterable(sorted(places[place]) for place in sorted(places)))
