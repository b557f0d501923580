"""The campaign's store: one SQLite file, one transaction per flight, safe against a kill at any moment."""

from __future__ import annotations

import json
import os
import sqlite3
import tempfile
import time
from collections import defaultdict
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, closing, contextmanager, nullcontext, suppress
from functools import cache
from hashlib import sha256
from operator import itemgetter
from pathlib import Path
from sys import intern
from threading import Timer
from typing import Any, NamedTuple, TypeVar

from scaloft_fi.campaign.store import record
from scaloft_fi.errors import InputError, shown
from scaloft_fi.judge.outcome import BASELINE, Outcome
from scaloft_fi.judge.status import Brief

MOST_CELL_BYTES = 65_536
"""Greatest size of a cell of an outcome."""
MOST_BYTES = 16 * 1024**2
"""Greatest size of any other cell: a note with 250,000 draws, a packed track."""
CHUNK = 2000
"""Number of rows that are read at once; their columns are processed together and fit the processor's cache."""
SCHEMA = 6
"""Version of the tables; a store of another version is refused."""
_TYPES = {name: cell.sql for name, cell in record.COLUMNS.items()}
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
        {", ".join(f"{name} {kind}" + " NOT NULL" * (kind != "REAL") for name, kind in _TYPES.items())}
    )""",
    "CREATE INDEX outcomes_by_flight ON outcomes (mutant, situation, seed, key, origin)",
    "CREATE INDEX invalid_outcomes ON outcomes (key) WHERE invalid != ''",
)


def create_tables(connection: sqlite3.Connection) -> None:
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
        create_tables(connection)
        return _entries(connection)


def _entries(connection: sqlite3.Connection) -> frozenset[tuple[str, ...]]:
    return frozenset(connection.execute("SELECT type, name, tbl_name, sql FROM sqlite_master"))


_INSERT = f"""
INSERT INTO outcomes (key, origin, track, {", ".join(record.COLUMNS)})
VALUES (:key, (SELECT origin FROM plan WHERE key = :key), :track, {", ".join(f":{name}" for name in record.COLUMNS)})
ON CONFLICT (key) DO UPDATE
SET track = excluded.track, {", ".join(f"{name} = excluded.{name}" for name in record.COLUMNS)}
WHERE outcomes.invalid != '' AND outcomes.invalid != excluded.invalid
"""


BUSY_S = 30.0
"""Greatest time that a writer waits for another process [s]."""
RETRY_S = 0.01
"""Interval between attempts where SQLite does not wait by itself [s]."""
_PAGE_BYTES = 16384
"""Page size of a new file.  Outcomes lie between tracks, which scores skip; with larger pages they read fewer pages."""
_SHOWN = 200
"""Characters of SQLite's own message that a message shows."""
_REASONS = {
    "SQLITE_FULL": "the disk is full",
    "SQLITE_IOERR": "the disk does not answer",
    "SQLITE_BUSY": f"another process has kept it locked for {BUSY_S:g} s",
    "SQLITE_CANTOPEN": "a file beside it cannot be opened",
}
"""Words for the primary result codes of SQLite that have one cause."""


def log_of(path: Path) -> Path:
    """Path of SQLite's write-ahead log."""
    return path.with_name(f"{path.name}-wal")


def connected(path: Path, *, write: bool) -> sqlite3.Connection:
    """Connect to the file, which is created if `write`; a reader cannot change it.

    A reader of a file that nobody writes leaves no other file.  In a folder that cannot be written SQLite must not try
    to make a log, so the file is opened as immutable unless a log is there.
    """
    writable = os.access(path.parent, os.W_OK) and os.access(path, os.W_OK)
    fixed = not (write or writable or log_of(path).exists())
    mode = "immutable=1" if fixed else "mode=rwc" if write else "mode=rw"
    # rows are written one by one in explicit transactions
    connection = sqlite3.connect(f"{path.absolute().as_uri()}?{mode}", timeout=BUSY_S, isolation_level=None, uri=True)
    connection.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, MOST_BYTES)
    connection.execute("PRAGMA trusted_schema=OFF")
    connection.execute("PRAGMA cell_size_check=ON")
    if not write:
        connection.execute("PRAGMA query_only=ON")
    return connection


