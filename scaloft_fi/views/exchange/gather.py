"""A campaign and its study as the dossier that evidence is written from."""

from __future__ import annotations

from scaloft_fi import __version__
from scaloft_fi.campaign.runs.spending import spending_of
from scaloft_fi.campaign.store.folder import campaign_folder, existing
from scaloft_fi.campaign.store.held import current
from scaloft_fi.campaign.store.store import Store
from scaloft_fi.study import Study
from scaloft_fi.views.exchange.dossier import Dossier


def dossier(study: Study, campaign: str) -> Dossier:
    """The dossier of a campaign.

    Raises:
        InputError: there is no campaign, or it holds no outcome that counts.
    """
    folder = campaign_folder(study, campaign)
    outcomes = current(study, campaign)
    with Store(existing(folder), create=False) as store:
        platform, spending = store.meta(), spending_of(study, store)
    cells = sorted((study.folder / "hazop").rglob("*.yaml"))
    return Dossier(
        study=study.folder.resolve().name,
        campaign=folder.name,
        version=__version__,
        platform=platform,
        matrix=study.matrix,
        space=study.space,
        roster=study.roster,
        requirements=study.requirements,
        outcomes=outcomes,
        spending=spending,
        sources={path.relative_to(study.folder).as_posix(): path.read_text(encoding="utf-8") for path in cells},
    )
