"""Open the file of a store: to write, or to read without leaving a trace."""

from __future__ import annotations

import os
import sqlite3
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from scaloft_fi.campaign.store.cells import MOST_BYTES, BadCellError, TooLargeError
from scaloft_fi.campaign.store.schema import SCHEMA, deviation
from scaloft_fi.errors import InputError

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
