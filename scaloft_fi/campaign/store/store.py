"""The campaign's store: one SQLite file, one transaction per flight, safe against a kill at any moment."""

from __future__ import annotations

import json
import os
import sqlite3
import tempfile
import time
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, closing, contextmanager, suppress
from functools import cache
from hashlib import sha256
from itertools import chain, repeat
from operator import itemgetter
from pathlib import Path
from threading import Timer
from types import TracebackType
from typing import Any, NamedTuple, TypeVar

from scaloft_fi.campaign.store.origin import Origin
from scaloft_fi.campaign.store.record import (
    COLUMNS,
    FLIGHT,
    MOST_BYTES,
    MOST_CELL_BYTES,
    BadCellError,
    Planned,
    Reader,
    Record,
    TooLargeError,
    check_rows,
    chunks,
    decoded,
    facts,
    most_flights,
    origins,
    planned,
    shown,
    to_row,
)
from scaloft_fi.errors import InputError
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
    fixed = not (write or _can_be_written(path) or log_of(path).exists())
    mode = "immutable=1" if fixed else "mode=rwc" if write else "mode=rw"
    # rows are written one by one in explicit transactions
    connection = sqlite3.connect(f"{path.absolute().as_uri()}?{mode}", timeout=BUSY_S, isolation_level=None, uri=True)
    connection.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, MOST_BYTES)
    connection.execute("PRAGMA trusted_schema=OFF")
    connection.execute("PRAGMA cell_size_check=ON")
    if not write:
        connection.execute("PRAGMA query_only=ON")
    return connection


def _can_be_written(path: Path) -> bool:
    return os.access(path.parent, os.W_OK) and os.access(path, os.W_OK)


def is_new(connection: sqlite3.Connection, path: Path) -> bool:
    """Whether the file has no tables yet.

    Raises:
        InputError: the file has tables that are not those of a store of this version.
    """
    version = int(connection.execute("PRAGMA user_version").fetchone()[0])
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
    _keep_log(connection)
    connection.execute("PRAGMA synchronous=FULL")


def _keep_log(connection: sqlite3.Connection) -> None:
    """Turn on the write-ahead log; SQLite does not wait for another process that creates the same file."""
    end_s = time.monotonic() + BUSY_S
    while True:
        try:
            connection.execute("PRAGMA journal_mode=WAL")
        except sqlite3.OperationalError as error:
            if "locked" not in str(error) or time.monotonic() > end_s:
                raise
            time.sleep(RETRY_S)
        else:
            return


@contextmanager
def sentences(path: Path, kept: Callable[[], str] = lambda: "") -> Iterator[None]:
    """Turn errors of SQLite, of the file system and of the cells into an `InputError` of one sentence.

    Args:
        path: path of the store.
        kept: what is kept after a failure, in words.
    """
    try:
        yield
    except (BadCellError, TooLargeError) as error:
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
        self._names = [str(self.path), str(log_of(self.path))]
        self._open = {name: _identity(os.stat(name)) for name in self._names if os.path.exists(name)}  # noqa: PTH110, PTH116 - fast
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
            if _identity(state) != known:
                return f"{os.path.basename(name)} was replaced by another file"  # noqa: PTH119
            if name == self._names[0]:
                if state.st_size < self._size:
                    return f"{os.path.basename(name)} was cut"  # noqa: PTH119
                self._size = state.st_size
        return ""

    def is_locked(self) -> bool:
        """Whether the folder can no longer be written."""
        return not os.access(self.path.parent, os.W_OK)


def _identity(state: os.stat_result) -> tuple[int, int]:
    return state.st_dev, state.st_ino


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
Keep = Callable[[Record], bool]
_COLUMNS = (*COLUMNS, "key", "origin")
_KEY, _ORIGIN = _COLUMNS.index("key"), _COLUMNS.index("origin")
_flown = itemgetter(*map(_COLUMNS.index, FlownFlight._fields))
_place = itemgetter(*map(_COLUMNS.index, ("mutant", "situation", "origin")))


def under(keys: set[str]) -> Keep:
    """Select the rows with these keys."""
    return lambda row: row[_KEY] in keys


def standing(stands: Stands) -> Keep:
    """Select the rows of current flights."""
    answers: dict[tuple[Any, ...], bool] = {}

    def keep(row: Record) -> bool:
        place = _place(row)
        answer = answers.get(place)
        if answer is None:
            flight = FlownFlight(*_flown(row))
            if tuple(map(type, flight[1:3])) != (str, str) or type(flight.key) is not str:
                check_rows("outcomes", [flight], FLIGHT)
            answer = stands(flight)
            if flight.origin is not None:
                answers[place] = answer
        return answer

    return keep


