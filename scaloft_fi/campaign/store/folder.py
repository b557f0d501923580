"""Where a campaign lives on disk."""

from __future__ import annotations

import os
from pathlib import Path

from scaloft_fi.errors import InputError, did_you_mean
from scaloft_fi.study import Study

STORE_NAME = "outcomes.sqlite"
LOG_NAME = "mission_log.json"


def campaign_folder(study: Study, name: str) -> Path:
    """The folder of campaign `name`: in the study's results, or `name` itself when it has a separator in it.

    Raises:
        InputError: the name cannot be that of a folder.
    """
    if "/" in name or os.sep in name:
        return Path(name).expanduser()
    if not name.strip() or name in {".", ".."} or "\0" in name:
        raise InputError(f"--campaign: name={name!r} must be the name of a folder, such as 'default'")
    return study.results_folder / "campaigns" / name


def promising(folder: Path) -> None:
    """Refuse early what `writable` would refuse later; writes nothing.

    Raises:
        InputError: the nearest folder above that exists cannot be written, or is none.
    """
    above = next(path for path in (folder.absolute(), *folder.absolute().parents) if path.exists())
    if not above.is_dir() or not os.access(above, os.W_OK):
        reason = "permission denied" if above.is_dir() else f"{above} is no folder"
        raise InputError(f"{folder}: the results folder cannot be written: {reason}")


def writable(folder: Path) -> Path:
    """`folder`, made if need be, after a proof that files can be written there.

    Raises:
        InputError: they cannot.
    """
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
        InputError: nothing was flown there.
    """
    store = folder / STORE_NAME
    if not store.is_file():
        others = [entry.parent.name for entry in folder.parent.glob(f"*/{STORE_NAME}")]
        raise InputError(f"{folder}: no campaign was flown here{did_you_mean(folder.name, others)}")
    return store
