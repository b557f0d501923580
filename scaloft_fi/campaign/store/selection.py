"""Read outcomes from a store: all, those with certain keys, or the current ones."""

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
"""Number of rows that are read at once; their columns are processed together and fit the processor's cache."""


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

Called once for each origin, which belongs to one mutant in one situation, and for each flight without an origin.
"""
Keep = Callable[[Record], bool]
_COLUMNS = (*COLUMNS, "key", "origin")
_KEY, _ORIGIN = _COLUMNS.index("key"), _COLUMNS.index("origin")
_flown = itemgetter(*map(_COLUMNS.index, Flown._fields))


def under(keys: set[str]) -> Keep:
    """Select the rows with these keys."""
    return lambda row: row[_KEY] in keys


def standing(stands: Stands) -> Keep:
    """Select the rows of current flights."""
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
    """The outcomes of the selected rows, each with its key, ordered by mutant, situation, seed, key.

    Args:
        connection: connection to the store.
        keep: whether a row is selected; None = all rows.
    """
    read = Reader()
    places = defaultdict[tuple[str, str], list[tuple[int, str, Outcome]]](list)
    # sorting here is faster than reading the rows in the order of an index
    cursor = connection.execute(f"SELECT {', '.join(_COLUMNS)} FROM outcomes")
    while rows := cursor.fetchmany(CHUNK):
        kept = list(filter(keep, rows)) if keep else rows
        for outcome, row in zip(read(kept), kept, strict=True):
            places[outcome.subject.id, outcome.situation].append((outcome.seed, row[_KEY], outcome))
    # keys are distinct
    return ((key, one) for _, key, one in chain.from_iterable(sorted(places[place]) for place in sorted(places)))
