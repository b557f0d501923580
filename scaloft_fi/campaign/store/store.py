"""The campaign's store: one SQLite file, one transaction per flight, safe against a kill at any moment."""

from __future__ import annotations

import json
import os
import sqlite3
import time
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from types import TracebackType
from typing import NamedTuple

from scaloft_fi.campaign.store.origin import Origin
from scaloft_fi.campaign.store.record import COLUMNS, Reader
from scaloft_fi.campaign.store.schema import SCHEMA, create, insert
from scaloft_fi.campaign.store.selection import Flown, Stands, outcomes, standing, under
from scaloft_fi.errors import InputError
from scaloft_fi.judge.outcome import Outcome

NOTE = "note: "
"""Prefix of the names of notes in the table `meta`."""
BUSY_S = 30.0
"""Greatest time that a writer waits for another process [s]."""
RETRY_S = 0.01
"""Interval between attempts where SQLite does not wait by itself [s]."""
_PAGE_BYTES = 16384
"""Page size of a new file.  Outcomes lie between tracks, which scores skip; with larger pages they read fewer pages."""


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


class Store:
    """Outcomes by key; a key is a hash of everything that can change the outcome.

    A context manager; every `put` is on the disk when it returns.
    """

    def __init__(self, path: Path, *, create: bool = True) -> None:
        """Open the store, and create it and its folder if `create`; a store in a read-only folder is opened to read.

        Raises:
            InputError: the file cannot be opened or written, is no store, or has another version.
        """
        self.path = path
        if not create and not path.is_file():
            raise InputError(f"{path}: there is no campaign here; `run` makes one")
        with _sentences(path):
            if create:
                path.parent.mkdir(parents=True, exist_ok=True)
            # SQLite writes its log beside the file; in a read-only folder it must not try
            fixed = not create and not os.access(path.parent, os.W_OK) and not _log(path).exists()
            name = f"{path.absolute().as_uri()}?immutable=1" if fixed else str(path)
            # rows are written one by one in explicit transactions
            self._connection = sqlite3.connect(name, timeout=BUSY_S, isolation_level=None, uri=fixed)
            try:
                new = self._is_new()
                if not fixed:
                    self._prepare(new=new)
            except BaseException:
                self._connection.close()
                raise

    def _prepare(self, *, new: bool) -> None:
        self._connection.execute(f"PRAGMA page_size={_PAGE_BYTES}")
        self._keep_log()
        self._connection.execute("PRAGMA synchronous=FULL")
        if not new:
            return
        with self.transaction() as connection:
            if self._is_new():  # checked again, because another process may have been faster
                create(connection)

    def _keep_log(self) -> None:
        """Turn on the write-ahead log; SQLite does not wait for another process that creates the same file."""
        end_s = time.monotonic() + BUSY_S
        while True:
            try:
                self._connection.execute("PRAGMA journal_mode=WAL")
            except sqlite3.OperationalError as error:
                if "locked" not in str(error) or time.monotonic() > end_s:
                    raise
                time.sleep(RETRY_S)
            else:
                return

    def _is_new(self) -> bool:
        """Whether the file has no tables yet.

        Raises:
            InputError: the file has tables of another version.
        """
        version = int(self._connection.execute("PRAGMA user_version").fetchone()[0])
        if version not in (0, SCHEMA):
            raise InputError(
                f"{self.path}: another version of scaloft-fi wrote this store (schema {version}, not {SCHEMA}); "
                "read it with that version, or fly again under another --campaign"
            )
        return version == 0

    def __enter__(self) -> Store:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Close the file; SQLite merges the write-ahead log into it."""
        self._connection.close()

    @contextmanager
    def transaction(self) -> Iterator[sqlite3.Connection]:
        """Write atomically: all writes in the context are kept, or none if it raises."""
        with _sentences(self.path):
            self._connection.execute("BEGIN IMMEDIATE")
            try:
                yield self._connection
                self._connection.execute("COMMIT")
            except BaseException:
                if self._connection.in_transaction:  # SQLite itself rolls back when the disk is full
                    self._connection.execute("ROLLBACK")
                raise

    @contextmanager
    def snapshot(self) -> Iterator[None]:
        """Read one state of the store in the whole context, whatever other processes write; the context only reads.

        A nested snapshot reads the state of the outer one.
        """
        if self._connection.in_transaction:
            yield
            return
        with _sentences(self.path):
            self._connection.execute("BEGIN")
            try:
                yield
            finally:
                self._connection.execute("ROLLBACK")

    def put(self, key: str, outcome: Outcome) -> bool:
        """Write an outcome; it replaces an invalid outcome, never a valid one.  Returns whether anything was written.

        Raises:
            InputError: the store cannot be written.
        """
        with self.transaction():
            return insert(self._connection, key, outcome)

    def put_all(self, rows: Iterable[tuple[str, Outcome]]) -> None:
        """Write outcomes with their keys by the rule of `put`; after a failure none is written.

        Raises:
            InputError: the store cannot be written.
        """
        with self.transaction():
            for key, outcome in rows:
                insert(self._connection, key, outcome)

    def get(self, key: str) -> Outcome | None:
        """The outcome with this key and its track; None without one."""
        return next((outcome for _, outcome in self.rows([key])), None)

    def rows(self, keys: Iterable[str] | None = None) -> Iterator[tuple[str, Outcome]]:
        """Yield every outcome, or those with `keys`, with key and track, ordered by key."""
        read = Reader()
        track = "(SELECT tracks.track FROM tracks WHERE tracks.id = outcomes.track)"
        query = f"SELECT {track}, {', '.join(COLUMNS)} FROM outcomes WHERE key = ?"
        for key in sorted(keys if keys is not None else (flight.key for flight in self.flights())):
            with _sentences(self.path):
                row = self._connection.execute(query, (key,)).fetchone()
            if row is not None:
                (outcome,) = read([row[1:]], [row[0] or b""])
                yield key, outcome

    def known(self, keys: Iterable[str]) -> set[str]:
        """The `keys` with a valid outcome."""
        with _sentences(self.path):
            stored = {key for (key,) in self._connection.execute("SELECT key FROM outcomes")}
            invalid = self._connection.execute("SELECT key FROM outcomes WHERE invalid != ''")
            return stored.intersection(keys).difference(key for (key,) in invalid)

    def flights(self) -> list[Flown]:
        """The flights with an outcome, ordered by mutant, situation, seed; a fast query, answered by an index."""
        with _sentences(self.path):
            columns = ", ".join(Flown._fields)
            order = "mutant, situation, seed, key"
            return [Flown(*row) for row in self._connection.execute(f"SELECT {columns} FROM outcomes ORDER BY {order}")]

    def outcomes(self, keys: Iterable[str] | None = None) -> Iterator[Outcome]:
        """All outcomes, or those with `keys`, without their tracks, ordered by mutant, situation, seed."""
        return (outcome for _, outcome in self.keyed(keys))

    def keyed(self, keys: Iterable[str] | None = None) -> list[tuple[str, Outcome]]:
        """All outcomes, or those with `keys`, each with its key, in the order of `outcomes`."""
        with _sentences(self.path):
            return list(outcomes(self._connection, None if keys is None else under(set(keys))))

    def standing(self, stands: Stands) -> tuple[Outcome, ...]:
        """The outcomes of the current flights, without their tracks, ordered by mutant, situation, seed."""
        with _sentences(self.path):
            return tuple([outcome for _, outcome in outcomes(self._connection, standing(stands))])

    def plan(self, flights: Iterable[Planned]) -> None:
        """Record planned flights in one transaction; earlier records stay.

        Raises:
            InputError: the store cannot be written.
        """
        with self.transaction():
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
        """The number of an origin; flights with equal origins share one row."""
        parts = json.dumps(origin._asdict())
        self._connection.execute("INSERT INTO origins (parts) VALUES (?) ON CONFLICT (parts) DO NOTHING", (parts,))
        return int(self._connection.execute("SELECT id FROM origins WHERE parts = ?", (parts,)).fetchone()[0])

    def origins(self) -> dict[int, Origin]:
        """The origins of all recorded flights by number."""
        with _sentences(self.path):
            rows = self._connection.execute("SELECT id, parts FROM origins").fetchall()
        # one text for the decoder, whose call costs more than an origin
        origins = json.loads(f"[{','.join(parts for _, parts in rows)}]")
        return {number: Origin(**parts) for (number, _), parts in zip(rows, origins, strict=True)}

    def planned(self) -> list[Planned]:
        """All recorded plans, ordered by key."""
        with _sentences(self.path):
            origins = self.origins()
            columns = "key, mutant, situation, seed, canary, origin"
            rows = self._connection.execute(f"SELECT {columns} FROM plan ORDER BY key")
            return [
                Planned(key, mutant, situation, seed, bool(canary), origins.get(origin))
                for key, mutant, situation, seed, canary, origin in rows
            ]

    def set_meta(self, entries: Mapping[str, str]) -> None:
        """Record facts about the campaign, such as the fingerprint of the platform; the first value of a name stays.

        Raises:
            InputError: the store cannot be written.
        """
        with self.transaction():
            self._connection.executemany(
                "INSERT INTO meta VALUES (?, ?) ON CONFLICT (name) DO NOTHING", entries.items()
            )

    def meta(self) -> dict[str, str]:
        """The facts recorded by `set_meta`."""
        return {name: value for name, value in self._facts() if not name.startswith(NOTE)}

    def set_notes(self, notes: Mapping[str, str]) -> None:
        """Record notes about the campaign; the first note of a name stays.

        Raises:
            InputError: the store cannot be written.
        """
        self.set_meta({NOTE + name: text for name, text in notes.items()})

    def notes(self) -> dict[str, str]:
        """The notes recorded by `set_notes`."""
        return {name.removeprefix(NOTE): text for name, text in self._facts() if name.startswith(NOTE)}

    def _facts(self) -> list[tuple[str, str]]:
        with _sentences(self.path):
            return list(self._connection.execute("SELECT name, value FROM meta ORDER BY name"))


def _log(path: Path) -> Path:
    """Path of SQLite's write-ahead log."""
    return path.with_name(f"{path.name}-wal")


@contextmanager
def _sentences(path: Path) -> Iterator[None]:
    """Turn errors of SQLite and of the file system into an `InputError` of one sentence."""
    try:
        yield
    except sqlite3.DatabaseError as error:
        if "disk is full" in str(error):
            kept = "what was flown before is kept, and the same command resumes"
            raise InputError(f"{path}: the campaign's store cannot be written: the disk is full; {kept}") from error
        raise InputError(f"{path}: the campaign's store cannot be used: {error}") from error
    except OSError as error:
        raise InputError(f"{path}: the results folder cannot be written: {error.strerror}") from error
