"""Which study a verb works on when the user names none, and the refusal to write into a study of nobody."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from scaloft_fi.console import say
from scaloft_fi.errors import InputError
from scaloft_fi.hazop.folder import find_study, nearest_study

if TYPE_CHECKING:
    from scaloft_fi.study import Study

REMEDY = "make a study of your own with `scaloft-fi new DIR`, or name one with --study"


def tell_study(named: Path | None, *, quiet: bool) -> None:
    """Say in a line on standard error which study is used, where the user neither named one nor stands in one.

    Raises:
        InputError: there is no study at all.
    """
    if named is None and not quiet and nearest_study() is None:
        say(f"study: {find_study()}, the reference study of this installation; there is none here: {REMEDY}")


def check_own(study: Study, named: Path | None, path: Path) -> None:
    """Refuse to write `path` into a study that the user neither named nor stands in, or that is the package's.

    Raises:
        InputError: as above.
    """
    if study.packaged or (named is None and nearest_study() is None):
        raise InputError(f"{path} belongs to the reference study of this installation and is not written; {REMEDY}")
