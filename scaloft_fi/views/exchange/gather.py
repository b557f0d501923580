"""A campaign and its study as the dossier that evidence is written from."""

from __future__ import annotations

from datetime import date
from functools import partial
from pathlib import Path

from scaloft_fi.defaults import SEARCHED
from scaloft_fi.document import is_there, read_text
from scaloft_fi.sim.grids import FOLDER
from scaloft_fi.study import Study
from scaloft_fi.version import __version__
from scaloft_fi.views.exchange.archive import archive_files
from scaloft_fi.views.exchange.dossier import Dossier
from scaloft_fi.views.snapshot import snapshot


def dossier(study: Study, campaign: str, today: date | None = None) -> Dossier:
    """The dossier of a campaign.

    Args:
        study: the study, with any of its grids.
        campaign: name of the campaign.
        today: the day by which dispositions expire; by default the system's date.

    Raises:
        InputError: there is no campaign, or it holds no outcome that counts.
    """
    with snapshot(study, campaign) as now:
        study = now.study
        outcomes, platform, spending = now.outcomes, now.platform, now.spending
    item, cells = study.grid.item, sorted((study.folder / "hazop").rglob("*.yaml"))
    return Dossier(
        study=study.name,
        campaign=Path(now.name).name,
        version=__version__,
        platform=platform,
        matrix=study.matrix,
        space=study.space,
        roster=study.roster,
        requirements=study.requirements,
        outcomes=outcomes,
        spending=spending,
        sources={path.relative_to(study.folder).as_posix(): read_text(path) for path in cells},
        grid_file=item.path.relative_to(study.folder).as_posix() if item else "",
        finds=study.finds,
        deterministic=study.stack.deterministic,
        archive=partial(archive_files, study, campaign),
        searchable=not study.packaged and is_there(study.folder / "sim" / FOLDER / f"{SEARCHED}.yaml"),
        dispositions=study.dispositions,
        today=today or date.today(),  # noqa: DTZ011 - the user's own day
    )
