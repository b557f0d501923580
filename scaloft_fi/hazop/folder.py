"""Finds the folder of the study."""

from __future__ import annotations

from pathlib import Path

from scaloft_fi.errors import InputError
from scaloft_fi.reading import is_folder

FOLDERS = ("hazop", "mutants", "sim")
_PACKAGE = Path(__file__).resolve().parents[1]


def find_study(path: Path | str | None = None) -> Path:
    """Find the study's folder: `path`, else the nearest study upwards, the packaged study, or the checkout's.

    Raises:
        InputError: `path` is not a study, or no study exists in any of these places.
    """
    if path is not None:
        lacking = [f"{name}/" for name in FOLDERS if not is_folder(Path(path) / name)]
        if lacking:
            allowed = "a folder with hazop/, mutants/ and sim/"
            raise InputError(f"--study={str(path)!r} must be {allowed}; it lacks {', '.join(lacking)}")
        return Path(path)
    here = _here()
    near = nearest_study(here)
    if near is not None:
        return near
    try:
        return reference_study()
    except InputError as error:
        allowed = "a folder with hazop/, mutants/ and sim/"
        raise InputError(f"no study in {here} or above it: {allowed}; name one with --study") from error


def reference_study() -> Path:
    """The study of this installation: the packaged study, else the checkout's.

    Raises:
        InputError: the installation has lost it.
    """
    for folder in (_PACKAGE / "_study", _PACKAGE.parent):
        if _is_study(folder):
            return folder
    raise InputError(f"{_PACKAGE}: the reference study is missing; install scaloft-fi again")


def nearest_study(folder: Path | None = None) -> Path | None:
    """The study in a folder (default: the current one), or in the nearest folder above it; None where there is none.

    Raises:
        InputError: the current folder cannot be read.
    """
    here = folder or _here()
    return next((one for one in (here, *here.parents) if one != _PACKAGE and _is_study(one)), None)


def _is_study(folder: Path) -> bool:
    """The package has folders of these names too; callers leave it out."""
    return all(is_folder(folder / name) for name in FOLDERS)


def _here() -> Path:
    try:
        return Path.cwd()
    except OSError as error:
        raise InputError(
            f"the current folder cannot be read: {error.strerror}; go to another or name --study"
        ) from error
