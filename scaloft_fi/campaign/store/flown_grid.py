"""The grid over which a campaign is flown: its name stands in the store, so that verbs that read need not be told."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from scaloft_fi.campaign.store.archive import STORE_NAME, Archive, campaign_folder, existing, is_archive
from scaloft_fi.campaign.store.store import Store, read_store
from scaloft_fi.errors import InputError, did_you_mean, shown
from scaloft_fi.sim.grid import grid_names
from scaloft_fi.study import Study

NOTE = "grid"
"""Prefix of the name of the record."""


def study_of(folder: Path | str | None, campaign: str, grid: str | None = None) -> Study:
    """Open the study in `folder` with the grid of a campaign.

    Args:
        folder: the study, as for `Study.open`.
        campaign: name of the campaign, which need not exist.
        grid: the grid that the user names; None for that of the campaign.

    Raises:
        InputError: there is no such study or grid, or the campaign was flown over another grid.
    """
    archived = is_archive(campaign_folder(Study.open(folder), campaign))
    study = Study.open(folder, None if archived else grid)  # an archive may have its own grids
    flown = _flown(study, campaign)
    if flown is not None and grid is not None and grid != flown.grid.name:
        other = f"campaign {shown(campaign)} was flown over grid {flown.grid.name!r}"
        raise InputError(f"--grid={grid}: {other}; name another --campaign")
    return flown or study


def study_of_all(folder: Path | str | None, campaigns: Sequence[str]) -> Study:
    """Open the study in `folder` with the grid of all of these campaigns; those without flights have any grid.

    Raises:
        InputError: there is no such study, or two campaigns were flown over different grids.
    """
    study = Study.open(folder)
    flown = {name: there for name in campaigns if (there := _flown(study, name)) is not None}
    for name, there in flown.items():
        first, over = next(iter(flown.items()))
        if there.grid_name != over.grid_name:
            grids = f"{shown(name)} was flown over grid {there.grid.name!r}, and {shown(first)} over {over.grid.name!r}"
            raise InputError(f"campaign {grids}; only campaigns of one grid have the same situations")
    return next(iter(flown.values()), study)


def opened(study: Study, folder: Path) -> tuple[Study, Store]:
    """Open the campaign in a folder, or an archive, to read; the caller closes it.

    Args:
        study: the study, with any of its grids.
        folder: the folder of the campaign, or an archive.

    Returns:
        what was flown, with the grid of the campaign: of an archive with documents these; and the open store.

    Raises:
        InputError: there is no campaign, it cannot be read, or the study lacks its grid.
    """
    if is_archive(folder):
        archive = Archive(folder, study)
        archive.study = with_grid(archive.study, archive)
        return archive.study, archive
    store = Store(existing(folder), create=False)
    try:
        return with_grid(study, store), store
    except BaseException:
        store.close()
        raise


def with_grid(study: Study, store: Store) -> Study:
    """The study with the grid of a campaign.

    Raises:
        InputError: the study has no such grid.
    """
    wanted = flown_grid(store)
    if wanted is not None:
        names = grid_names(study.folder / "sim")
        if wanted not in names:
            lost = f"{store.path.parent}: the campaign was flown over grid {shown(wanted)}, which the study lacks"
            raise InputError(f"{lost}{did_you_mean(wanted, names)}")
        wanted = None if wanted == names[0] else wanted
    return study if wanted == study.grid_name else replace(study, grid_name=wanted)


def remember_grid(store: Store, study: Study) -> None:
    """Record the grid of a campaign; a campaign over the study's own grid needs no record."""
    if study.grid_name is not None and flown_grid(store) != study.grid_name:
        store.remember(NOTE, study.grid_name, "flown")


def _flown(study: Study, campaign: str) -> Study | None:
    """The study with the grid of a campaign; None for a campaign without planned flights."""
    folder = campaign_folder(study, campaign)
    if is_archive(folder):
        return opened(study, folder)[0]
    with read_store(folder / STORE_NAME) as store:
        if store is None or (flown_grid(store) is None and not store.planned()):
            return None
        return with_grid(study, store)


def flown_grid(store: Store) -> str | None:
    """The name of the campaign's grid in its store; None for the study's own.

    Raises:
        InputError: the record is no name.
    """
    return next(iter(store.records(NOTE, _name)), None)


def _name(content: object) -> str:
    if not isinstance(content, str):
        raise TypeError("a name is a text")
    return content
