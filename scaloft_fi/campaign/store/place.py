"""The place of an open store: notice when its file is no longer there, and save what the open file holds."""

from __future__ import annotations

import os
import sqlite3
import tempfile
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager, suppress
from pathlib import Path
from threading import Timer

from scaloft_fi.campaign.store.opening import log_of

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
