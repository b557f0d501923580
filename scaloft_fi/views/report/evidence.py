"""What a report is made from: a study, and the outcomes of one campaign with their tracks."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import date

from scaloft_fi.analysis.scoring.detection import Spending
from scaloft_fi.campaign.runs.spending import spending_of
from scaloft_fi.campaign.store.folder import campaign_folder, existing
from scaloft_fi.campaign.store.held import held_in, nothing_to_show
from scaloft_fi.campaign.store.store import Store
from scaloft_fi.campaign.store.tracks import tracks_in
from scaloft_fi.judge.outcome import Outcome
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
    """Read the campaign, all of it at one moment; `today` is the day by which dispositions expire.

    Raises:
        InputError: there is none, or it holds no flight that counts.
    """
    folder = campaign_folder(study, campaign)
    with Store(existing(folder), create=False) as store, store.snapshot():
        found = held_in(study, store, folder)
        known = found.current or nothing_to_show(store, folder)
        outcomes = tracks_in(study, store, known, {outcome.mutant for outcome in known})
        spending = spending_of(study, store)
        return Evidence(study, campaign, outcomes, found.stale, found.owed, store.meta(), today, spending)
