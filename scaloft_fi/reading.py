"""Reads the files that a user writes or names: regular files up to a size, each refusal in one sentence.

No other module of the package opens such a file, because a pipe, a device or an endless file must never hang a verb or
fill the memory.
"""

from __future__ import annotations

import hashlib
import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from io import BufferedReader
from pathlib import Path

from scaloft_fi.errors import InputError

MIB = 1 << 20
DOCUMENT_BYTES = 4 * MIB
"""Largest YAML file; those of the reference study have at most 25 kB."""
CATALOGUE_BYTES = 16 * MIB
"""Largest catalogue: some 60,000 mutants."""
FILE_BYTES = 1024 * MIB
"""Largest file of any other kind in a study."""

_KINDS = {
    stat.S_IFDIR: "a folder",
    stat.S_IFIFO: "a pipe",
    stat.S_IFCHR: "a device",
    stat.S_IFBLK: "a device",
    stat.S_IFSOCK: "a socket",
}


class UnreadableError(InputError):
    """A file cannot be read.  path: the file; reason: why, without the name of the file."""

    def __init__(self, path: Path, reason: str) -> None:
        super().__init__(path, reason)
        self.path = path
        self.reason = reason

    def __str__(self) -> str:
        """The sentence."""
        return f"{self.path}: cannot be read: {self.reason}"


def read_bytes(path: Path, most_bytes: int = FILE_BYTES) -> bytes:
    """The content of a file.

    Raises:
        UnreadableError: the file is no regular file, is larger than `most_bytes`, or cannot be opened.
    """
    with opened(path, most_bytes) as file:
        content = file.read(most_bytes + 1)
    if len(content) > most_bytes:  # it has grown since it was opened, or its file system gives no sizes
        raise UnreadableError(path, _too_large(most_bytes))
    return content


def read_text(path: Path, most_bytes: int = DOCUMENT_BYTES) -> str:
    """The content of a text file.

    Raises:
        UnreadableError: as `read_bytes`, or the content is not UTF-8.
    """
    try:
        return read_bytes(path, most_bytes).decode("utf-8")
    except UnicodeDecodeError as error:
        raise UnreadableError(path, "not UTF-8 text") from error


def digest(path: Path, most_bytes: int = FILE_BYTES) -> str:
    """SHA-256 of a file, read piece by piece.

    Raises:
        UnreadableError: as `read_bytes`.
    """
    with opened(path, most_bytes) as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def is_file(path: Path) -> bool:
    """Whether `path` is a regular file; False also where the system refuses the name (`Path.is_file` would raise)."""
    return os.path.isfile(path)  # noqa: PTH113


def is_folder(path: Path) -> bool:
    """Whether `path` is a folder; False also where the system refuses the name."""
    return os.path.isdir(path)  # noqa: PTH112


def is_there(path: Path) -> bool:
    """Whether `path` names anything, a link that leads nowhere included: such a link is refused, not overlooked."""
    return os.path.lexists(path)


@contextmanager
def opened(path: Path, most_bytes: int = FILE_BYTES) -> Iterator[BufferedReader]:
    """The file, open for reading; the open file itself is checked, so that nobody can exchange it after the check.

    Raises:
        UnreadableError: as `read_bytes`.
    """
    try:
        # Without O_NONBLOCK, opening a pipe waits for a writer.
        number = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0))
    except (OSError, ValueError) as error:
        raise _unreadable(path, error) from error
    try:
        _check(path, os.fstat(number), most_bytes)
    except UnreadableError:
        os.close(number)
        raise
    try:
        with open(number, "rb") as file:  # noqa: PTH123 - it is open
            yield file
    except OSError as error:
        raise _unreadable(path, error) from error


def _check(path: Path, status: os.stat_result, most_bytes: int) -> None:
    if not stat.S_ISREG(status.st_mode):
        kind = _KINDS.get(stat.S_IFMT(status.st_mode), "of another kind")
        raise UnreadableError(path, f"it is {kind}, and must be a regular file")
    if status.st_size > most_bytes:
        raise UnreadableError(path, _too_large(most_bytes))


def _unreadable(path: Path, error: OSError | ValueError) -> UnreadableError:
    """The refusal of the system; a ValueError is a NUL in the name."""
    return UnreadableError(path, (error.strerror if isinstance(error, OSError) else None) or str(error))


def _too_large(most_bytes: int) -> str:
    return f"it is larger than {most_bytes:,} bytes"
