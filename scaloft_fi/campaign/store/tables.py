"""Read the tables of plans, origins and facts; every cell is checked."""

from __future__ import annotations

import sqlite3
from sys import intern
from typing import Any, NamedTuple

from scaloft_fi.campaign.store.cells import (
    MOST_LINE,
    BadCellError,
    check_rows,
    chunks,
    decoded,
    labels,
    seeds,
    texts,
)
from scaloft_fi.campaign.store.origin import Origin


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
