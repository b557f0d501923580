"""The campaign's store: one SQLite file, one transaction per flight, safe against a kill at any moment."""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from types import TracebackType
from typing import NamedTuple

from scaloft_fi.errors import InputError
from scaloft_fi.results.origin import Origin
from scaloft_fi.results.outcome import Outcome
from scaloft_fi.results.record import from_json, to_json

_NOTE = "note: "
BUSY_S = 30.0
"""How long a writer waits for another process [s]."""

_STEPS = (
    """
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
""",
    """
CREATE TABLE IF NOT EXISTS plan (
    key TEXT PRIMARY KEY,
    mutant TEXT NOT NULL,
    situation TEXT NOT NULL,
    seed INTEGER NOT NULL,
    canary INTEGER NOT NULL
) WITHOUT ROWID;
""",
    """
CREATE TABLE origins (id INTEGER PRIMARY KEY, parts TEXT NOT NULL UNIQUE);
ALTER TABLE plan ADD COLUMN origin INTEGER REFERENCES origins (id);
""",
)
"""What brings a store of schema n to n + 1, a new one from 0 on."""
SCHEMA = len(_STEPS)
"""Version of the tables; a store of an earlier one is brought to it, one of a later one is refused."""


class Planned(NamedTuple):
    """A flight that was planned.

    Attributes:
        key: of its outcome.
        mutant, situation, seed: what is flown, where.
        canary: flown only to prove that faults reach the drone.
        origin: what entered the key; None where an earlier version planned it.
    """

    key: str
    mutant: str
    situation: str
    seed: int
    canary: bool = False
    origin: Origin | None = None