def is_new(connection: sqlite3.Connection, path: Path) -> bool:
    """Whether the file has no tables yet.

    Raises:
        InputError: the file has tables that are not those of a store of this version.
    """
    (version,) = connection.execute("PRAGMA user_version").fetchone()
    if version not in (0, SCHEMA):
        raise InputError(
            f"{path}: another version of scaloft-fi wrote this store (schema {version}, not {SCHEMA}); "
            "read it with that version, or fly again under another --campaign"
        )
    if version == 0 and connection.execute("SELECT 1 FROM sqlite_master LIMIT 1").fetchone() is None:
        return True
    differs = deviation(connection)
    if differs:
        raise InputError(f"{path}: this file is no store of scaloft-fi: {differs}")
    return False


def prepare(connection: sqlite3.Connection) -> None:
    """Set the page size, the write-ahead log and the safety of a connection that writes."""
    connection.execute(f"PRAGMA page_size={_PAGE_BYTES}")
    end_s = time.monotonic() + BUSY_S
    while True:
        try:
            connection.execute("PRAGMA journal_mode=WAL")
            break
        except sqlite3.OperationalError as error:
            if "locked" not in str(error) or time.monotonic() > end_s:
                raise
            time.sleep(RETRY_S)  # SQLite does not wait for another process that creates the same file
    connection.execute("PRAGMA synchronous=FULL")


@contextmanager
def sentences(path: Path, kept: Callable[[], str] = lambda: "") -> Iterator[None]:
    """Turn errors of SQLite, of the file system and of the cells into an `InputError` of one sentence.

    Args:
        path: path of the store.
        kept: what is kept after a failure, in words.
    """
    try:
        yield
    except (record.BadCellError, record.TooLargeError) as error:
        raise InputError(f"{path}: {error}") from error
    except sqlite3.Error as error:
        code = getattr(error, "sqlite_errorname", "") or ""
        own = ascii(str(error))[1:-1][:_SHOWN]
        reason = next((words for name, words in _REASONS.items() if code.startswith(name)), own)
        rest = kept()
        raise InputError(f"{path}: the campaign's store cannot be used: {reason}{rest and f'; {rest}'}") from error
    except UnicodeDecodeError as error:  # SQLite quotes the damaged text of a table in its own message
        raise InputError(f"{path}: the campaign's store cannot be used: its tables are damaged") from error
    except OSError as error:
        raise InputError(f"{path}: the results folder cannot be written: {error.strerror}") from error


SLOW_S = 10.0
"""Time after which the user is told that a save still waits for the disk [s]."""


class Place:
    """The files of an open store as they were when it was opened.

    An open file outlives its name: SQLite goes on writing to a file that was removed, and everything is lost at the
    end.  So the names are compared with the open files after each save.

    Args:
        path: path of the store, whose files exist.
    """

    def __init__(self, path: Path) -> None:
        self.path = path.absolute()
        names = str(self.path), str(log_of(self.path))
        self._open = {name: os.stat(name) for name in names if os.path.exists(name)}  # noqa: PTH110, PTH116 - fast
        self._size = 0

    def lost(self) -> str:
        """Why the open files are no longer at their place; empty if they are."""
        for name, known in self._open.items():
            try:
                state = os.stat(name)  # noqa: PTH116 - fast
            except FileNotFoundError:
                return f"{os.path.basename(name)} was removed or renamed"  # noqa: PTH119
            except OSError as error:
                return f"{os.path.basename(name)} cannot be reached ({error.strerror})"  # noqa: PTH119
            if not os.path.samestat(state, known):
                return f"{os.path.basename(name)} was replaced by another file"  # noqa: PTH119
            if name == str(self.path):
                if state.st_size < self._size:
                    return f"{self.path.name} was cut"
                self._size = state.st_size
        return ""


