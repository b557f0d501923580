"""Which study a verb works on when the user names none."""

from __future__ import annotations

from pathlib import Path

from scaloft_fi.console import say
from scaloft_fi.hazop.folder import find_study, nearest_study
from scaloft_fi.views.own_study import REMEDY


def tell_study(named: Path | None, *, quiet: bool) -> None:
    """Say in a line on standard error which study is used, where the user neither named one nor stands in one.

    Raises:
        InputError: there is no study at all.
    """
    if named is None and not quiet and nearest_study() is None:
        say(f"study: {find_study()}, the reference study of this installation; there is none here: {REMEDY}")
