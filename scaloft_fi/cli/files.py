"""Files that the user names for output."""

from __future__ import annotations

import os
from pathlib import Path

from scaloft_fi.errors import InputError


def check_writable(path: Path | None) -> None:
    """Refuse early what could not be written late; None is fine.

    Raises:
        InputError: no file can be written there.
    """
    if path is None:
        return
    if path.is_dir():
        raise InputError(f"--output={str(path)!r} cannot be written: it is a folder")
    if not path.parent.is_dir():
        raise InputError(f"--output={str(path)!r} cannot be written: there is no folder {str(path.parent)!r}")
    if not os.access(path if path.exists() else path.parent, os.W_OK):
        raise InputError(f"--output={str(path)!r} cannot be written: no permission")


def write(path: Path, content: bytes) -> None:
    """Write the whole file.

    Raises:
        InputError: it cannot be written.
    """
    try:
        path.write_bytes(content)
    except OSError as error:
        raise InputError(f"--output={str(path)!r} cannot be written: {error.strerror}") from error
