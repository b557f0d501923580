"""What a report is made from: a study, and the outcomes of one campaign with their tracks."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import date

from scaloft_fi.campaign.held.folder import STORE_NAME
from scaloft_fi.campaign.held.held import current, held
from scaloft_fi.campaign.held.tracks import with_tracks
from scaloft_fi.results.outcome import Outcome
from scaloft_fi.results.scoring.detection import Spending
from scaloft_fi.results.store import Store
from scaloft_fi.study import Study


@dataclass(frozen=True)
class Evidence:
    """All that the page tells.

    Attributes:
        study: what was flown.
        campaign: its name, as `--campaign` takes it.
        outcomes: those that the study still stands for, with their tracks.
        stale, owed: flights that it has outgrown; flights planned and not flown.
        fingerprint: of the platform that flew them, by name.
        today: by which dispositions expire; None = none does.
        spending: how the campaign spends alpha.
    """

    study: Study
    campaign: str
    outcomes: tuple[Outcome, ...]
    stale: int = 0
    owed: int = 0
    fingerprint: Mapping[str, str] | None = None
    today: date | None = None
    spending: Spending = field(default_factory=Spending)


def gather(study: Study, campaign: str, today: date | None = None) -> Evidence:
    """Read the campaign; `today` is the day by which dispositions expire.

    Raises:
        InputError: there is none, or it holds no flight that counts.
    """
    known, found = current(study, campaign), held(study, campaign)
    outcomes = with_tracks(study, campaign, known, {outcome.mutant for outcome in known})
    with Store(found.folder / STORE_NAME, create=False) as store:
        return Evidence(study, campaign, outcomes, found.stale, found.owed, store.meta(), today)
