"""The campaign's store: one SQLite file, one transaction per flight, safe against a kill at any moment."""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from types import TracebackType
from typing import Any, TypeVar

from scaloft_fi.campaign.store.cells import TooLargeError, decoded, most_flights, shown
from scaloft_fi.campaign.store.opening import connected, is_new, prepare, sentences
from scaloft_fi.campaign.store.origin import Origin
from scaloft_fi.campaign.store.place import Place, rescue, told_when_slow
from scaloft_fi.campaign.store.record import Reader
from scaloft_fi.campaign.store.schema import create as create_tables
from scaloft_fi.campaign.store.schema import insert
from scaloft_fi.campaign.store.selection import Flown, Stands, flown, outcomes, standing, tracked, under
from scaloft_fi.campaign.store.tables import Planned, facts, origins, planned
from scaloft_fi.errors import InputError
from scaloft_fi.judge.outcome import Outcome

T = TypeVar("T")
NOTE = "note: "
"""Prefix of the names of notes in the table `meta`."""


class EmptyError(InputError):
    """A store has no tables: nothing was saved, or another process creates them at this moment."""


class Store:
    """Outcomes by key, a hash of what can change the outcome; every `put` is in the file at `path` when it returns."""

    def __init__(self, path: Path, *, create: bool = True, say: Callable[[str], None] | None = None) -> None:
        """Open the store, to write if `create`, else to read; a missing store and its folder are created if `create`.

        Args:
            path: path of the file.
            create: whether the store is opened to write.
            say: prints a line for the user when a save takes long.

        Raises:
            InputError: the file cannot be opened or written, is no store, or has another version.
        """
        self.path, self._say = path, say
        self._saved = self._written = 0
        if not create and not path.is_file():
            raise InputError(f"{path}: there is no campaign here; `run` makes one")
        with sentences(path):
            if create:
                path.parent.mkdir(parents=True, exist_ok=True)
            self._connection = connected(path, write=create)
            try:
                self._place = self._opened(create=create)
            except BaseException:
                self._connection.close()
                raise

    def _opened(self, *, create: bool) -> Place | None:
        """Check and prepare the file; returns the place of a store that is written."""
        new = is_new(self._connection, self.path)
        if not create:
            if new:
                raise EmptyError(f"{self.path}: the file has no tables, so it holds no campaign; `run` makes one")
            return None
        prepare(self._connection)
        if new:
            with self._atomically():
                if is_new(self._connection, self.path):  # checked again, because another process may have been faster
                    create_tables(self._connection)
        return Place(self.path)

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
        """Write atomically: all writes in the context are kept, or none if it raises.

        Raises:
            InputError: the store cannot be written, or is no longer at its place.
        """
        self._written = 0
        with self._sentences(), told_when_slow(self.path, self._say), self._atomically() as connection:
            yield connection
        self._saved += self._written
        self.confirm()

    @contextmanager
    def _atomically(self) -> Iterator[sqlite3.Connection]:
        self._connection.execute("BEGIN IMMEDIATE")
        try:
            yield self._connection
            self._connection.execute("COMMIT")
        except BaseException:
            if self._connection.in_transaction:  # SQLite itself rolls back when the disk is full
                self._connection.execute("ROLLBACK")
            raise

    def confirm(self) -> None:
        """Check that what was written is at its place; does nothing for a store that is only read.

        Raises:
            InputError: the file was removed, renamed, replaced or cut, or its folder can no longer be written.  The
                message says what is kept and where; the flights of a lost file are copied.
        """
        if self._place is None:
            return
        lost = self._place.lost()
        if lost:
            raise InputError(f"{self.path}: the campaign's store is lost: {lost}; {self._rescued(self._place.path)}")
        if self._place.is_locked():
            raise InputError(f"{self.path}: the results folder can no longer be written; {self._kept()}")

    def _rescued(self, path: Path) -> str:
        """Copy the flights of a lost file; says where they are."""
        try:
            folder, flights = rescue(self._connection, path)
        except (OSError, sqlite3.Error) as error:
            return f"no copy of its flights could be made ({shown(str(error))})"
        return f"a copy with its {_flights(flights)} is in {folder}, which --campaign takes"

    def _kept(self) -> str:
        return f"{_flights(self._saved)} of this command and all earlier ones are kept, and the same command resumes"

    def _sentences(self) -> AbstractContextManager[None]:
        return sentences(self.path, self._kept if self._place is not None else lambda: "")

    @contextmanager
    def snapshot(self) -> Iterator[None]:
        """Read one state of the store in the whole context, whatever other processes write; the context only reads.

        A nested snapshot reads the state of the outer one.
        """
        if self._connection.in_transaction:
            yield
            return
        with self._sentences():
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
            self._written = int(insert(self._connection, key, outcome))
        return bool(self._written)

    def put_all(self, rows: Iterable[tuple[str, Outcome]]) -> None:
        """Write outcomes with their keys by the rule of `put`; after a failure none is written.

        Raises:
            InputError: the store cannot be written.
        """
        with self.transaction():
            self._written = sum(insert(self._connection, key, outcome) for key, outcome in rows)

    def get(self, key: str) -> Outcome | None:
        """The outcome with this key and its track; None without one."""
        return next((outcome for _, outcome in self.rows([key])), None)

    def rows(self, keys: Iterable[str] | None = None) -> Iterator[tuple[str, Outcome]]:
        """Yield every outcome, or those with `keys`, with key and track, ordered by key."""
        read = Reader()
        for key in sorted(keys if keys is not None else (flight.key for flight in self.flights())):
            with self._sentences():
                outcome = tracked(self._connection, read, key)
            if outcome is not None:
                yield key, outcome

    def known(self, keys: Iterable[str]) -> set[str]:
        """The `keys` with a valid outcome."""
        with self._sentences():
            stored = {key for (key,) in self._connection.execute("SELECT key FROM outcomes")}
            invalid = self._connection.execute("SELECT key FROM outcomes WHERE invalid != ''")
            return stored.intersection(keys).difference(key for (key,) in invalid)

    def flights(self, *, one_each: bool = False) -> list[Flown]:
        """The flights with an outcome, ordered by mutant, situation, seed; a fast query, answered by an index.

        Args:
            one_each: whether one flight for each mutant, situation and origin is enough.
        """
        with self._sentences():
            return flown(self._connection, one_each=one_each)

    def outcomes(self, keys: Iterable[str] | None = None) -> Iterator[Outcome]:
        """All outcomes, or those with `keys`, without their tracks, ordered by mutant, situation, seed."""
        return (outcome for _, outcome in self.keyed(keys))

    def keyed(self, keys: Iterable[str] | None = None) -> list[tuple[str, Outcome]]:
        """All outcomes, or those with `keys`, each with its key, in the order of `outcomes`."""
        with self._sentences():
            return list(outcomes(self._connection, None if keys is None else under(set(keys))))

    def standing(self, stands: Stands) -> tuple[Outcome, ...]:
        """The outcomes of the current flights, without their tracks, ordered by mutant, situation, seed."""
        with self._sentences():
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
            (number,) = self._connection.execute("SELECT count(*) FROM plan").fetchone()
            if number > most_flights():
                raise TooLargeError("plan")

    def _origin(self, origin: Origin) -> int:
        """The number of an origin; flights with equal origins share one row."""
        parts = json.dumps(origin._asdict())
        self._connection.execute("INSERT INTO origins (parts) VALUES (?) ON CONFLICT (parts) DO NOTHING", (parts,))
        return int(self._connection.execute("SELECT id FROM origins WHERE parts = ?", (parts,)).fetchone()[0])

    def origins(self) -> dict[int, Origin]:
        """The origins of all recorded flights by number."""
        with self._sentences():
            return origins(self._connection)

    def planned(self) -> list[Planned]:
        """All recorded plans, ordered by key."""
        with self._sentences():
            return planned(self._connection)

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

    def records(self, prefix: str, read: Callable[[Any], T]) -> list[T]:
        """What `read` makes of the JSON of each note whose name begins with `prefix` and a space, in their order.

        Raises:
            InputError: a note is no JSON, or `read` raises an error for it.
        """
        found = []
        for name, text in self.notes().items():
            if name.startswith(f"{prefix} "):
                try:
                    found.append(read(decoded(text)))
                except (ValueError, TypeError, KeyError, OverflowError) as error:
                    row = f"table meta, name {shown(NOTE + name)}"
                    raise InputError(f"{self.path}: {row}: value={shown(text)} must be a record of `run`") from error
        return found

    def _facts(self) -> list[tuple[str, str]]:
        with self._sentences():
            return facts(self._connection)


def _flights(number: int) -> str:
    return f"{number} flight{'s' * (number != 1)}"
