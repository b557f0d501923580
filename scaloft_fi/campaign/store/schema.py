"""The tables of a campaign's store, and what brings those of an earlier version to them."""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Callable
from dataclasses import replace
from hashlib import sha256

from scaloft_fi.campaign.store.record import COLUMNS, from_json, to_row
from scaloft_fi.judge.outcome import Outcome


def migrate(connection: sqlite3.Connection, schema: int) -> None:
    """Bring the tables of a store, new ones too, from `schema` to `SCHEMA`, inside the caller's transaction."""
    for step in _STEPS[schema:]:
        step(connection)
    connection.execute(f"PRAGMA user_version={SCHEMA}")


def _statements(text: str) -> Callable[[sqlite3.Connection], None]:
    def run(connection: sqlite3.Connection) -> None:
        for statement in filter(str.strip, text.split(";")):
            connection.execute(statement)

    return run


def insert(connection: sqlite3.Connection, key: str, outcome: Outcome) -> bool:
    """Keep an outcome unless there is one that counts under its key; returns whether anything was written."""
    row = {"key": key, "track": _track(connection, outcome.track), **dict(zip(COLUMNS, to_row(outcome), strict=True))}
    return connection.execute(_INSERT, row).rowcount > 0


def _track(connection: sqlite3.Connection, track: bytes) -> int | None:
    """The number of a track, which is kept once however many flights have it; None for an empty one."""
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


def _columns_from_json(connection: sqlite3.Connection) -> None:
    _statements(_WITH_COLUMNS)(connection)
    for key, text, track in connection.execute("SELECT key, outcome, track FROM old_outcomes"):
        values = json.loads(text)
        insert(connection, key, replace(from_json(values), track=track))
        connection.execute("UPDATE outcomes SET truncated = ? WHERE key = ?", (values.get("truncated", ""), key))
    connection.execute("DROP TABLE old_outcomes")


def _whole_flights(connection: sqlite3.Connection) -> None:
    """Drop what was flown, or planned, only up to a first kill."""
    for number, text in connection.execute("SELECT id, parts FROM origins").fetchall():
        parts = json.loads(text)
        if parts.pop("cutting"):
            connection.execute("DELETE FROM origins WHERE id = ?", (number,))
        else:
            connection.execute("UPDATE origins SET parts = ? WHERE id = ?", (json.dumps(parts), number))
    _statements(_WHOLE)(connection)


_TABLE = f"""
CREATE TABLE outcomes (
    id INTEGER PRIMARY KEY,
    key TEXT NOT NULL UNIQUE,
    origin INTEGER REFERENCES origins (id),
    track INTEGER REFERENCES tracks (id),
    {", ".join(f"{name} {kind}" + " NOT NULL" * (kind != "REAL") for name, kind in COLUMNS.items())}
);
CREATE INDEX outcomes_by_flight ON outcomes (mutant, situation, seed, key, origin);
CREATE INDEX invalid_outcomes ON outcomes (key) WHERE invalid != '';
"""
_WITH_COLUMNS = f"""
ALTER TABLE outcomes RENAME TO old_outcomes;
DROP INDEX outcomes_by_flight;
CREATE TABLE tracks (id INTEGER PRIMARY KEY, sha256 BLOB NOT NULL UNIQUE, track BLOB NOT NULL);
{_TABLE}
ALTER TABLE outcomes ADD COLUMN truncated TEXT NOT NULL DEFAULT ''
"""
_KEPT = ", ".join(("id", "key", "origin", "track", *COLUMNS))
_WHOLE = f"""
DELETE FROM plan WHERE origin IS NOT NULL AND origin NOT IN (SELECT id FROM origins);
DELETE FROM plan WHERE key IN (SELECT key FROM outcomes WHERE truncated != '');
ALTER TABLE outcomes RENAME TO old_outcomes;
DROP INDEX outcomes_by_flight;
DROP INDEX invalid_outcomes;
{_TABLE}
INSERT INTO outcomes ({_KEPT}) SELECT {_KEPT} FROM old_outcomes WHERE truncated = '';
DELETE FROM tracks WHERE id IN (SELECT track FROM old_outcomes WHERE truncated != '')
AND id NOT IN (SELECT track FROM outcomes WHERE track IS NOT NULL);
DROP TABLE old_outcomes
"""
_STEPS = (
    _statements("""
CREATE TABLE IF NOT EXISTS meta (name TEXT PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID;
CREATE TABLE IF NOT EXISTS outcomes (
    key TEXT PRIMARY KEY,
    mutant TEXT NOT NULL,
    situation TEXT NOT NULL,
    seed INTEGER NOT NULL,
    valid INTEGER NOT NULL,
    outcome TEXT NOT NULL,
    track BLOB NOT NULL
) WITHOUT ROWID;
CREATE INDEX IF NOT EXISTS outcomes_by_flight ON outcomes (mutant, situation, seed);
"""),
    _statements("""
CREATE TABLE IF NOT EXISTS plan (
    key TEXT PRIMARY KEY,
    mutant TEXT NOT NULL,
    situation TEXT NOT NULL,
    seed INTEGER NOT NULL,
    canary INTEGER NOT NULL
) WITHOUT ROWID;
"""),
    _statements("""
CREATE TABLE origins (id INTEGER PRIMARY KEY, parts TEXT NOT NULL UNIQUE);
ALTER TABLE plan ADD COLUMN origin INTEGER REFERENCES origins (id);
"""),
    _columns_from_json,
    _whole_flights,
)
"""What brings a store of schema n to n + 1, a new one from 0 on."""
SCHEMA = len(_STEPS)
"""Version of the tables; a store of an earlier one is brought to it, one of a later one is refused."""