def rescue(connection: sqlite3.Connection, path: Path) -> tuple[Path, int]:
    """Copy what the open files hold to a campaign's folder beside the lost one, else to a temporary folder.

    Args:
        connection: connection to the files, outside a transaction.
        path: absolute path of the lost store.

    Returns:
        the folder of the copy, and its number of flights.

    Raises:
        OSError, sqlite3.Error: there is no place for a copy, or the open files cannot be read.
    """
    try:
        return _copied(connection, _beside(path.parent), path.name)
    except (OSError, sqlite3.Error):
        return _copied(connection, Path(tempfile.mkdtemp(prefix="scaloft-fi-rescued-")), path.name)


def _beside(folder: Path) -> Path:
    """A new folder beside a folder, which need not exist any more."""
    number = 1
    while True:
        rescued = folder.with_name(f"{folder.name}-rescued" + f"-{number}" * (number > 1))
        try:
            rescued.mkdir(parents=True)
        except FileExistsError:
            if not rescued.exists():  # a parent is a file
                raise
            number += 1
        else:
            return rescued


def _copied(connection: sqlite3.Connection, folder: Path, name: str) -> tuple[Path, int]:
    copy = folder / name
    try:
        connection.execute("VACUUM INTO ?", (str(copy),))
        with closing(sqlite3.connect(copy)) as rescued:
            (flights,) = rescued.execute("SELECT count(*) FROM outcomes").fetchone()
        with copy.open("rb") as file:
            os.fsync(file.fileno())
    except BaseException:
        copy.unlink(missing_ok=True)
        with suppress(OSError):
            folder.rmdir()
        raise
    return folder, flights


@contextmanager
def told_when_slow(path: Path, say: Callable[[str], None] | None) -> Iterator[None]:
    """Say when the context takes longer than `SLOW_S`; the disk may have stopped answering."""
    if say is None:
        yield
        return
    words = f"warning: {path}: a save has taken {SLOW_S:g} s so far; the disk answers slowly, or no longer"
    timer = Timer(SLOW_S, say, [words])
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        timer.cancel()
        timer.join()


class FlownFlight(NamedTuple):
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


Stands = Callable[[FlownFlight], bool]
"""Whether a flight is current.

Called once for each mutant, situation and origin, and for each flight without an origin.
"""
_NAMES = "key", "origin"
_COLUMNS = (*record.COLUMNS, *_NAMES)
_FLIGHTS = f"SELECT {', '.join(FlownFlight._fields)} FROM outcomes ORDER BY mutant, situation, seed, key"
_UNFLOWN = (
    "NOT EXISTS (SELECT 1 FROM outcomes WHERE outcomes.key = plan.key)"
    " OR key IN (SELECT key FROM outcomes WHERE invalid != '')"
)
_ONE_EACH = (
    "SELECT min(key), mutant, situation, min(seed), origin FROM outcomes"
    " GROUP BY mutant, situation, origin ORDER BY mutant, situation, origin"
)


T = TypeVar("T")
NOTE = "note: "
"""Prefix of the names of notes in the table `meta`."""


class EmptyError(InputError):
    """A store has no tables: nothing was saved, or another process creates them at this moment."""


