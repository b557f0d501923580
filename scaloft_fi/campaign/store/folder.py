"""The folder of a campaign."""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path

from scaloft_fi.document import is_file
from scaloft_fi.errors import InputError, did_you_mean, shown
from scaloft_fi.study import Study

STORE_NAME = "outcomes.sqlite"
LONGEST_NAME = 255
"""Longest name of a file on the usual file systems [bytes]."""
LOG_NAME = "mission_log.json"
MANIFEST, ZIP = "campaign.json", ".zip"
"""The file that makes a folder an archive; the end of the name of an archive in one file."""
RECORD = "an archive is a record, into which nothing is flown or merged; name another --campaign"


def campaign_folder(study: Study, name: str) -> Path:
    """The folder of campaign `name`: in the study's results, or the path `name` itself if it has a separator.

    An archive may be one file, whose name ends in `.zip`; such a name is a path.

    Raises:
        InputError: the name is no valid name of a folder.
    """
    if "/" in name or os.sep in name or name.endswith(ZIP):
        return _reached(name)
    if not name.strip() or name in {".", ".."} or "\0" in name or len(os.fsencode(name)) > LONGEST_NAME:
        raise InputError(f"--campaign: name={shown(name)} must be the name of a folder, such as 'default'")
    return study.results_folder / "campaigns" / name


def _reached(name: str) -> Path:
    """The folder at the path `name`, which need not exist."""
    try:
        folder = Path(name).expanduser()
        with suppress(FileNotFoundError, NotADirectoryError, PermissionError):
            folder.stat()  # raises where the system refuses the name
    except (OSError, RuntimeError, ValueError) as error:
        reason = (error.strerror if isinstance(error, OSError) else None) or str(error)
        raise InputError(f"--campaign: name={shown(name)} must be the path of a folder: {reason}") from error
    return folder


def is_archive(folder: Path) -> bool:
    """Whether a campaign's folder is an archive: a ZIP file, or a folder with the record of one and no store."""
    if folder.suffix == ZIP:
        return is_file(folder)
    return is_file(folder / MANIFEST) and not is_file(folder / STORE_NAME)


def promising(folder: Path) -> None:
    """Check early, without writing, whether `writable` can succeed.

    Raises:
        InputError: the nearest existing parent cannot be written, or is no folder; or the folder is an archive.
    """
    if is_archive(folder):
        raise InputError(f"{folder}: {RECORD}")
    above = next(path for path in (folder.absolute(), *folder.absolute().parents) if path.exists())
    if not above.is_dir() or not os.access(above, os.W_OK):
        reason = "permission denied" if above.is_dir() else f"{above} is no folder"
        raise InputError(f"{folder}: the results folder cannot be written: {reason}")


def writable(folder: Path) -> Path:
    """Create `folder` if it is missing, and check that files can be written there.

    Raises:
        InputError: files cannot be written there, or the folder is an archive.
    """
    if is_archive(folder):
        raise InputError(f"{folder}: {RECORD}")
    probe = folder / f".writable-{os.getpid()}"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        probe.touch()
        probe.unlink()
    except OSError as error:
        raise InputError(f"{folder}: the results folder cannot be written: {error.strerror}") from error
    return folder


def existing(folder: Path) -> Path:
    """The store of the campaign in `folder`.

    Raises:
        InputError: the folder has no store.
    """
    if is_archive(folder):
        raise InputError(f"{folder}: an archive is a record, which lends no flights; name a campaign")
    store = folder / STORE_NAME
    if not store.is_file():
        others = [entry.parent.name for entry in folder.parent.glob(f"*/{STORE_NAME}")]
        hint = did_you_mean(folder.name, others) or "; `scaloft-fi run` flies one"
        raise InputError(f"{folder}: no campaign was flown here{hint}")
    return store
