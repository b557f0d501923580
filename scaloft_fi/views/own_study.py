"""The refusal to write into a study of nobody."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from scaloft_fi.errors import InputError
from scaloft_fi.hazop.load import nearest_study

if TYPE_CHECKING:
    from scaloft_fi.study import Study

REMEDY = "make a study of your own with `scaloft-fi new DIR`, or name one with --study"


def check_own(study: Study, named: Path | None, path: Path) -> None:
    """Refuse to write `path` into a study that the user neither named nor stands in, or that is the package's.

    Raises:
        InputError: as above.
    """
    if study.packaged or (named is None and nearest_study() is None):
        raise InputError(f"{path} belongs to the reference study of this installation and is not written; {REMEDY}")