class Store:
    """Outcomes by key, a hash of what can change the outcome; every `put` is in the file at `path` when it returns."""

    is_record = False
    """Whether its flights count as they stand, whatever the study has become."""

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

    def __exit__(self, *_: object) -> None:
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
        with self._connection:  # commits, or rolls back unless SQLite itself did, as when the disk is full
            yield self._connection

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
        if not os.access(self._place.path.parent, os.W_OK):
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
        self.put_all([(key, outcome)])
        return bool(self._written)

    def put_all(self, rows: Iterable[tuple[str, Outcome]]) -> None:
        """Write outcomes with their keys by the rule of `put`; after a failure none is written.

        Raises:
            InputError: the store cannot be written.
        """
        with self.transaction():
            self._written = sum(self._insert(key, outcome) for key, outcome in rows)

    def _insert(self, key: str, outcome: Outcome) -> int:
        """Write an outcome unless its key has a valid one; returns the number of rows written."""
        number = None
        if outcome.track:  # flights with equal tracks share one row
            track = sha256(outcome.track).digest(), outcome.track
            self._connection.execute("INSERT INTO tracks (sha256, track) VALUES (?, ?) ON CONFLICT DO NOTHING", track)
            (number,) = self._connection.execute("SELECT id FROM tracks WHERE sha256 = ?", track[:1]).fetchone()
        row = {"key": key, "track": number, **dict(zip(record.COLUMNS, record.to_row(outcome), strict=True))}
        return max(0, self._connection.execute(_INSERT, row).rowcount)

    def get(self, key: str) -> Outcome | None:
        """The outcome with this key and its track; None without one."""
        return next((outcome for _, outcome in self.rows([key])), None)

    def rows(self, keys: Iterable[str] | None = None) -> Iterator[tuple[str, Outcome]]:
        """Yield every outcome, or those with `keys`, with key and track, ordered by key."""
        read, track = record.Reader(), "(SELECT tracks.track FROM tracks WHERE tracks.id = outcomes.track)"
        query = f"SELECT {', '.join(_COLUMNS)}, {track} FROM outcomes WHERE key = ?"
        for key in sorted(keys if keys is not None else (flight.key for flight in self.flights())):
            with self._sentences():
                row = self._connection.execute(query, (key,)).fetchone()
                if row is None:
                    continue
                if not isinstance(row[-1], bytes | None):
                    raise record.BadCellError("track", "a packed track", f"table outcomes, key {shown(key)}", row[-1])
                (outcome,) = read([row], [row[-1] or b""])
            yield key, outcome

    def known(self, keys: Iterable[str]) -> set[str]:
        """The `keys` with a valid outcome."""
        with self._sentences():
            stored = {key for (key,) in self._connection.execute("SELECT key FROM outcomes")}
            invalid = self._connection.execute("SELECT key FROM outcomes WHERE invalid != ''")
            return stored.intersection(keys).difference(key for (key,) in invalid)

    def flights(self, *, one_each: bool = False) -> list[FlownFlight]:
        """The flights with an outcome, ordered by mutant, situation, seed; a fast query, answered by an index.

        Args:
            one_each: whether one flight for each mutant, situation and origin is enough.
        """
        with self._sentences():
            return [
                FlownFlight(*row)
                for rows in self._chunks("outcomes", _ONE_EACH if one_each else _FLIGHTS, record.FLIGHT)
                for row in rows
            ]

    def broken(self) -> dict[FlownFlight, str]:
        """The flights with an invalid outcome, each with the reason."""
        cells = {**record.FLIGHT, "invalid": record.TEXT}
        query = f"SELECT {', '.join(cells)}, origin FROM outcomes WHERE invalid != ''"
        with self._sentences():
            rows = [row for rows in self._chunks("outcomes", query, cells) for row in rows]
        return {FlownFlight(key, mutant, at, seed, origin): why for key, mutant, at, seed, why, origin in rows}

    def _chunks(
        self, table: str, query: str, cells: Mapping[str, record.Cell], of: Sequence[str] = ()
    ) -> Iterator[list[tuple[Any, ...]]]:
        """The rows of a query on a table, in which every row of the table occurs once at most.

        Raises:
            BadCellError: a cell has a value that its table does not have.
            TooLargeError: there are more rows than `most_flights`.
        """
        read, most = 0, record.most_flights()
        # a query that is left open, as when a row of it cannot be read, keeps the file open after the connection
        with closing(self._connection.execute(query, of)) as cursor:
            while rows := cursor.fetchmany(CHUNK):
                read += len(rows)
                if read > most:
                    raise record.TooLargeError(table)
                record.check_rows(table, rows, cells)
                yield rows

    def outcomes(self, keys: Iterable[str] | None = None) -> Iterator[Outcome]:
        """All outcomes, or those with `keys`, without their tracks, ordered by mutant, situation, seed."""
        return (outcome for _, outcome in self.keyed(keys))

    def keyed(self, keys: Iterable[str] | None = None) -> list[tuple[str, Outcome]]:
        """All outcomes, or those with `keys`, each with its key, in the order of `outcomes`."""
        wanted = None if keys is None else set(keys)
        return self._selected(
            lambda rows: rows if wanted is None else [row for row in rows if row[record.KEY] in wanted]
        )

    def standing(self, stands: Stands, subjects: Collection[str] | None = None) -> tuple[Outcome, ...]:
        """The outcomes of the current flights, without their tracks, ordered by mutant, situation, seed.

        Args:
            stands: whether a flight is current.
            subjects: ids of the subjects whose flights are read; None: all.
        """
        return tuple([outcome for _, outcome in self._selected(_keeps(stands, tuple(record.COLUMNS)), subjects)])

    def standing_mutants(self, stands: Stands) -> Iterator[Brief]:
        """The current flights of mutants and PLACEBO, in any order."""
        kept, read = _keeps(stands, record.RULED), record.Reader(record.RULED)
        for rows in self._read(record.RULED, "WHERE mutant != ?", (BASELINE,)):
            yield from read.brief(kept(rows))

    def _selected(self, kept_of: Keeps, subjects: Collection[str] | None = None) -> list[tuple[str, Outcome]]:
        """The outcomes of the rows that `kept_of` keeps, each with its key: by mutant, situation, seed, key."""
        read, of = record.Reader(), () if subjects is None else sorted(subjects)
        where = "" if subjects is None else f"WHERE mutant IN ({', '.join('?' * len(of))})"
        places = defaultdict[tuple[str, str], list[tuple[int, str, Outcome]]](list)
        # sorting here is faster than reading the rows in the order of an index
        for rows in self._read(tuple(record.COLUMNS), where, of):
            kept = kept_of(rows)
            for outcome, row in zip(read(kept), kept, strict=True):
                places[outcome.subject.id, outcome.situation].append((outcome.seed, row[record.KEY], outcome))
        # keys are distinct
        return [(key, one) for place in sorted(places) for _, key, one in sorted(places[place])]

    def _read(self, columns: Sequence[str], where: str, of: Sequence[str]) -> Iterator[list[record.Record]]:
        """Rows of these columns, and of `_NAMES` after them, in any order."""
        with self._sentences():
            self._connection.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, MOST_CELL_BYTES)
            try:
                query = f"SELECT {', '.join((*columns, *_NAMES))} FROM outcomes {where}"
                yield from self._chunks("outcomes", query, {}, of)
            except (sqlite3.DataError, sqlite3.OperationalError) as error:
                raise self._located() or error from error
            finally:
                self._connection.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, MOST_BYTES)

    def _located(self) -> record.BadCellError | None:
        """The first cell of an outcome that SQLite cannot give, because it is too large or no UTF-8."""
        for rows in self._chunks("outcomes", "SELECT id FROM outcomes", {}):
            for (number,) in rows:
                for column in _COLUMNS:
                    try:
                        self._connection.execute(f"SELECT {column} FROM outcomes WHERE id = ?", (number,)).fetchone()
                    except (sqlite3.DataError, sqlite3.OperationalError):
                        allowed = f"UTF-8 text of at most {MOST_CELL_BYTES} bytes"
                        return record.BadCellError(column, allowed, f"table outcomes, id {number}")
        return None

    def plan(self, flights: Iterable[record.Planned]) -> None:
        """Record planned flights in one transaction; earlier records stay.

        Raises:
            InputError: the store cannot be written.
        """
        with self.transaction():
            origins: dict[record.Origin | None, int | None] = {None: None}
            for flight in flights:
                if flight.origin is not None and flight.origin not in origins:
                    origins[flight.origin] = self.origin(flight.origin)
                self._connection.execute(
                    "INSERT INTO plan (key, mutant, situation, seed, canary, origin) VALUES (?, ?, ?, ?, ?, ?)"
                    " ON CONFLICT (key) DO UPDATE SET canary = min(canary, excluded.canary)"
                    " WHERE canary > excluded.canary",
                    (*flight[:5], origins[flight.origin]),
                )
            (number,) = self._connection.execute("SELECT count(*) FROM plan").fetchone()
            if number > record.most_flights():
                raise record.TooLargeError("plan")

    def origin(self, origin: record.Origin) -> int:
        """The number of an origin inside the caller's transaction; flights with equal origins share one row."""
        parts = json.dumps(origin._asdict())
        self._connection.execute("INSERT INTO origins (parts) VALUES (?) ON CONFLICT (parts) DO NOTHING", (parts,))
        return int(self._connection.execute("SELECT id FROM origins WHERE parts = ?", (parts,)).fetchone()[0])

    def origins(self) -> dict[int, record.Origin]:
        """The origins of all recorded flights by number."""
        found: dict[int, record.Origin] = {}
        with self._sentences():
            for rows in self._chunks("origins", "SELECT id, parts FROM origins", {}):
                for number, parts in rows:
                    try:
                        if len(parts) > record.MOST_LINE:
                            raise ValueError("too long")
                        found[number] = record.Origin(**record.decoded(parts))
                        "".join(found[number])
                    except (TypeError, ValueError) as error:
                        allowed = f"a JSON object with the texts {', '.join(record.Origin._fields)}"
                        raise record.BadCellError("parts", allowed, f"table origins, id {number}", parts) from error
        return found

    def planned(self, *, unflown: bool = False) -> list[record.Planned]:
        """All recorded plans, or those without a valid outcome, ordered by key."""
        known, wanted = self.origins(), _UNFLOWN if unflown else "1"
        query = f"SELECT key, mutant, situation, seed, canary, origin, {wanted} FROM plan ORDER BY key"
        with self._sentences():
            return [
                record.Planned(key, intern(mutant), intern(situation), seed, bool(canary), known.get(origin))
                for rows in self._chunks("plan", query, record.FLIGHT)
                for key, mutant, situation, seed, canary, origin, asked in rows
                if asked
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

    def remember(self, prefix: str, content: object, name: object = None) -> None:
        """Note `content` in JSON for `records`; the note is called `prefix` and `name`, else a hash of the content.

        Raises:
            InputError: the store cannot be written.
        """
        text = json.dumps(content)
        self.set_notes({f"{prefix} {sha256(text.encode()).hexdigest()[:16] if name is None else name}": text})

    def records(self, prefix: str, read: Callable[[Any], T]) -> list[T]:
        """What `read` makes of the JSON of each note whose name begins with `prefix` and a space, in their order.

        Raises:
            InputError: a note is no JSON, or `read` raises an error for it.
        """
        found = []
        for name, text in self.notes().items():
            if name.startswith(f"{prefix} "):
                try:
                    found.append(read(record.decoded(text)))
                except (ValueError, TypeError, KeyError, OverflowError) as error:
                    row = f"table meta, name {shown(NOTE + name)}"
                    raise InputError(f"{self.path}: {row}: value={shown(text)} must be a record of `run`") from error
        return found

    def _facts(self) -> list[tuple[str, str]]:
        query = "SELECT name, value FROM meta ORDER BY name"
        with self._sentences():
            return [
                row
                for rows in self._chunks("meta", query, {"name": record.LABEL, "value": record.TEXT})
                for row in rows
            ]


Keeps = Callable[[list[record.Record]], list[record.Record]]
"""Those of some rows that are kept."""


def _keeps(stands: Stands, columns: tuple[str, ...]) -> Keeps:
    """The rows of `columns` and `_NAMES` that are of current flights; `stands` is asked as `Stands` says."""
    columns += _NAMES
    flown = itemgetter(*map(columns.index, FlownFlight._fields))
    place_of = itemgetter(*map(columns.index, ("mutant", "situation", "origin")))
    answers: dict[tuple[Any, ...], bool] = {}

    def keep(row: record.Record) -> bool:
        answer = answers.get(place := place_of(row))
        if answer is None:
            flight = FlownFlight(*flown(row))
            answer = stands(flight)
            if flight.origin is not None:
                answers[place] = answer
        return answer

    def kept(rows: list[record.Record]) -> list[record.Record]:
        # most places are known, and most flights of a campaign stand
        if all(map(answers.get, set(map(place_of, rows)))):
            return rows
        record.check_rows("outcomes", list(map(flown, rows)), record.FLIGHT)
        return list(filter(keep, rows))

    return kept


def _flights(number: int) -> str:
    return f"{number} flight{'s' * (number != 1)}"


@contextmanager
def read_store(path: Path) -> Iterator[Store | None]:
    """Open a store to read; None where there is no file, or one without tables."""
    try:
        store = Store(path, create=False) if path.is_file() else None
    except EmptyError:
        store = None
    with store or nullcontext():
        yield store