class Store:
    """Outcomes by key, where a key is the content hash of everything that can change the flight.

    A context manager; every `put` is on the disk when it returns.
    """

    def __init__(self, path: Path, *, create: bool = True) -> None:
        """Open the store, making it and its folder when `create`.

        Raises:
            InputError: it cannot be opened or written, is no store, or is a later version's.
        """
        self.path = path
        if not create and not path.is_file():
            raise InputError(f"{path}: there is no campaign here; `run` makes one")
        with _sentences(path):
            if create:
                path.parent.mkdir(parents=True, exist_ok=True)
            # rows are written one by one in explicit transactions
            self._connection = sqlite3.connect(path, timeout=BUSY_S, isolation_level=None)
            try:
                self._prepare()
            except BaseException:
                self._connection.close()
                raise

    def _prepare(self) -> None:
        run = self._connection.execute
        current = self._schema() == SCHEMA
        run("PRAGMA journal_mode=WAL")
        run("PRAGMA synchronous=FULL")
        if current:
            return
        with self._transaction():  # another process may have been faster
            for step in _STEPS[self._schema() :]:
                for statement in filter(str.strip, step.split(";")):
                    run(statement)
            run(f"PRAGMA user_version={SCHEMA}")

    def _schema(self) -> int:
        """Version of the tables in the file.

        Raises:
            InputError: it is a later one.
        """
        version = int(self._connection.execute("PRAGMA user_version").fetchone()[0])
        if version > SCHEMA:
            raise InputError(
                f"{self.path}: store of schema {version} must be at most {SCHEMA}; a later version wrote it"
            )
        return version

    def __enter__(self) -> Store:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Close the file; the write-ahead log is folded into it."""
        self._connection.close()

    @contextmanager
    def _transaction(self) -> Iterator[None]:
        with _sentences(self.path):
            self._connection.execute("BEGIN IMMEDIATE")
            try:
                yield
            except BaseException:
                self._connection.execute("ROLLBACK")
                raise
            self._connection.execute("COMMIT")

    def put(self, key: str, outcome: Outcome) -> bool:
        """Keep an outcome; one that counts is never replaced, an invalid one gives way to any later.

        Returns whether anything was written.

        Raises:
            InputError: the store cannot be written.
        """
        text = json.dumps(to_json(replace(outcome, track=b"")), sort_keys=True, allow_nan=False)
        row = (key, outcome.mutant, outcome.situation, outcome.seed, not outcome.invalid, text, outcome.track)
        with self._transaction():
            cursor = self._connection.execute(
                "INSERT INTO outcomes VALUES (?, ?, ?, ?, ?, ?, ?) ON CONFLICT (key) DO UPDATE SET"
                " valid = excluded.valid, outcome = excluded.outcome, track = excluded.track"
                " WHERE outcomes.valid = 0 AND outcomes.outcome != excluded.outcome",
                row,
            )
            return cursor.rowcount > 0

    def get(self, key: str) -> Outcome | None:
        """The outcome under a key with its track, None when there is none."""
        with _sentences(self.path):
            row = self._connection.execute("SELECT outcome, track FROM outcomes WHERE key = ?", (key,)).fetchone()
        return None if row is None else replace(from_json(json.loads(row[0])), track=bytes(row[1]))

    def known(self, keys: Iterable[str]) -> set[str]:
        """Those of `keys` that have an outcome that counts."""
        with _sentences(self.path):
            valid = {row[0] for row in self._connection.execute("SELECT key FROM outcomes WHERE valid = 1")}
        return valid & set(keys)

    def outcomes(self, keys: Iterable[str] | None = None) -> Iterator[Outcome]:
        """All outcomes, or those under `keys`, without their tracks, ordered by mutant, situation, seed."""
        wanted = None if keys is None else set(keys)
        with _sentences(self.path):
            rows = self._connection.execute("SELECT key, outcome FROM outcomes ORDER BY mutant, situation, seed, key")
            for key, text in rows:
                if wanted is None or key in wanted:
                    yield from_json(json.loads(text))

    def rows(self) -> Iterator[tuple[str, Outcome]]:
        """Every outcome with its key and its track, ordered by key."""
        with _sentences(self.path):
            for key, text, track in self._connection.execute("SELECT key, outcome, track FROM outcomes ORDER BY key"):
                yield key, replace(from_json(json.loads(text)), track=bytes(track))

    def plan(self, flights: Iterable[Planned]) -> None:
        """Keep what is to be flown, in one transaction; what was planned before stays planned.

        Raises:
            InputError: the store cannot be written.
        """
        with self._transaction():
            origins: dict[Origin, int] = {}
            for flight in flights:
                if flight.origin is not None and flight.origin not in origins:
                    origins[flight.origin] = self._origin(flight.origin)
                self._connection.execute(
                    "INSERT INTO plan (key, mutant, situation, seed, canary, origin) VALUES (?, ?, ?, ?, ?, ?)"
                    " ON CONFLICT (key) DO UPDATE SET canary = min(canary, excluded.canary)"
                    " WHERE canary > excluded.canary",
                    (*flight[:5], origins[flight.origin] if flight.origin is not None else None),
                )

    def _origin(self, origin: Origin) -> int:
        """The number of an origin, which is kept once however many flights have it."""
        parts = json.dumps(origin._asdict())
        self._connection.execute("INSERT INTO origins (parts) VALUES (?) ON CONFLICT (parts) DO NOTHING", (parts,))
        return int(self._connection.execute("SELECT id FROM origins WHERE parts = ?", (parts,)).fetchone()[0])

    def planned(self) -> list[Planned]:
        """All that was ever planned, ordered by key."""
        with _sentences(self.path):
            texts = self._connection.execute("SELECT id, parts FROM origins")
            origins = {number: Origin(**json.loads(parts)) for number, parts in texts}
            columns = "key, mutant, situation, seed, canary, origin"
            rows = self._connection.execute(f"SELECT {columns} FROM plan ORDER BY key")
            return [
                Planned(key, mutant, situation, seed, bool(canary), origins.get(origin))
                for key, mutant, situation, seed, canary, origin in rows
            ]

    def set_meta(self, entries: Mapping[str, str]) -> None:
        """Keep facts about the campaign, such as the platform's fingerprint; the first value of a name stays.

        Raises:
            InputError: the store cannot be written.
        """
        with self._transaction():
            self._connection.executemany(
                "INSERT INTO meta VALUES (?, ?) ON CONFLICT (name) DO NOTHING", entries.items()
            )

    def meta(self) -> dict[str, str]:
        """The facts kept by `set_meta`."""
        return {name: value for name, value in self._facts() if not name.startswith(_NOTE)}

    def set_notes(self, notes: Mapping[str, str]) -> None:
        """Keep what was said of the campaign; of one name the first note stays.

        Raises:
            InputError: the store cannot be written.
        """
        self.set_meta({_NOTE + name: text for name, text in notes.items()})

    def notes(self) -> dict[str, str]:
        """The notes kept by `set_notes`."""
        return {name.removeprefix(_NOTE): text for name, text in self._facts() if name.startswith(_NOTE)}

    def _facts(self) -> list[tuple[str, str]]:
        with _sentences(self.path):
            return list(self._connection.execute("SELECT name, value FROM meta ORDER BY name"))


@contextmanager
def _sentences(path: Path) -> Iterator[None]:
    """SQLite's and the file system's failures as one sentence."""
    try:
        yield
    except sqlite3.DatabaseError as error:
        raise InputError(f"{path}: the campaign's store cannot be used: {error}") from error
    except OSError as error:
        raise InputError(f"{path}: the results folder cannot be written: {error.strerror}") from error
