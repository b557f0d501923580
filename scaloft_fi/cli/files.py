"""Files that the user names for output."""

from __future__ import annotations

import os
from pathlib import Path

from scaloft_fi.errors import InputError
from scaloft_fi.output import unwritable, write_named


def check_writable(path: Path | None) -> None:
    """Refuse early what could not be written late; None is fine.

    Raises:
        InputError: no file can be written there.
    """
    if path is None:
        return
    try:
        path.stat()
    except FileNotFoundError:
        pass
    except (OSError, ValueError) as error:
        raise InputError(f"--output={str(path)!r} cannot be written: {unwritable(error)}") from error
    if path.is_dir():
        raise InputError(f"--output={str(path)!r} cannot be written: it is a folder")
    if not path.parent.is_dir():
        raise InputError(f"--output={str(path)!r} cannot be written: there is no folder {str(path.parent)!r}")
    if not os.access(path if path.exists() else path.parent, os.W_OK):
        raise InputError(f"--output={str(path)!r} cannot be written: no permission")


def write(path: Path, content: bytes, option: str = "--output") -> None:
    """Write the whole file, or leave what was there; `option` names it.

    Raises:
        InputError: it cannot be written.
    """
    write_named(path, content, option)


def check_folder(path: Path, option: str) -> None:
    """Refuse early a folder that could not be made or written late; `option` names it.

    Raises:
        InputError: no file can be written in a folder of this path.
    """
    try:
        existing = next(folder for folder in (path, *path.absolute().parents) if folder.exists())
    except (OSError, ValueError) as error:
        raise InputError(f"{option}={str(path)!r} cannot be written: {unwritable(error)}") from error
    if not existing.is_dir():
        raise InputError(f"{option}={str(path)!r} cannot be written: {str(existing)!r} is a file, not a folder")
    if not os.access(existing, os.W_OK | os.X_OK):
        raise InputError(f"{option}={str(path)!r} cannot be written: no permission in {str(existing)!r}")


def make_folder(path: Path, option: str) -> None:
    """Make the folder and those above it, where they are missing; `option` names it.

    Raises:
        InputError: it cannot be made.
    """
    try:
        path.mkdir(parents=True, exist_ok=True)
    except (OSError, ValueError) as error:
        raise InputError(f"{option}={str(path)!r} cannot be made: {unwritable(error)}") from error