_ALL = f"SELECT {', '.join(FlownFlight._fields)} FROM outcomes ORDER BY mutant, situation, seed, key"
_ONE_EACH = (
    "SELECT min(key), mutant, situation, min(seed), origin FROM outcomes"
    " GROUP BY mutant, situation, origin ORDER BY mutant, situation, origin"
)


def flown(connection: sqlite3.Connection, *, one_each: bool = False) -> list[FlownFlight]:
    """The flights with an outcome, ordered by mutant, situation, seed, key; or one for each mutant, situation, origin.

    Raises:
        BadCellError: a cell has a value that no flight has.
        TooLargeError: there are more rows than `most_flights`.
    """
    found: list[FlownFlight] = []
    for rows in chunks(connection, "outcomes", _ONE_EACH if one_each else _ALL):
        check_rows("outcomes", rows, FLIGHT)
        found += map(FlownFlight._make, rows)
    return found


def checked(read: Reader, rows: Sequence[Record], tracks: Iterable[bytes] = repeat(b"")) -> list[Outcome]:
    """The outcomes of rows with `_COLUMNS`; an error names the first bad row.

    Raises:
        BadCellError: a cell has a value that no outcome has.
        TooLargeError: the texts are larger than the limit.
    """
    try:
        return read(rows, tracks)
    except BadCellError:
        for row in rows:
            try:
                Reader()([row])
            except BadCellError as error:
                value = row[_COLUMNS.index(error.column)]
                raise error.at(f"table outcomes, key {shown(row[_KEY])}", value) from None
        raise


def outcomes(connection: sqlite3.Connection, keep: Keep | None = None) -> Iterator[tuple[str, Outcome]]:
    """The outcomes of the selected rows, each with its key, ordered by mutant, situation, seed, key.

    Args:
        connection: connection to the store.
        keep: whether a row is selected; None = all rows.

    Raises:
        BadCellError: a cell has a value that no outcome has.
        TooLargeError: there are more rows or larger texts than the limit.
    """
    read = Reader()
    places = defaultdict[tuple[str, str], list[tuple[int, str, Outcome]]](list)
    # sorting here is faster than reading the rows in the order of an index
    connection.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, MOST_CELL_BYTES)
    try:
        for rows in chunks(connection, "outcomes", f"SELECT {', '.join(_COLUMNS)} FROM outcomes"):
            kept = list(filter(keep, rows)) if keep else rows
            for outcome, row in zip(checked(read, kept), kept, strict=True):
                places[outcome.subject.id, outcome.situation].append((outcome.seed, row[_KEY], outcome))
    except (sqlite3.DataError, sqlite3.OperationalError) as error:
        raise _located(connection) or error from error
    finally:
        connection.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, MOST_BYTES)
    # keys are distinct
    return ((key, one) for _, key, one in chain.from_iterable(sorted(places[place]) for place in sorted(places)))


def tracked(connection: sqlite3.Connection, read: Reader, key: str) -> Outcome | None:
    """The outcome with this key and its track; None without one.

    Raises:
        BadCellError: a cell has a value that no outcome has.
    """
    track = "(SELECT tracks.track FROM tracks WHERE tracks.id = outcomes.track)"
    query = f"SELECT {', '.join(_COLUMNS)}, {track} FROM outcomes WHERE key = ?"
    row = connection.execute(query, (key,)).fetchone()
    if row is None:
        return None
    if not isinstance(row[-1], bytes | None):
        raise BadCellError("track", "a packed track", f"table outcomes, key {shown(key)}", row[-1])
    return checked(read, [row], [row[-1] or b""])[0]


def _located(connection: sqlite3.Connection) -> BadCellError | None:
    """The first cell of an outcome that SQLite cannot give, because it is too large or no UTF-8."""
    for rows in chunks(connection, "outcomes", "SELECT id FROM outcomes"):
        for (number,) in rows:
            for column in _COLUMNS:
                try:
                    connection.execute(f"SELECT {column} FROM outcomes WHERE id = ?", (number,)).fetchone()
                except (sqlite3.DataError, sqlite3.OperationalError):
                    allowed = f"UTF-8 text of at most {MOST_CELL_BYTES} bytes"
                    return BadCellError(column, allowed, f"table outcomes, id {number}")
    return None


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

    def flights(self, *, one_each: bool = False) -> list[FlownFlight]:
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
