"""The tables of a campaign's store."""

from __future__ import annotations

import sqlite3
from contextlib import closing
from functools import cache
from hashlib import sha256

from scaloft_fi.campaign.store.cells import shown
from scaloft_fi.campaign.store.record import COLUMNS, to_row
from scaloft_fi.judge.outcome import Outcome

SCHEMA = 6
"""Version of the tables; a store of another version is refused."""
_TABLES = (
    "CREATE TABLE meta (name TEXT PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID",
    "CREATE TABLE origins (id INTEGER PRIMARY KEY, parts TEXT NOT NULL UNIQUE)",
    """CREATE TABLE plan (
        key TEXT PRIMARY KEY,
        mutant TEXT NOT NULL,
        situation TEXT NOT NULL,
        seed INTEGER NOT NULL,
        canary INTEGER NOT NULL,
        origin INTEGER REFERENCES origins (id)
    ) WITHOUT ROWID""",
    "CREATE TABLE tracks (id INTEGER PRIMARY KEY, sha256 BLOB NOT NULL UNIQUE, track BLOB NOT NULL)",
    f"""CREATE TABLE outcomes (
        id INTEGER PRIMARY KEY,
        key TEXT NOT NULL UNIQUE,
        origin INTEGER REFERENCES origins (id),
        track INTEGER REFERENCES tracks (id),
        {", ".join(f"{name} {kind}" + " NOT NULL" * (kind != "REAL") for name, kind in COLUMNS.items())}
    )""",
    "CREATE INDEX outcomes_by_flight ON outcomes (mutant, situation, seed, key, origin)",
    "CREATE INDEX invalid_outcomes ON outcomes (key) WHERE invalid != ''",
)


def create(connection: sqlite3.Connection) -> None:
    """Create the tables of a new store inside the caller's transaction."""
    for statement in _TABLES:
        connection.execute(statement)
    connection.execute(f"PRAGMA user_version={SCHEMA}")


def deviation(connection: sqlite3.Connection) -> str:
    """How the tables of a file differ from the tables of a store, in words; empty if they are equal.

    A view or a trigger in the file could run for ever, so nothing of the file may be queried before this check.
    """
    found, expected = _entries(connection), _expected()
    for entry in sorted(found - expected, key=repr):
        return f"it has the {entry[0]} {shown(entry[1])}, which scaloft-fi does not make"
    for entry in sorted(expected - found):
        return f"it lacks the {entry[0]} {entry[1]!r}"
    return ""


@cache
def _expected() -> frozenset[tuple[str, ...]]:
    with closing(sqlite3.connect(":memory:", isolation_level=None)) as connection:
        create(connection)
        return _entries(connection)


def _entries(connection: sqlite3.Connection) -> frozenset[tuple[str, ...]]:
    return frozenset(connection.execute("SELECT type, name, tbl_name, sql FROM sqlite_master"))


def insert(connection: sqlite3.Connection, key: str, outcome: Outcome) -> bool:
    """Write an outcome unless its key has a valid one; returns whether anything was written."""
    row = {"key": key, "track": _track(connection, outcome.track), **dict(zip(COLUMNS, to_row(outcome), strict=True))}
    return connection.execute(_INSERT, row).rowcount > 0


def _track(connection: sqlite3.Connection, track: bytes) -> int | None:
    """The number of a track; flights with equal tracks share one row.  None for an empty track."""
    if not track:
        return None
    digest = sha256(track).digest()
    connection.execute("INSERT INTO tracks (sha256, track) VALUES (?, ?) ON CONFLICT DO NOTHING", (digest, track))
    return int(connection.execute("SELECT id FROM tracks WHERE sha256 = ?", (digest,)).fetchone()[0])


_INSERT = f"""
INSERT INTO outcomes (key, origin, track, {", ".join(COLUMNS)})
VALUES (:key, (SELECT origin FROM plan WHERE key = :key), :track, {", ".join(f":{name}" for name in COLUMNS)})
ON CONFLICT (key) DO UPDATE SET track = excluded.track, {", ".join(f"{name} = excluded.{name}" for name in COLUMNS)}
WHERE outcomes.invalid != '' AND outcomes.invalid != excluded.invalid
"""
