"""Which study a verb works on when the user names none."""

from __future__ import annotations

from pathlib import Path

from scaloft_fi.console import say
from scaloft_fi.hazop.load import find_study, nearest_study
from scaloft_fi.views.own_study import REMEDY


def tell_study(named: Path | None, *, quiet: bool, campaign: str = "") -> None:
    """Say in a line on standard error which study is used, where the user neither named one nor stands in one.

    Args:
        named: the study that the user named.
        quiet: whether nothing is said.
        campaign: the campaign that the user named, which may be an archive that has its study.

    Raises:
        InputError: there is no study at all.
    """
    if named is None and not quiet and nearest_study() is None and not _has_study(campaign):
        say(f"study: {find_study()}, the reference study of this installation; there is none here: {REMEDY}")


def _has_study(campaign: str) -> bool:
    """Whether the campaign is an archive that may have a study of its own."""
    if "/" not in campaign and not campaign.endswith(".zip"):
        return False
    from scaloft_fi.campaign.store.archive import is_archive

    return is_archive(Path(campaign))
